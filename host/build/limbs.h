// Which pieces of a character's skin belong to different limbs, even if they touch or cross in space: two
// thighs, an arm and the chest, two fingers.
#pragma once

#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "host/build/body.h"
#include "host/build/partings.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// When two pieces of skin belong to different limbs: both must hold.
struct Separation {
  double distance = 0.0;   // the path along the skin's edges between them is longer than this, m
  double in_common = 0.0;  // their joints' weights overlap by less than this: sum of min(w_a, w_b)
};

class Limbs {
 public:
  // `weights` holds a row for each vertex of the skin; without weights, all skin is one limb. The arguments
  // must outlive this object.
  // With `partings`, skin of one part that touches at rest and parts in a clip also belongs to different
  // limbs, however much its weights overlap.
  Limbs(const mesh::SurfaceMesh& skin, const SkinWeights& weights, const std::vector<rig::Joint>& skeleton,
        Separation separation, const Partings* partings = nullptr);

  // Without weights, all skin is one limb.
  bool is_one_limb() const { return weights_.offset.empty(); }

  // Whether two sets of triangles belong to different limbs: any triangle of one has too little in common
  // with the mean of the other, and the path between them is long enough. If there is no path at all, as
  // between an eye and its head, it is also required that no joint of one is the parent of a joint of the
  // other.
  bool are_apart(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;

  // Groups triangles by limb. Triangles that share corners form patches. Each patch, the largest first, then
  // joins the first group in which it is apart from no patch, or starts a new one. Ascending by first
  // triangle.
  std::vector<std::vector<std::uint32_t>> groups_of(std::span<const std::uint32_t> triangles) const;

 private:
  struct Share {
    std::uint32_t joint;
    double weight;

    bool operator==(const Share&) const = default;
    bool operator<(const Share& other) const {
      return std::tie(joint, weight) < std::tie(other.joint, other.weight);
    }
  };
  // The weights of a set of triangles: their mean, and those of each that differ.
  struct Kind {
    std::vector<Share> mean;
    std::vector<std::vector<Share>> each;  // ascending

    bool operator<(const Kind& other) const {
      return std::tie(mean, each) < std::tie(other.mean, other.each);
    }
  };
  // A set of triangles to compare with many others.
  struct Patch {
    std::vector<std::uint32_t> triangles;
    std::uint32_t part;  // of the skin, which has a path to all of itself
    std::uint32_t kind;
  };
  class Group;

  Kind kind_of(std::span<const std::uint32_t> triangles) const;
  std::uint32_t part_of(std::span<const std::uint32_t> triangles) const;
  std::vector<Share> shares_of(std::span<const std::uint32_t> triangles) const;
  static double in_common(const std::vector<Share>& a, const std::vector<Share>& b);
  // Whether any triangle of one overlaps the mean of the other by less than the separation requires.
  bool are_strangers(const Kind& a, const Kind& b) const;
  bool are_kin(const std::vector<Share>& a, const std::vector<Share>& b) const;
  // Whether the path along edges from one set of triangles to the other is at most the separation's distance.
  bool are_within_reach(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;
  // are_apart of two sets of one part of the skin, and of two parts.
  bool are_apart_in_part(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b,
                         bool are_strangers) const;
  bool are_apart_as_parts(const Kind& a, const Kind& b) const;

  // Whether any triangle of one set touches one of the other, within the same part of the skin, and parts
  // from it in a clip.
  bool do_part(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;

  const mesh::SurfaceMesh& skin_;
  const SkinWeights& weights_;
  const std::vector<rig::Joint>& skeleton_;
  Separation separation_;
  const Partings* partings_;
  std::vector<std::uint32_t> edge_offset_, edge_end_;  // the skin's edges by vertex, CSR
  std::vector<std::uint32_t> part_;                    // per vertex
};

}  // namespace fascicle::build
