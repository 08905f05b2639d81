// Chooses which frames become morph targets of a .glb, and measures a viewer's error between them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// A frame as morph targets store it: all values in the file's raw space, 3 per vertex.
struct GlbFrame {
  std::uint64_t index = 0;
  std::vector<float> moves;  // from the file's position to the one that skinning maps to the baked position
  std::vector<float> turns;  // change of the normal; 0: none
  std::vector<char> moved;   // per vertex: whether its move is written; the others rely on skinning
  std::vector<std::vector<Eigen::Matrix4d>> slots;  // per part: joint transform times inverse bind
};

// The i-th of values stored 3 per vertex.
Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i);

// The blend of a vertex's joint transforms; identity for an unskinned vertex.
Eigen::Matrix4d blend_of(const gltf::RigPart& part, const std::vector<Eigen::Matrix4d>& slots,
                         std::size_t vertex);

// The largest distance (m) between the baked positions of the inner frames and what a viewer shows when it
// interpolates the first and the last linearly. Stops early above `enough`.
double interpolation_error(const std::vector<gltf::RigPart>& parts, const std::vector<GlbFrame>& frames,
                           double enough);

// Takes all frames in order and returns those that become targets: the first, the last, and between them
// every `stride`th frame or as few as keep the error below `bound`. Holds the frames since the last target,
// at most `longest`; none if every frame is a target.
class GlbTargetChoice {
 public:
  static constexpr std::size_t longest = 32;

  GlbTargetChoice(const std::vector<gltf::RigPart>& parts, std::uint64_t last, std::uint64_t stride,
                  std::optional<double> bound)
      : parts_(parts), last_(last), stride_(stride), bound_(bound) {}

  // Returns, in order, the frames that this frame shows to be targets.
  std::vector<GlbFrame> next(GlbFrame frame);
  // m, over all frames so far that are not targets.
  double error() const { return error_; }

 private:
  const std::vector<gltf::RigPart>& parts_;
  std::uint64_t last_, stride_;
  std::optional<double> bound_;
  std::vector<GlbFrame> held_;  // the last target and the frames after it
  double error_ = 0.0, held_error_ = 0.0;
};

}  // namespace fascicle::formats
