#include "host/studio/frame_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/bake/points.h"

namespace fascicle::studio {

using bake::determinant;
using bake::difference;
using bake::dot;
using bake::point_at;

namespace {

// Six times the volume of all tetrahedra, cubic working units, and the number that are flat or inverted.
struct Volumes {
  double six = 0.0;
  std::uint32_t inverted = 0;
};

Volumes volumes_of(const model::Model& model, const std::vector<float>& positions) {
  Volumes volumes;
  for (std::size_t k = 0; k < model.tetrahedron.size(); k += 4) {
    const bake::Point p = point_at(positions, model.tetrahedron[k]);
    const double six = determinant(difference(point_at(positions, model.tetrahedron[k + 1]), p),
                                   difference(point_at(positions, model.tetrahedron[k + 2]), p),
                                   difference(point_at(positions, model.tetrahedron[k + 3]), p));
    volumes.six += six;
    volumes.inverted += six > 0.0 ? 0u : 1u;
  }
  return volumes;
}

}  // namespace

FrameMeasures::FrameMeasures(const model::Model& model)
    : model_(&model), rest_volume_(volumes_of(model, model.rest).six) {}

void FrameMeasures::fill(const model::Frame& frame, FrameNumbers& numbers) const {
  const Volumes volumes = volumes_of(*model_, frame.positions);
  numbers.volume = rest_volume_ > 0.0 ? static_cast<float>(volumes.six / rest_volume_) : 1.0f;
  numbers.inverted = volumes.inverted;
  double lag = 0.0, largest = 0.0, squared_speed = 0.0, energy = 0.0;
  std::uint32_t free = 0;
  for (std::uint32_t i = 0; i < model_->vertex_count; ++i) {
    if (!frame.velocities.empty()) {
      const bake::Point v = point_at(frame.velocities, i);
      energy += 0.5 * model_->mass[i] * dot(v, v);
      if (!model_->is_kinematic(i)) squared_speed += dot(v, v);
    }
    if (model_->is_kinematic(i)) continue;
    ++free;
    if (frame.skinned.empty()) continue;
    const bake::Point d = difference(point_at(frame.positions, i), point_at(frame.skinned, i));
    const double squared = dot(d, d);
    lag += squared;
    largest = std::max(largest, squared);
  }
  const double unit = model_->unit, count = std::max(free, 1u);
  numbers.energy = static_cast<float>(energy * unit * unit);
  numbers.speed = static_cast<float>(std::sqrt(squared_speed / count) * unit);
  const bool is_known = !model_->has_skeleton() || !frame.skinned.empty();
  constexpr float not_known = std::numeric_limits<float>::quiet_NaN();
  numbers.lag = is_known ? static_cast<float>(std::sqrt(lag / count) * unit) : not_known;
  numbers.largest_lag = is_known ? static_cast<float>(std::sqrt(largest) * unit) : not_known;
}

}  // namespace fascicle::studio
