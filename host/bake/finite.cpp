#include "host/bake/finite.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "host/base/text.h"

namespace fascicle::bake {

namespace {

bool is_finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7f800000u) != 0x7f800000u;
}

}  // namespace

bool all_finite(const model::Frame& frame) {
  return std::all_of(frame.positions.begin(), frame.positions.end(), is_finite);
}

std::string not_finite_text(const scene::Scene& scene, const model::Model& model, const model::Frame& frame) {
  std::uint32_t count = 0, first = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const float* p = &frame.positions[std::size_t{3} * i];
    if (is_finite(p[0]) && is_finite(p[1]) && is_finite(p[2])) continue;
    if (count == 0 || model.source_vertex[i] < model.source_vertex[first]) first = i;
    ++count;
  }
  const double time = scene.start + static_cast<double>(frame.index) / scene.fps;
  return "frame " + base::number_text(frame.index) + " (" + base::number_text(time) + " s): vertex " +
         base::number_text(model.source_vertex[first]) + " of layer " +
         model.layers.at(model.layer_of(first)).name +
         " has a position that is not a finite number (vertices affected: " + base::number_text(count) +
         "); try more substeps, a lower alpha or more damping";
}

}  // namespace fascicle::bake
