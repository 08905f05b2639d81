#include "host/bake/look_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "host/bake/points.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"

namespace fascicle::bake {

namespace {

// A weight above this counts as a vertex's whole weight.
constexpr double whole_weight = 0.98;

std::vector<std::uint32_t> places_of(const std::vector<float>& rest) {
  std::map<std::array<float, 3>, std::uint32_t> numbers;
  std::vector<std::uint32_t> places;
  for (std::size_t i = 0; i < rest.size(); i += 3) {
    // -0 and 0 are the same place.
    const std::array<float, 3> at{rest[i] + 0.0f, rest[i + 1] + 0.0f, rest[i + 2] + 0.0f};
    places.push_back(numbers.try_emplace(at, static_cast<std::uint32_t>(numbers.size())).first->second);
  }
  return places;
}

// The mean length of the edges around each vertex's place.
std::vector<double> mean_edges(const LookBody& body) {
  std::vector<double> sum(body.place.size(), 0.0), count(body.place.size(), 0.0);
  for (std::size_t t = 0; t < body.triangle.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = body.triangle[t + k], b = body.triangle[t + (k + 1) % 3];
      const double edge = length(difference(point_at(body.rest, a), point_at(body.rest, b)));
      for (const std::uint32_t end : {a, b}) {
        sum[body.place[end]] += edge;
        count[body.place[end]] += 1.0;
      }
    }
  std::vector<double> edges(body.place.size(), 0.0);
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (const std::uint32_t at = body.place[i]; count[at] > 0.0) edges[i] = sum[at] / count[at];
  return edges;
}

// Twice the mean edge of the tetrahedron that each render vertex is embedded in.
std::vector<double> least_thickness(const model::Model& model) {
  std::vector<double> least(model.surface_count(), 0.0);
  for (std::size_t s = 0; s < least.size(); ++s) {
    double sum = 0.0;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b)
        sum += length(difference(point_at(model.rest, model.surface_vertex[4 * s + a]),
                                 point_at(model.rest, model.surface_vertex[4 * s + b])));
    least[s] = sum / 3.0;
  }
  return least;
}

std::vector<double> thicknesses(const model::Model& model, const LookBody& body) {
  const std::vector<float> normals = formats::SurfaceNormals(model).of(body.rest);
  const TriangleTree tree(body.triangle, body.place, body.rest);
  const std::vector<double> least = least_thickness(model);
  std::vector<double> thickness(body.place.size(), 0.0), found;
  for (std::size_t i = 0; i < thickness.size(); ++i) {
    const Point out = point_at(normals, i);
    if (const auto hit = tree.hit(point_at(body.rest, i), {-out[0], -out[1], -out[2]}, body.place[i]))
      found.push_back(thickness[i] = *hit);
  }
  double median = 0.0;
  if (!found.empty()) {
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end());
    median = *middle;
  }
  for (std::size_t i = 0; i < thickness.size(); ++i)
    thickness[i] = std::max(thickness[i] > 0.0 ? thickness[i] : median, least[i]);
  return thickness;
}

// By the weights of the tetrahedra that the render vertices are embedded in.
std::vector<std::uint32_t> main_joints(const model::Model& model) {
  std::vector<std::uint32_t> joints(model.surface_count(), 0);
  std::vector<double> weight(model.joint_count, 0.0);
  for (std::size_t s = 0; s < joints.size(); ++s) {
    std::fill(weight.begin(), weight.end(), 0.0);
    for (std::size_t k = 4 * s; k < 4 * s + 4; ++k) {
      const std::uint32_t i = model.surface_vertex[k];
      for (std::uint32_t e = model.skin_offset[i]; e < model.skin_offset[i + 1]; ++e)
        weight[model.skin_joint[e]] += double{model.surface_weight[k]} * double{model.skin_weight[e]};
    }
    joints[s] = static_cast<std::uint32_t>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  }
  return joints;
}

// The joint that has a vertex's whole weight; -1 if there is none.
std::int64_t only_joint(const rig::Character& character, std::size_t vertex) {
  std::int64_t found = -1;
  double most = 0.0;
  std::map<std::uint32_t, double> weight;
  for (std::size_t k = 0; k < 8; ++k) {
    double& sum = weight[character.joints[vertex][k]];
    sum += character.weights[vertex][k];
    if (sum <= most) continue;
    most = sum;
    found = character.joints[vertex][k];
  }
  return most >= whole_weight ? found : -1;
}

// Disjoint sets (union-find).
class Unions {
 public:
  explicit Unions(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    const std::size_t x = root(a), y = root(b);
    parent_[std::max(x, y)] = std::min(x, y);
  }

 private:
  std::vector<std::size_t> parent_;
};

std::vector<LookBody::RigidPart> rigid_parts(const LookBody& body, const rig::Character& character) {
  std::vector<std::size_t> part(body.place.size(), 0);
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    const rig::SurfacePart& one = character.parts[p];
    for (std::size_t v = 0; v < one.vertex_count && one.first_vertex + v < part.size(); ++v)
      part[one.first_vertex + v] = p;
  }
  // Vertices at one place are merged within each object and material.
  std::map<std::pair<std::size_t, std::uint32_t>, std::size_t> numbers;
  std::vector<std::size_t> spot(part.size());
  for (std::size_t v = 0; v < spot.size(); ++v)
    spot[v] = numbers.try_emplace({part[v], body.place[v]}, numbers.size()).first->second;
  Unions joined(numbers.size());
  for (std::size_t t = 0; t < body.triangle.size(); t += 3)
    for (std::size_t k = 1; k < 3; ++k) joined.join(spot[body.triangle[t]], spot[body.triangle[t + k]]);
  constexpr std::int64_t unseen = -2;
  std::vector<std::int64_t> joint(numbers.size(), unseen);
  for (std::size_t v = 0; v < spot.size(); ++v) {
    std::int64_t& of_part = joint[joined.root(spot[v])];
    const std::int64_t own = only_joint(character, v);
    of_part = of_part == unseen || of_part == own ? own : -1;
  }
  std::map<std::size_t, LookBody::RigidPart> parts;
  for (std::size_t t = 0; t < body.triangle.size(); t += 3) {
    const std::size_t root = joined.root(spot[body.triangle[t]]);
    if (joint[root] < 0) continue;
    LookBody::RigidPart& one = parts[root];
    one.joint = static_cast<std::uint32_t>(joint[root]);
    one.triangles.push_back(static_cast<std::uint32_t>(t / 3));
  }
  std::vector<LookBody::RigidPart> list;
  for (auto& [root, one] : parts) list.push_back(std::move(one));
  return list;
}

}  // namespace

LookBody look_body(const model::Model& model, const rig::Character* character) {
  LookBody body;
  body.rest = formats::embed(model, model.rest);
  body.triangle = model.surface_triangle;
  body.place = places_of(body.rest);
  body.edge = mean_edges(body);
  body.thickness = thicknesses(model, body);
  body.joint = main_joints(model);
  for (std::uint32_t j = 0; j < model.joint_count; ++j)
    body.joint_names.push_back(character != nullptr && j < character->skeleton.size()
                                   ? character->skeleton[j].name
                                   : "joint " + std::to_string(j));
  if (character != nullptr && character->joints.size() == body.place.size() &&
      character->weights.size() == body.place.size())
    body.rigid = rigid_parts(body, *character);
  return body;
}

}  // namespace fascicle::bake
