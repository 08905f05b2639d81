// Bodies filled from surfaces and characters, for the tests of cages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "host/build/body_mesh.h"
#include "host/build/embedding.h"
#include "host/build/skin_weights.h"
#include "host/build/unions.h"
#include "host/scene/scene.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {

inline scene::Scene scene_of(scene::Geometry geometry, scene::Cage cage = scene::Cage::automatic) {
  scene::Scene scene = bar_scene();
  scene.geometry = std::move(geometry);
  scene.body.cage = cage;
  return scene;
}

// A surface or a character's skin as the builder takes it, and the result.
struct Filled {
  build::WeldedSurface welded;
  build::SkinWeights skin;
  build::BodyMesh body;
  build::SkinWeights weights;  // of the body's vertices
  build::Report report;
};

inline Filled fill(const scene::Scene& scene) {
  Filled filled;
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  const mesh::SurfaceMesh& surface =
      character != nullptr ? character->surface : std::get<mesh::SurfaceMesh>(scene.geometry);
  filled.welded = build::weld(surface, "test", filled.report);
  const std::vector<rig::Joint> no_skeleton;
  if (character != nullptr)
    filled.skin = build::welded_skin_weights(*character, filled.welded.of_vertex,
                                             filled.welded.surface.vertices.size(), "test");
  filled.body = build::make_body_mesh(
      {filled.welded, filled.skin, character != nullptr ? character->skeleton : no_skeleton, {}, character},
      scene, filled.report, with_mesher());
  if (character != nullptr)
    filled.weights =
        build::body_skin_weights(filled.body, filled.welded, filled.skin, character->skeleton.size(), "test");
  return filled;
}

// The smallest barycentric coordinate of any skin point in its home.
inline double least_at_home(const Filled& filled) {
  double least = 1.0;
  for (std::size_t v = 0; v < filled.body.home.size(); ++v) {
    const auto weights =
        build::barycentric(filled.body.mesh, filled.body.mesh.tetrahedra[filled.body.home[v]],
                           filled.welded.surface.vertices[v]);
    least = std::min(least, *std::min_element(weights.begin(), weights.end()));
  }
  return least;
}

// Connected parts of the mesh; vertices without a tetrahedron count.
inline std::size_t parts_of(const mesh::TetMesh& mesh) {
  build::Unions unions(mesh.vertices.size());
  for (const auto& t : mesh.tetrahedra)
    for (const std::uint32_t v : t) unions.join(t[0], v);
  std::set<std::uint32_t> roots;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) roots.insert(unions.find(v));
  return roots.size();
}

}  // namespace fascicle::tests
