#include "host/formats/glb_targets.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace fascicle::formats {

using Eigen::Matrix4d;
using Eigen::Vector3d;

Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

namespace {

Vector3d written(const GlbFrame& frame, std::size_t i) {
  return frame.moved[i] != 0 ? vector_at(frame.moves, i) : Vector3d::Zero();
}

}  // namespace

Matrix4d blend_of(const gltf::RigPart& part, const std::vector<Matrix4d>& slots, std::size_t vertex) {
  if (part.influence_offset.empty()) return Matrix4d::Identity();
  Matrix4d blend = Matrix4d::Zero();
  for (std::size_t k = part.influence_offset[vertex]; k < part.influence_offset[vertex + 1]; ++k)
    blend += part.weight[k] * slots[part.slot[k]];
  return blend;
}

double interpolation_error(const std::vector<gltf::RigPart>& parts, const std::vector<GlbFrame>& frames,
                           double enough) {
  double largest = 0.0;
  if (frames.size() < 3) return largest;
  const GlbFrame &from = frames.front(), &to = frames.back();
  for (std::size_t f = 1; f + 1 < frames.size(); ++f) {
    const GlbFrame& frame = frames[f];
    const double share =
        static_cast<double>(frame.index - from.index) / static_cast<double>(to.index - from.index);
    std::size_t v = 0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      // A blend stretches no more than the joint that stretches most.
      double stretch = parts[p].influence_offset.empty() ? 1.0 : 0.0;
      for (const Matrix4d& slot : frame.slots[p])
        stretch = std::max(stretch, slot.topLeftCorner<3, 3>().norm());
      for (std::size_t i = 0; i < parts[p].positions.size(); ++i, ++v) {
        const Vector3d off =
            (1.0 - share) * written(from, v) + share * written(to, v) - vector_at(frame.moves, v);
        if (stretch * off.norm() <= largest) continue;
        const Matrix4d blend = blend_of(parts[p], frame.slots[p], i);
        largest = std::max(largest, (blend.topLeftCorner<3, 3>() * off).norm());
        if (largest > enough) return largest;
      }
    }
  }
  return largest;
}

std::vector<GlbFrame> GlbTargetChoice::next(GlbFrame frame) {
  std::vector<GlbFrame> targets;
  if (!bound_ && stride_ == 1) {
    targets.push_back(std::move(frame));
    return targets;
  }
  const bool is_first = held_.empty(), is_last = frame.index == last_;
  held_.push_back(std::move(frame));
  if (is_first) {
    targets.push_back(held_.front());
    return targets;
  }
  if (!bound_) {
    if (!is_last && held_.back().index % stride_ != 0) return targets;
    error_ = std::max(error_, interpolation_error(parts_, held_, std::numeric_limits<double>::infinity()));
    held_.erase(held_.begin(), held_.end() - 1);
    targets.push_back(held_.front());
    return targets;
  }
  const double error = interpolation_error(parts_, held_, *bound_);
  if (error > *bound_ || held_.size() > longest) {
    // Without this frame, the error was still within the bound.
    error_ = std::max(error_, held_error_);
    held_.erase(held_.begin(), held_.end() - 2);
    held_error_ = 0.0;
    targets.push_back(held_.front());
  } else {
    held_error_ = error;
  }
  if (!is_last) return targets;
  error_ = std::max(error_, held_error_);
  targets.push_back(held_.back());
  return targets;
}

}  // namespace fascicle::formats
