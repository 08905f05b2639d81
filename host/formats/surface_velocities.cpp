#include "host/formats/surface_velocities.h"

#include <utility>

namespace fascicle::formats {

namespace {

std::vector<float> velocity_between(std::span<const float> to, std::span<const float> from, double factor) {
  std::vector<float> result(to.size());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = static_cast<float>((double{to[i]} - double{from[i]}) * factor);
  return result;
}

}  // namespace

std::vector<float> SurfaceVelocities::next(std::vector<float> positions) {
  std::vector<float> velocities;
  if (!before_.empty())
    velocities = velocity_between(positions, before_, 0.5 * fps_);
  else if (!now_.empty())
    velocities = velocity_between(positions, now_, fps_);
  before_ = std::move(now_);
  now_ = std::move(positions);
  return velocities;
}

std::vector<float> SurfaceVelocities::last() const {
  return before_.empty() ? std::vector<float>(now_.size(), 0.0f) : velocity_between(now_, before_, fps_);
}

}  // namespace fascicle::formats
