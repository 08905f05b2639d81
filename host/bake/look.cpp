#include "host/bake/look.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/LU>

#include "host/bake/points.h"
#include "host/drive/felt_acceleration.h"
#include "host/formats/surface.h"

namespace fascicle::bake {

namespace {

Point edge_of(const std::vector<float>& positions, std::uint32_t from, std::uint32_t to) {
  return difference(point_at(positions, to), point_at(positions, from));
}

// Dot products of a triangle's two edges from its first corner: they determine its shape.
struct Shape {
  double uu = 0.0, uv = 0.0, vv = 0.0;
  double determinant() const { return uu * vv - uv * uv; }
};

Shape shape_of(const std::vector<float>& positions, const std::uint32_t* corners) {
  const Point u = edge_of(positions, corners[0], corners[1]), v = edge_of(positions, corners[0], corners[2]);
  return {dot(u, u), dot(u, v), dot(v, v)};
}

// The largest and smallest stretch of the triangle `from` when it becomes `to`; empty if `from` is
// degenerate.
struct Stretch {
  double longest = 1.0, shortest = 1.0;
};
std::optional<Stretch> stretch_between(const Shape& from, const Shape& to) {
  const double area = from.determinant();
  // A height below 1e-4 of the longer edge counts as rounding error of floats.
  const double longest = std::max(from.uu, from.vv);
  if (!(area > 1e-8 * longest * longest)) return std::nullopt;
  const double half = 0.5 * ((from.uu * to.vv - 2.0 * from.uv * to.uv) + from.vv * to.uu) / area;
  const double product = std::max(to.determinant(), 0.0) / area;
  const double root = std::sqrt(std::max(half * half - product, 0.0));
  const double most = std::max(half + root, 0.0);
  return Stretch{std::sqrt(most), most > 0.0 ? std::sqrt(product / most) : 0.0};
}

// The value that `share` of all values exceed, with its item. Reorders the list.
std::pair<double, std::uint32_t> high(std::vector<std::pair<double, std::uint32_t>>& values, double share) {
  if (values.empty()) return {0.0, 0};
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  const auto at = values.begin() + rank;
  std::nth_element(values.begin(), at, values.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  return *at;
}

bool is_inverted(const std::vector<float>& positions, const std::uint32_t* corners) {
  return !(determinant(edge_of(positions, corners[0], corners[1]), edge_of(positions, corners[0], corners[2]),
                       edge_of(positions, corners[0], corners[3])) > 0.0);
}

// Whether all vertices that this render vertex is embedded in follow the skeleton.
bool follows(const model::Model& model, std::uint32_t s) {
  for (std::size_t k = 4 * std::size_t{s}; k < 4 * std::size_t{s} + 4; ++k)
    if (model.surface_weight[k] != 0.0f && !model.is_kinematic(model.surface_vertex[k])) return false;
  return true;
}

// The limits: what looks right is below, what does not is above (tests/bake/look_test.cpp).
constexpr double stretch_limit = 2.7;
constexpr double crossing_share = 0.022, crossing_least = 24.0;  // of all triangles, and at least this many
constexpr double rigid_limit = 0.1;
constexpr double jump_limit = 0.6, jump_limit_fps = 60.0;  // at this rate and above
// This share of all tetrahedra may be inside out in addition: invisible slivers.
constexpr double inverted_ratio = 1.2, inverted_share = 0.0005;

}  // namespace

const char* name_of(LookMeasure measure) {
  switch (measure) {
    case LookMeasure::stretch:
      return "stretch";
    case LookMeasure::crossing:
      return "crossing";
    case LookMeasure::distance:
      return "distance";
    case LookMeasure::rigid:
      return "rigid";
    case LookMeasure::jump:
      return "jump";
    case LookMeasure::inverted:
      return "inverted";
  }
  return "";
}

bool has_look(const model::Model& model) {
  return model.has_skeleton() && !model.surface_triangle.empty();
}

std::optional<LookBody> look_body_of(const scene::Scene& scene, const model::Model& model) {
  if (!has_look(model)) return std::nullopt;
  return look_body(model, std::get_if<rig::Character>(&scene.geometry));
}

LookMeasure LookScores::cause() const {
  const auto worst = std::max_element(
      of.begin(), of.end(), [](const LookScore& a, const LookScore& b) { return a.score < b.score; });
  return static_cast<LookMeasure>(worst - of.begin());
}

Look::Look(const model::Model& model, const LookBody& body, double fps)
    : model_(model),
      body_(body),
      jump_limit_(jump_limit * std::max(1.0, jump_limit_fps / fps)),
      tree_(body.triangle, body.place, body.rest),
      vertices_(body.joint_names.size()) {
  for (std::uint32_t i = 0; i < body.joint.size(); ++i) vertices_[body.joint[i]].push_back(i);
  for (std::size_t t = 0; t < body.triangle.size(); t += 3) {
    const std::uint32_t* corners = &body.triangle[t];
    const Shape shape = shape_of(body.rest, corners);
    const double longest = std::max({shape.uu, shape.vv, shape.uu - 2.0 * shape.uv + shape.vv});
    const double height = std::sqrt(std::max(shape.determinant(), 0.0) / std::max(longest, 1e-300));
    const double edge = (body.edge[corners[0]] + body.edge[corners[1]] + body.edge[corners[2]]) / 3.0;
    // Half an edge: the height of half a square over its diagonal.
    follows_.push_back(std::all_of(corners, corners + 3, [&](std::uint32_t s) { return follows(model, s); }));
    trust_.push_back(edge > 0.0 ? std::min(1.0, height / (0.5 * edge)) : 0.0);
  }
}

std::uint32_t Look::joint_of_triangle(std::size_t triangle) const {
  return body_.joint[body_.triangle[3 * triangle]];
}

void Look::shift_history() {
  std::swap(deviation_[2], deviation_[1]);
  std::swap(deviation_[1], deviation_[0]);
}

void Look::remember(const model::Frame& frame) {
  const std::vector<float> flesh = formats::embed(model_, frame.positions),
                           skin = formats::embed(model_, frame.skinned);
  shift_history();
  deviation_[0].resize(flesh.size());
  for (std::size_t i = 0; i < flesh.size(); ++i) deviation_[0][i] = flesh[i] - skin[i];
}

LookScores Look::of(const model::Frame& frame) {
  const std::vector<float> flesh = formats::embed(model_, frame.positions),
                           skin = formats::embed(model_, frame.skinned);
  shift_history();
  deviation_[0].resize(flesh.size());
  for (std::size_t i = 0; i < flesh.size(); ++i) deviation_[0][i] = flesh[i] - skin[i];
  LookScores scores;
  scores.of = {stretch(flesh, skin), crossing(flesh, skin), distance(), rigid(flesh), jump(),
               inverted(frame)};
  return scores;
}

LookScore Look::stretch(const std::vector<float>& flesh, const std::vector<float>& skin) {
  values_.clear();
  for (std::size_t t = 0; t < trust_.size(); ++t) {
    const std::uint32_t* corners = &body_.triangle[3 * t];
    const Shape now = shape_of(flesh, corners);
    const auto rest = stretch_between(shape_of(body_.rest, corners), now);
    if (!rest) continue;
    double longest = rest->longest;
    if (const auto skinned = stretch_between(shape_of(skin, corners), now))
      longest = std::min(longest, skinned->longest);
    values_.emplace_back(1.0 + (longest - 1.0) * trust_[t], static_cast<std::uint32_t>(t));
  }
  const auto [value, t] = high(values_, 0.001);
  return {value, stretch_limit, std::max(value - 1.0, 0.0) / (stretch_limit - 1.0),
          values_.empty() ? 0 : joint_of_triangle(t)};
}

LookScore Look::worst_joint(const std::vector<double>& values, double share, double limit) {
  LookScore worst{.limit = limit};
  for (std::uint32_t j = 0; j < vertices_.size(); ++j) {
    if (vertices_[j].size() < least_skin_vertices) continue;
    values_.clear();
    for (const std::uint32_t i : vertices_[j]) values_.emplace_back(values[i], i);
    const double value = high(values_, share).first;
    if (value > worst.value) worst = {value, limit, value / limit, j};
  }
  return worst;
}

LookScore Look::crossing(const std::vector<float>& flesh, const std::vector<float>& skin) {
  tree_.fit(flesh);
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> found = tree_.crossings({}, follows_);
  LookScore score;
  if (found.empty()) return score;
  const auto joints = [this](const std::pair<std::uint32_t, std::uint32_t>& triangles) {
    return std::minmax({joint_of_triangle(triangles.first), joint_of_triangle(triangles.second)});
  };
  // In the skinned shape, test only triangles of these joints.
  std::vector<std::uint8_t> has_crossed(body_.joint_names.size(), 0), asked(trust_.size());
  for (const auto& [a, b] : found) has_crossed[joint_of_triangle(a)] = has_crossed[joint_of_triangle(b)] = 1;
  for (std::size_t t = 0; t < asked.size(); ++t) asked[t] = has_crossed[joint_of_triangle(t)];
  tree_.fit(skin);
  std::set<std::pair<std::uint32_t, std::uint32_t>> skinned;
  for (const auto& triangles : tree_.crossings(asked)) skinned.insert(joints(triangles));
  std::set<std::uint32_t> crossing;
  for (const auto& triangles : found)
    if (!skinned.contains(joints(triangles))) crossing.insert({triangles.first, triangles.second});
  std::vector<std::uint32_t> at_joint(body_.joint_names.size(), 0);
  for (const std::uint32_t t : crossing) ++at_joint[joint_of_triangle(t)];
  score.value = static_cast<double>(crossing.size());
  score.limit = std::max(crossing_least, crossing_share * static_cast<double>(trust_.size()));
  score.score = score.value / score.limit;
  score.joint =
      static_cast<std::uint32_t>(std::max_element(at_joint.begin(), at_joint.end()) - at_joint.begin());
  return score;
}

LookScore Look::distance() {
  std::vector<double> far(body_.thickness.size());
  for (std::size_t i = 0; i < far.size(); ++i) {
    far[i] = length(point_at(deviation_[0], i)) / body_.thickness[i];
  }
  const LookScore half = worst_joint(far, 0.5, half_distance_limit);
  const LookScore tenth = worst_joint(far, 0.1, tenth_distance_limit);
  return half.score >= tenth.score ? half : tenth;
}

LookScore Look::rigid(const std::vector<float>& flesh) {
  LookScore worst;
  for (const LookBody::RigidPart& part : body_.rigid) {
    values_.clear();
    for (const std::uint32_t t : part.triangles) {
      const std::uint32_t* corners = &body_.triangle[std::size_t{3} * t];
      const auto s = stretch_between(shape_of(body_.rest, corners), shape_of(flesh, corners));
      if (s) values_.emplace_back(std::max(s->longest - 1.0, 1.0 - s->shortest) * trust_[t], t);
    }
    const double value = high(values_, 0.1).first;
    if (value > worst.value) worst = {value, rigid_limit, value / rigid_limit, part.joint};
  }
  return worst;
}

LookScore Look::jump() {
  if (deviation_[2].size() != deviation_[0].size()) return {.limit = jump_limit_};
  std::vector<double> change(body_.thickness.size());
  for (std::size_t i = 0; i < change.size(); ++i) {
    Point way;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t c = 3 * i + axis;
      way[axis] = (double{deviation_[0][c]} - 2.0 * double{deviation_[1][c]}) + double{deviation_[2][c]};
    }
    change[i] = length(way) / body_.thickness[i];
  }
  return worst_joint(change, 0.5, jump_limit_);
}

LookScore Look::inverted(const model::Frame& frame) const {
  double flesh = 0.0, skin = 0.0;
  std::vector<std::uint32_t> at_joint(body_.joint_names.size(), 0);
  for (std::size_t t = 0; t < model_.tetrahedron.size(); t += 4) {
    const std::uint32_t* corners = &model_.tetrahedron[t];
    const bool of_skin = is_inverted(frame.skinned, corners);
    skin += of_skin ? 1.0 : 0.0;
    if (!is_inverted(frame.positions, corners)) continue;
    flesh += 1.0;
    const std::uint32_t i = corners[0];
    if (of_skin) continue;
    ++at_joint[drive::main_joint(model_, i)];
  }
  const double few = inverted_share * static_cast<double>(model_.tetrahedron_count());
  const double limit = inverted_ratio * skin + few;
  return {flesh, limit, flesh / limit,
          static_cast<std::uint32_t>(std::max_element(at_joint.begin(), at_joint.end()) - at_joint.begin())};
}

}  // namespace fascicle::bake
