#include "host/build/colliders.h"

#include <algorithm>
#include <string>

#include "host/base/text.h"
#include "host/scene/solids.h"

namespace fascicle::build {

using scene::Vector3d;

namespace {

// From this share of the free flesh on, a solid is assumed to be misplaced.
constexpr double much_flesh = 0.02;

Vector3d rest_place(const model::Model& model, std::uint32_t i) {
  const float* rest = model.rest.data() + 3 * std::size_t{i};
  return Vector3d(model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]) +
         model.unit * Vector3d(double{rest[0]}, double{rest[1]}, double{rest[2]});
}

// Warns if more flesh lies in a solid at rest than the sole of a foot that stands in a floor.
void warn_of_enclosed(const scene::Collider& collider, const scene::Solid& solid, const model::Model& model,
                      Report& report) {
  std::uint64_t free = 0, inside = 0;
  double lowest = 1e300;
  Warning warning;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Vector3d place = rest_place(model, i);
    lowest = std::min(lowest, place.y());
    if (model.is_kinematic(i)) continue;
    ++free;
    if (!(scene::distance_to(solid, place) < 0.0)) continue;
    ++inside;
    if (warning.vertices.size() < 5) warning.vertices.push_back(model.source_vertex[i]);
  }
  if (static_cast<double>(inside) <= much_flesh * static_cast<double>(free)) return;
  warning.text =
      "collider." + collider.name + ": " + std::to_string(inside) + " of " + std::to_string(free) +
      " free vertices are inside it at rest and will be pushed out slowly; move it (the body's lowest "
      "point is at y = " +
      base::number_text(lowest) + " m)";
  report.warnings.push_back(std::move(warning));
}

}  // namespace

void write_colliders(const scene::Scene& scene, model::Model& model, Report& report) {
  static_assert(scene::most_colliders == model::most_colliders);
  model.collider_count = static_cast<std::uint32_t>(scene.colliders.size());
  if (scene.colliders.empty()) return;
  model.spared.assign(model.vertex_count, 0);
  for (std::size_t k = 0; k < scene.colliders.size(); ++k) {
    const scene::Solid solid = scene::bound_solid_of(scene, scene.colliders[k]);
    if (scene.colliders[k].joint.empty()) {
      warn_of_enclosed(scene.colliders[k], solid, model, report);
      continue;
    }
    const double clearance = 0.1 * (solid.half_size.maxCoeff() + solid.radius);
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      if (scene::distance_to(solid, rest_place(model, i)) <= clearance) model.spared[i] |= 1U << k;
    }
  }
}

}  // namespace fascicle::build
