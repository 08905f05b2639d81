#include "cpu_reference/oracle/oracle_tie.h"

#include <set>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace fascicle::cpu_reference {

using Eigen::Vector3d;

namespace {

// All ties together correct at most this share of a vertex's error.
constexpr double share_of_a_substep = 0.5;

}  // namespace

Ties::Ties(const model::Model& model) : looks_ahead_(model.is_implicit()) {
  const Points rest = points_of(model.rest);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    mobility_.push_back(model.is_kinematic(i) ? 0.0 : 1.0 / model.mass[i]);
  ties_at_.resize(model.vertex_count);
  for (const shader::Tie& t : model.tie) {
    const Vector3d &x = rest[t.corner_a], u = rest[t.corner_b] - x, v = rest[t.corner_c] - x;
    springs_.push_back({.sliding = t.sliding,
                        .corners = {t.corner_a, t.corner_b, t.corner_c},
                        .rest_height = (rest[t.sliding] - x).dot(u.cross(v).normalized())});
    for (const std::uint32_t j : springs_.back().corners) ++ties_at_[j];
  }
}

// A tie uses the whole mass of its sliding vertex, and of a corner's mass the part that each tie there gets.
// A displacement C along n is undone for its four vertices with k = 1 / (1/m_s + sum b_j^2 / (m_j / n_j)).
Points Ties::accelerations(const Points& q, const Points& v, double h) const {
  Points a(q.size(), Vector3d::Zero());
  const auto place = [&](std::uint32_t i) { return looks_ahead_ ? Vector3d(q[i] + h * v[i]) : q[i]; };
  for (const auto& [s, corners, rest_height] : springs_) {
    const Vector3d origin = place(corners[0]);
    Eigen::Matrix3d frame;  // two edges and the normal
    frame.col(0) = place(corners[1]) - origin;
    frame.col(1) = place(corners[2]) - origin;
    frame.col(2) = frame.col(0).cross(frame.col(1)).normalized();
    const Vector3d in_frame = frame.inverse() * (place(s) - origin);
    const Vector3d b(1.0 - in_frame[0] - in_frame[1], in_frame[0], in_frame[1]);
    double compliance = mobility_[s];
    for (int j = 0; j < 3; ++j)
      compliance += b[j] * b[j] * ties_at_[corners[std::size_t(j)]] * mobility_[corners[std::size_t(j)]];
    const double C = in_frame[2] - rest_height;
    const Vector3d force = share_of_a_substep / compliance * C / (h * h) * frame.col(2);
    a[s] -= mobility_[s] * force;
    for (int j = 0; j < 3; ++j)
      a[corners[std::size_t(j)]] += mobility_[corners[std::size_t(j)]] * b[j] * force;
  }
  return a;
}

std::vector<bool> sliding_vertices(const model::Model& model) {
  std::set<std::uint32_t> layers;
  for (const shader::Tie& t : model.tie) layers.insert(model.layer_of(t.sliding));
  std::vector<bool> slides(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) slides[i] = layers.contains(model.layer_of(i));
  return slides;
}

}  // namespace fascicle::cpu_reference
