#include "tests/support/sliding_models.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "tests/support/test_models.h"

namespace fascicle::tests {

using Eigen::Vector3d;
using model::Model;

namespace {

Vector3d rest_place(const Model& model, std::uint32_t i) {
  return Vector3d(model.rest[3 * i], model.rest[3 * i + 1], model.rest[3 * i + 2]);
}

void drop_pairs(Model& model, const std::vector<bool>& is_skin) {
  std::vector<std::uint32_t> offset{0}, ring;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e) {
      const std::uint32_t j = model.ring[e];
      const bool both_free = !model.is_kinematic(i) && !model.is_kinematic(j);
      if (!both_free || is_skin[i] == is_skin[j]) ring.push_back(j);
    }
    offset.push_back(std::uint32_t(ring.size()));
  }
  model.ring_offset = offset;
  model.ring = ring;
}

// Among the triangles nearest to the vertex, takes the one that faces it with the largest height above its
// plane. Leaves mobilities at 0.
shader::Tie nearest_tie(const Model& model, const std::vector<bool>& is_skin, std::uint32_t s) {
  shader::Tie best{};
  double least = std::numeric_limits<double>::infinity(), highest = 0.0;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    std::vector<std::uint32_t> below;
    for (std::size_t k = 0; k < 4; ++k)
      if (!is_skin[model.tetrahedron[t + k]]) below.push_back(model.tetrahedron[t + k]);
    if (below.size() != 3) continue;
    const std::array<Vector3d, 3> x{rest_place(model, below[0]), rest_place(model, below[1]),
                                    rest_place(model, below[2])};
    const Vector3d b = nearest_weights(rest_place(model, s), x[0], x[1], x[2]);
    const double distance = (b[0] * x[0] + b[1] * x[1] + b[2] * x[2] - rest_place(model, s)).norm();
    const double height = (rest_place(model, s) - x[0]).dot((x[1] - x[0]).cross(x[2] - x[0]).normalized());
    const bool as_near = distance < least * (1.0 + 1e-9);
    if (!as_near || (distance > least * (1.0 - 1e-9) && std::abs(height) < highest * (1.0 + 1e-9))) continue;
    least = distance;
    highest = std::abs(height);
    if (height < 0.0) std::swap(below[1], below[2]);
    best = {s, below[0], below[1], below[2], 0.0f, 0.0f, 0.0f, float(highest)};
  }
  return best;
}

}  // namespace

Vector3d nearest_weights(const Vector3d& point, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const std::array<Vector3d, 3> x{a, b, c};
  std::vector<Vector3d> candidates{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
  for (int k = 0; k < 3; ++k) {
    const Vector3d &from = x[std::size_t(k)], &to = x[std::size_t((k + 1) % 3)];
    const double u = (point - from).dot(to - from) / (to - from).squaredNorm();
    Vector3d weights = Vector3d::Zero();
    weights[k] = 1.0 - u;
    weights[(k + 1) % 3] = u;
    if (u > 0.0 && u < 1.0) candidates.push_back(weights);
  }
  Eigen::Matrix3d frame;
  frame << b - a, c - a, (b - a).cross(c - a);
  const Vector3d inside = frame.inverse() * (point - a);
  if (inside[0] > 0.0 && inside[1] > 0.0 && inside[0] + inside[1] < 1.0)
    candidates.emplace_back(1.0 - inside[0] - inside[1], inside[0], inside[1]);
  const auto distance = [&](const Vector3d& w) { return (w[0] * a + w[1] * b + w[2] * c - point).norm(); };
  return *std::min_element(candidates.begin(), candidates.end(),
                           [&](const Vector3d& v, const Vector3d& w) { return distance(v) < distance(w); });
}

void add_sliding(Model& model, const std::function<bool(const Vector3d&)>& is_skin_at) {
  model.layers.push_back({"skin", model.layers[0].damping, model.layers[0].density, false});
  std::vector<bool> is_skin;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    is_skin.push_back(is_skin_at(rest_place(model, i)));
    if (is_skin[i])
      model.tag[i] = (model.tag[i] & ~shader::tag_layer_mask) | std::uint32_t(model.layers.size() - 1);
  }
  drop_pairs(model, is_skin);
  for (std::uint32_t s = 0; s < model.vertex_count; ++s)
    if (is_skin[s] && !model.is_kinematic(s)) model.tie.push_back(nearest_tie(model, is_skin, s));

  const auto corners = [](const shader::Tie& t) { return std::array{t.corner_a, t.corner_b, t.corner_c}; };
  std::vector<int> ties_at(model.vertex_count, 0);
  for (const shader::Tie& t : model.tie)
    for (const std::uint32_t j : corners(t)) ++ties_at[j];
  // The mobility of i relative to the sliding vertex.
  const auto ratio = [&](const shader::Tie& t, std::uint32_t i) {
    return model.is_kinematic(i) ? 0.0 : model.mass[t.sliding] / model.mass[i];
  };
  for (shader::Tie& t : model.tie) {
    t.mobility_a = float(ties_at[t.corner_a] * ratio(t, t.corner_a));
    t.mobility_b = float(ties_at[t.corner_b] * ratio(t, t.corner_b));
    t.mobility_c = float(ties_at[t.corner_c] * ratio(t, t.corner_c));
  }
  model.tie_offset = {0};
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    for (std::uint32_t k = 0; k < model.tie.size(); ++k) {
      const auto of = corners(model.tie[k]);
      if (model.is_kinematic(i)) continue;
      if (model.tie[k].sliding != i && std::find(of.begin(), of.end(), i) == of.end()) continue;
      model.tie_index.push_back(k);
      // A substep corrects half of the error.
      model.tie_coefficient.push_back(float(0.5 * ratio(model.tie[k], i)));
    }
    model.tie_offset.push_back(std::uint32_t(model.tie_index.size()));
  }
  fill_weights(model);
}

Model bar_with_skin(bool held) {
  BodyOptions options;
  if (held) options.kinematic = [](const Vector3d& p) { return p.x() < 0.03; };
  Model model = make_model(jittered(kuhn_bar(6, 3, 3, 0.125), 0.125 / 64.0, 3, 5), options);
  add_sliding(model, [](const Vector3d& p) { return p.y() > 0.33 || p.z() > 0.33; });
  return model;
}

void displace_skin(const Model& model, const Vector3d& offset, std::vector<float>& positions) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.layer_of(i) + 1 == model.layers.size())
      for (std::size_t k = 0; k < 3; ++k) positions[3 * i + k] += float(offset[int(k)]);
}

}  // namespace fascicle::tests
