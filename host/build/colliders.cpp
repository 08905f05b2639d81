#include "host/build/colliders.h"

#include "host/scene/solids.h"

namespace fascicle::build {

using scene::Vector3d;

void write_colliders(const scene::Scene& scene, model::Model& model) {
  static_assert(scene::most_colliders == model::most_colliders);
  model.collider_count = static_cast<std::uint32_t>(scene.colliders.size());
  if (scene.colliders.empty()) return;
  model.spared.assign(model.vertex_count, 0);
  const Vector3d origin(model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]);
  for (std::size_t k = 0; k < scene.colliders.size(); ++k) {
    if (scene.colliders[k].joint.empty()) continue;
    const scene::Solid solid = scene::solid_of(scene.colliders[k]);
    const double clearance = 0.1 * (solid.half_size.maxCoeff() + solid.radius);
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      const float* rest = model.rest.data() + 3 * std::size_t{i};
      const Vector3d place =
          origin + model.unit * Vector3d(double(rest[0]), double(rest[1]), double(rest[2]));
      if (scene::distance_to(solid, place) <= clearance) model.spared[i] |= 1U << k;
    }
  }
}

}  // namespace fascicle::build
