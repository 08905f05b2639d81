// Which pieces of a character's skin belong to different limbs, though they may touch or cross in space: two
// thighs, an arm and the chest, two fingers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/build/body.h"
#include "host/build/partings.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// When two pieces of skin belong to different limbs.
struct Separation {
  double distance = 0.0;   // the way along the skin's edges between them is longer than this, m
  double in_common = 0.0;  // and their joints' shares have less than this in common: sum of min(w_a, w_b)
};

class Limbs {
 public:
  // `weights` holds a row for each vertex of the skin; without any, all skin is one limb. The arguments must
  // outlive it.
  // With `partings`, skin of one part that touches and parts in a clip is of different limbs too, whatever
  // its weights have in common.
  Limbs(const mesh::SurfaceMesh& skin, const SkinWeights& weights, const std::vector<rig::Joint>& skeleton,
        Separation separation, const Partings* partings = nullptr);

  // Whether two sets of triangles belong to different limbs: any triangle of one has too little in common
  // with the mean of the other, and the way between them is long enough. Where there is no way at all, as
  // between an eye and its head, neither may a joint of one be the parent of a joint of the other.
  bool are_apart(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;

  // Triangles put together by limb: first those that share corners; then each such patch, the largest first,
  // goes to patches that it is not apart from, to all of a group or none. Ascending by first triangle.
  std::vector<std::vector<std::uint32_t>> groups_of(std::span<const std::uint32_t> triangles) const;

 private:
  struct Share {
    std::uint32_t joint;
    double weight;
  };
  std::vector<Share> shares_of(std::span<const std::uint32_t> triangles) const;
  static double in_common(const std::vector<Share>& a, const std::vector<Share>& b);
  // Whether any of the triangles has less in common with the shares than the separation asks.
  bool has_stranger(std::span<const std::uint32_t> triangles, const std::vector<Share>& shares) const;
  bool are_kin(const std::vector<Share>& a, const std::vector<Share>& b) const;
  // Whether the way along edges from one set of triangles to the other is at most the distance.
  bool are_within_reach(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;

  // Whether any triangle of one part of the skin touches one of the others and parts from it in a clip.
  bool do_part(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;

  const mesh::SurfaceMesh& skin_;
  const SkinWeights& weights_;
  const std::vector<rig::Joint>& skeleton_;
  Separation separation_;
  const Partings* partings_;
  std::vector<std::uint32_t> edge_offset_, edge_end_;  // the skin's edges by vertex, CSR
  std::vector<std::uint32_t> part_;                    // of each vertex
};

}  // namespace fascicle::build
