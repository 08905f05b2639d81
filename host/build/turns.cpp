#include "host/build/turns.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "host/base/trigonometry.h"

namespace fascicle::build {

std::vector<double> turns_in_clips(const rig::Character& character) {
  std::vector<double> turns(character.skeleton.size(), 0.0);
  for (const rig::Clip& clip : character.clips)
    for (const rig::Channel& channel : clip.channels) {
      if (channel.path != rig::ChannelPath::rotation || channel.joint >= turns.size()) continue;
      const bool has_tangents = channel.interpolation == rig::Interpolation::cubic_spline;
      const std::size_t width = has_tangents ? 12 : 4, offset = has_tangents ? 4 : 0;
      const auto key = [&](std::size_t k) {
        return Eigen::Vector4d(Eigen::Map<const Eigen::Vector4d>(channel.values.data() + k * width + offset));
      };
      const auto angle = [&](std::size_t from, std::size_t to) {
        const double lengths = key(from).norm() * key(to).norm();
        return lengths > 0.0
                   ? 2.0 * base::exact_acos(std::min(1.0, std::abs(key(from).dot(key(to))) / lengths))
                   : 0.0;
      };
      // The key farthest from the first, then the key farthest from that.
      std::size_t far = 0;
      for (int pass = 0; pass < 2; ++pass) {
        const std::size_t from = far;
        for (std::size_t k = 0; k < channel.times.size(); ++k)
          if (angle(from, k) > angle(from, far)) far = k;
        turns[channel.joint] = std::max(turns[channel.joint], angle(from, far));
      }
    }
  return turns;
}

}  // namespace fascicle::build
