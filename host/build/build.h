// build_model: from what the artist said to the flat arrays a solver eats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct Warning {
  std::string text;
  std::vector<std::uint32_t> vertices;  // of the tetrahedral mesh; the first few where there are many
};

struct LayerShare {
  std::string name;
  std::uint32_t vertices = 0;
  double volume = 0.0;  // m^3, lumped like the mass
  double mass = 0.0;    // kg
};

// What filling a surface found. It is kept with the body in the cache: all it says goes here or into the
// warnings, and every field into for_each_field.
struct FillReport {
  std::uint32_t riders_outside = 0;  // render vertices outside the tetrahedra that they ride on
  double least_barycentric = 0.0;    // how far: the least barycentric coordinate, 0 where none is outside
};
template <class Fill, class Visit>
void for_each_field(Fill& fill, Visit& visit) {
  auto& [riders_outside, least_barycentric] = fill;  // does not compile where a field is missing
  visit(riders_outside);
  visit(least_barycentric);
}

// What was found and repaired on the way.
struct Report {
  std::uint32_t vertices = 0, tetrahedra = 0, surface_vertices = 0, surface_triangles = 0;
  double volume = 0.0;                                              // m^3
  double mass = 0.0;                                                // kg
  double mean_edge = 0.0, shortest_edge = 0.0, longest_edge = 0.0;  // m
  std::uint32_t flipped_tetrahedra = 0;  // given with negative volume and turned round
  std::uint32_t region_fallbacks = 0;    // regions whose weights summed to nothing: w = m
  std::uint32_t vertex_fallbacks = 0;    // vertices whose weights summed to nothing: w = m
  std::uint32_t skipped_regions = 0;     // all weights zero
  std::uint32_t pinned_vertices = 0;     // kinematic ones: pinned, or of a kinematic layer
  FillReport fill;
  std::vector<LayerShare> layers;
  std::vector<Warning> warnings;
  bool body_from_cache = false;
  double seconds = 0.0;
};

struct BuildOptions {
  std::filesystem::path mesher;   // fascicle-mesher; empty: beside the executable
  double mesher_seconds = 120.0;  // limits of the helper process
  std::uint64_t mesher_bytes = std::uint64_t{4} << 30;
  std::filesystem::path cache;  // folder where filled bodies are kept; empty: nowhere
};

// Throws scene::SceneError for input that cannot be built, with what to do.
model::Model build_model(const scene::Scene& scene, Report& report, const BuildOptions& options = {});

}  // namespace fascicle::build
