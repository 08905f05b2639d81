// Which places of a skin move apart in the character's clips although they touch or nearly touch in its bind
// pose: jaws, a tail and what it hangs on, fingers held together. Weights alone do not show this: a lower jaw
// may follow the head by half.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/build/body.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// The maps of all joints from the bind pose to some poses of all clips, evenly spaced in each clip: 96
// divided by the number of clips, but at least 1 and at most 16 per clip, of 96 clips at most. Linear keys
// are interpolated linearly, so that a body does not depend on which clip is played and smoothed. Lengths are
// those of the character times `scale`.
std::vector<std::vector<Eigen::Matrix4d>> poses_of_clips(const rig::Character& character, double scale);

class Partings {
 public:
  // The arguments must outlive this object. Places touch if they are at most `near` (m) apart in the bind
  // pose; they part if some pose moves them `far` (m) farther apart than that.
  Partings(const mesh::SurfaceMesh& skin, const SkinWeights& weights,
           std::span<const std::vector<Eigen::Matrix4d>> poses, double near, double far);

  // Whether two triangles come near each other in places that do part.
  bool do_part(std::uint32_t a, std::uint32_t b) const;

 private:
  // A joint's weight at a place.
  struct Share {
    std::uint32_t joint;
    double weight;
  };
  std::vector<Share> shares_at(std::uint32_t triangle, const std::array<double, 3>& weights) const;

  // Whether places of two triangles, given as weights of their corners, are farther apart in some pose by
  // `far`.
  bool have_parted(std::uint32_t a, const std::array<double, 3>& at_a, std::uint32_t b,
                   const std::array<double, 3>& at_b) const;

  const mesh::SurfaceMesh& skin_;
  const SkinWeights& weights_;
  std::span<const std::vector<Eigen::Matrix4d>> poses_;
  double near_, far_;
};

}  // namespace fascicle::build
