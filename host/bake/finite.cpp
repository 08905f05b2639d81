#include "host/bake/finite.h"

#include <cstdint>
#include <span>

#include "host/base/text.h"
#include "host/model/reach.h"

namespace fascicle::bake {

bool is_in_reach(const model::Frame& frame, double unit) {
  return model::is_in_reach(frame.origin) && model::is_in_reach(frame.positions, unit);
}

std::string not_finite_text(const scene::Scene& scene, const model::Model& model, const model::Frame& frame) {
  const double time = scene.start + static_cast<double>(frame.index) / scene.fps;
  const std::string where =
      "frame " + base::number_text(frame.index) + " (" + base::number_text(time) + " s): ";
  if (!model::is_in_reach(frame.origin))
    return where +
           "the body is too far away from the world's origin, or not at a finite place; check its motion";
  std::uint32_t count = 0, first = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const std::span<const float, 3> place(&frame.positions[std::size_t{3} * i], 3);
    if (model::is_in_reach(place, model.unit)) continue;
    if (count == 0 || model.source_vertex[i] < model.source_vertex[first]) first = i;
    ++count;
  }
  return where + "vertex " + base::number_text(model.source_vertex[first]) + " of layer " +
         model.layers.at(model.layer_of(first)).name +
         " has a position that is not a finite number, or too far away (vertices affected: " +
         base::number_text(count) + "); try more substeps, a lower alpha or more damping";
}

}  // namespace fascicle::bake
