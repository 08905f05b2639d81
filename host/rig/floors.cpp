#include "host/rig/floors.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>

#include <Eigen/Geometry>

#include "host/base/flat.h"

namespace fascicle::rig {

namespace {

constexpr double hard_weight = 0.99, least_length = 2.0;
constexpr std::uint32_t no_joint = 0xffffffffU;

// The joint that moves a vertex by at least hard_weight, or no_joint.
std::uint32_t only_joint(const Character& character, std::uint32_t vertex) {
  const std::array<double, 8>& weights = character.weights[vertex];
  const auto most = std::max_element(weights.begin(), weights.end());
  return *most >= hard_weight ? character.joints[vertex][static_cast<std::size_t>(most - weights.begin())]
                              : no_joint;
}

struct Part {
  std::vector<std::uint32_t> vertices;
  std::vector<std::array<double, 3>> places;
  Eigen::AlignedBox3d box;
  std::uint32_t joint = no_joint;  // the only one
};

// Of vertices that triangles have.
std::vector<Part> parts_of(const Character& character) {
  const mesh::SurfaceMesh& surface = character.surface;
  std::vector<std::uint32_t> parent(surface.vertices.size());
  std::map<std::array<double, 3>, std::uint32_t> at;
  for (std::uint32_t v = 0; v < parent.size(); ++v) {
    const Eigen::Vector3d& p = surface.vertices[v];
    parent[v] = at.try_emplace({p.x(), p.y(), p.z()}, v).first->second;
  }
  const auto root = [&parent](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<char> is_used(surface.vertices.size(), 0);
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t corner : triangle) {
      if (*std::max_element(triangle.begin(), triangle.end()) >= parent.size()) break;
      is_used[corner] = 1;
      parent[root(corner)] = root(triangle[0]);
    }
  std::vector<Part> parts;
  std::map<std::uint32_t, std::size_t> part_of;  // root, part
  for (std::uint32_t v = 0; v < parent.size(); ++v) {
    if (is_used[v] == 0) continue;
    const auto [entry, is_new] = part_of.try_emplace(root(v), parts.size());
    const std::uint32_t joint = only_joint(character, v);
    if (is_new) parts.emplace_back().joint = joint;
    Part& part = parts[entry->second];
    const Eigen::Vector3d& p = surface.vertices[v];
    part.vertices.push_back(v);
    part.places.push_back({p.x(), p.y(), p.z()});
    part.box.extend(p);
    if (joint != part.joint) part.joint = no_joint;
  }
  return parts;
}

}  // namespace

std::vector<char> on_floors(const Character& character) {
  std::vector<char> result(character.surface.vertices.size(), 0);
  if (character.joints.size() < result.size() || character.weights.size() < result.size()) return result;
  const std::vector<Part> parts = parts_of(character);
  std::vector<const Part*> sheets;
  Eigen::AlignedBox3d rest;
  for (const Part& part : parts) {
    if (part.joint != no_joint && base::is_flat(part.places))
      sheets.push_back(&part);
    else
      rest.extend(part.box);
  }
  if (rest.isEmpty()) return result;
  const Eigen::Vector3d middle = rest.center();
  for (const Part* sheet : sheets) {
    // A wing is beside the body, and a floor below it.
    Eigen::Index shortest = 0;
    sheet->box.sizes().minCoeff(&shortest);
    Eigen::AlignedBox3d column = sheet->box;
    column.min()[shortest] = column.max()[shortest] = middle[shortest];
    if (!column.contains(middle)) continue;
    if (sheet->box.diagonal().norm() > least_length * rest.diagonal().norm())
      for (const std::uint32_t v : sheet->vertices) result[v] = 1;
  }
  return result;
}

}  // namespace fascicle::rig
