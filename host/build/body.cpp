#include "host/build/body.h"

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/build/check_mesh.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

void add_scene_bones(const scene::Scene& scene, Body& body) {
  for (const scene::BoneSegment& bone : scene.bones) body.bones.push_back({bone.from, bone.to, {-1, -1, -1}});
}

Body body_of(const scene::Bar& bar, const scene::Scene& scene, Report& report, const BuildOptions&) {
  Body body;
  body.mesh = make_bar(bar, scene.source);
  check_and_orient(body.mesh, scene.source, report);
  body.render = boundary_render_mesh(body.mesh, scene.source);
  add_scene_bones(scene, body);
  return body;
}

Body body_of(const scene::TetMesh& mesh, const scene::Scene& scene, Report& report, const BuildOptions&) {
  Body body;
  body.mesh = mesh;
  for (Vector3d& p : body.mesh.vertices) p *= scene.scale;
  check_and_orient(body.mesh, scene.source, report);
  body.render = boundary_render_mesh(body.mesh, scene.source);
  add_scene_bones(scene, body);
  return body;
}

template <class Unsupported>
Body body_of(const Unsupported&, const scene::Scene& scene, Report&, const BuildOptions&) {
  fail(scene.source, "surfaces cannot be built yet");
}

}  // namespace

Body make_body(const scene::Scene& scene, Report& report, const BuildOptions& options) {
  return std::visit([&](const auto& geometry) { return body_of(geometry, scene, report, options); },
                    scene.geometry);
}

}  // namespace fascicle::build
