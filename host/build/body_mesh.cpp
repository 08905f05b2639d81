#include "host/build/body_mesh.h"

#include <string>

#include "host/build/bones.h"
#include "host/build/check_mesh.h"
#include "host/build/message.h"
#include "host/build/tetrahedralize.h"

namespace fascicle::build {

BodyMesh make_body_mesh(const WeldedSurface& welded, const std::vector<Bone>& bones,
                        const scene::Scene& scene, Report& report, const BuildOptions& options) {
  const double spacing = scene.resolution.value_or(mean_edge(welded.surface));
  BodyMesh body;
  try {
    body.mesh =
        tetrahedralize(welded.surface, spacing, points_along_bones(bones, welded.surface, spacing), options);
  } catch (const scene::SceneError& error) {
    const bool renumbered = welded.surface.vertices.size() != welded.of_vertex.size();
    fail(scene.source, "mesh: " + std::string(error.what()) +
                           (renumbered ? " (vertices are counted after welding equal ones)" : ""));
  }
  check_and_orient(body.mesh, scene.source, report);
  return body;
}

void add_mesh_settings(scene::ContentHash& hash, const scene::Scene& scene) {
  hash.add(scene.resolution.has_value());
  hash.add(scene.resolution.value_or(0.0));
}

}  // namespace fascicle::build
