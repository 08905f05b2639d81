// Which vertices the scene's solids keep out: shaders/kernel/collide.inc.
#pragma once

#include "host/build/build.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills Model::collider_count and spared from the model's rest shape. A solid attached to a joint lies in the
// character's own flesh, so it does not act on vertices that are in it at rest, or within a tenth of its size
// of it. A free solid acts on everything; the report warns if much of the flesh lies in it at rest.
void write_colliders(const scene::Scene& scene, model::Model& model, Report& report);

}  // namespace fascicle::build
