// Restores the bind pose. FBX nodes have the pose in which the file was saved, often in the middle of a clip.
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "host/convert/character.h"

namespace fascicle::convert {
namespace {

struct Bound {
  std::size_t node = 0, mesh_node = 0;
  Matrix offset;  // from the space of the mesh's node to that of the bone, in the bind pose
};

std::vector<Bound> bound_nodes(const Character& character) {
  std::vector<Bound> result;
  for (std::size_t m = 0; m < character.nodes.size(); ++m)
    for (const aiMesh* mesh : character.nodes[m].meshes)
      for (unsigned b = 0; b < mesh->mNumBones; ++b) {
        const std::size_t node = find_node(character, mesh->mBones[b]->mName.C_Str());
        const Matrix offset = bind_offset(character.nodes[m], *mesh->mBones[b]);
        // Written so that NaN is skipped too.
        if (node < character.nodes.size() && offset.allFinite() && std::abs(offset.determinant()) > 1e-30)
          result.push_back({node, m, offset});
      }
  return result;
}

// Whether, for every mesh, one matrix maps the whole skin from the bind pose to the current pose of the
// nodes.
bool is_bound_here(const std::vector<Bound>& bound, const std::vector<Matrix>& global) {
  double size = 0.0, most_off = 0.0, most_turned = 0.0;
  for (const Bound& each : bound)
    size = std::max(
        size, (global[each.node].topRightCorner<3, 1>() - global[bound.front().node].topRightCorner<3, 1>())
                  .norm());
  std::size_t first = 0;
  for (std::size_t b = 0; b < bound.size(); ++b) {
    if (bound[b].mesh_node != bound[first].mesh_node) first = b;
    const Matrix here = global[bound[b].node] * bound[b].offset;
    const Matrix there = global[bound[first].node] * bound[first].offset;
    most_turned = std::max(most_turned, (here - there).topLeftCorner<3, 3>().norm() /
                                            std::max(there.topLeftCorner<3, 3>().norm(), 1e-30));
    most_off = std::max(most_off, (here - there).topRightCorner<3, 1>().norm());
  }
  // Single-precision error through a chain of joints; another pose differs by far more.
  constexpr double rounding = 1e-3;
  return most_turned < rounding && most_off <= rounding * size;
}

bool is_same(const Matrix& a, const Matrix& b) {
  return (a - b).norm() <= 1e-5 * a.norm();
}

}  // namespace

void rest_in_bind_pose(Character& character) {
  const std::vector<Matrix> saved = global_transforms(character.nodes);
  const std::vector<Bound> bound = bound_nodes(character);
  if (bound.empty() || is_bound_here(bound, saved)) return;

  std::vector<Matrix> rest(saved.size());
  std::vector<const Bound*> of_node(saved.size(), nullptr);
  for (const Bound& each : bound)
    if (of_node[each.node] == nullptr) of_node[each.node] = &each;
  std::vector<bool> is_moved(saved.size(), false);
  std::vector<Parts> saved_parts(saved.size());
  for (std::size_t n = 0; n < saved.size(); ++n) {
    Node& node = character.nodes[n];
    const Matrix above = node.parent < 0 ? Matrix::Identity() : rest[static_cast<std::size_t>(node.parent)];
    saved_parts[n] = parts_of(node.local);
    if (of_node[n] != nullptr && std::abs(above.determinant()) > 1e-30) {
      const Matrix local = above.inverse() * saved[of_node[n]->mesh_node] * of_node[n]->offset.inverse();
      is_moved[n] = local.allFinite() && !is_same(local, node.local);
      if (is_moved[n]) node.local = matrix_of(parts_of(local));
    }
    rest[n] = above * node.local;
  }
  for (Clip& clip : character.clips) {
    std::vector<bool> has_track(saved.size(), false);
    for (const Track& track : clip.tracks) has_track[track.node] = true;
    for (std::size_t n = 0; n < saved.size(); ++n)
      if (is_moved[n] && !has_track[n]) clip.tracks.push_back({n, {0.0}, {saved_parts[n]}});
  }
}

}  // namespace fascicle::convert
