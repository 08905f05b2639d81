// Which frames become morph targets of a .glb, and how far a viewer is off between them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// A frame as morph targets hold it: all values in the file's raw space, 3 a vertex.
struct GlbFrame {
  std::uint64_t index = 0;
  std::vector<float> moves;  // from where the file has the vertex to where skinning makes it right
  std::vector<float> turns;  // of its normal; 0: none
  std::vector<char> moved;   // a vertex: its move is written; the others are left to skinning
  std::vector<std::vector<Eigen::Matrix4d>> slots;  // of each part: joint transforms after inverse binds
};

// The i-th of values that stand 3 a vertex.
Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i);

// The blend of a vertex's joint transforms; 1 where nothing skins it.
Eigen::Matrix4d blend_of(const gltf::RigPart& part, const std::vector<Eigen::Matrix4d>& slots,
                         std::size_t vertex);

// The largest distance (m) between what a viewer shows of the frames inside, when it mixes the first and the
// last linearly, and where they were baked. Stops early above `enough`.
double interpolation_error(const std::vector<gltf::RigPart>& parts, const std::vector<GlbFrame>& frames,
                           double enough);

// Takes all frames in order and hands out those that become targets: the first and the last, and between
// them each `stride`th, or as few as keep the error below `bound`. Holds the frames since the last target,
// never more than `longest` of them, and none where every frame is a target.
class GlbTargetChoice {
 public:
  static constexpr std::size_t longest = 32;

  GlbTargetChoice(const std::vector<gltf::RigPart>& parts, std::uint64_t last, std::uint64_t stride,
                  std::optional<double> bound)
      : parts_(parts), last_(last), stride_(stride), bound_(bound) {}

  // The frames that are now known to be targets, in order.
  std::vector<GlbFrame> next(GlbFrame frame);
  // m, of all frames so far that are no targets.
  double error() const { return error_; }

 private:
  const std::vector<gltf::RigPart>& parts_;
  std::uint64_t last_, stride_;
  std::optional<double> bound_;
  std::vector<GlbFrame> held_;  // the last target and what came after it
  double error_ = 0.0, held_error_ = 0.0;
};

}  // namespace fascicle::formats
