// Which vertices the scene's solids hold: shaders/kernel/collide.inc.
#pragma once

#include "host/build/build.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills Model::collider_count and spared from the model's rest shape. A solid that goes with a joint lies in
// the character's own flesh: what is in it at rest, or within a tenth of its size of it, it does not hold.
// What moves on its own holds everything; where much
// of the flesh lies in it at rest, the report warns.
void write_colliders(const scene::Scene& scene, model::Model& model, Report& report);

}  // namespace fascicle::build
