// build_model turns a Scene into the flat arrays of a Model. Warnings and measurements go to its Report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct Warning {
  std::string text;
  std::vector<std::uint32_t> vertices;  // of the tetrahedral mesh; only the first few of many
  bool is_of_flesh = false;             // irrelevant to a body without soft flesh
  bool is_of_gravity = false;           // irrelevant without gravity, which a kept model does not depend on
};

// How a joint of the skeleton was classified (bone_choice.h).
struct JointReport {
  std::string name;
  std::int32_t parent = -1;
  double share = 0.0;     // of the skin's area, with the joints below
  double openness = 0.0;  // of that skin: 0 closes around the joint, 1 is flat
  bool is_bone = false;
  bool ends_chain = false;    // a bone with no further bone below: head, hand, foot
  bool is_kinematic = false;  // its flesh follows the skeleton
  std::string reason;         // all of this in words
};

// A part of the skin that follows only its joints (rigid_parts.h).
struct RigidReport {
  std::string name;   // of its object, with the material if there are several parts
  std::string joint;  // moves most of it
  std::string reason;
  std::uint32_t vertices = 0;  // of the file
};

// The fibre field, if a layer uses it (fibre_field.h).
struct FibreReport {
  std::uint32_t constraints = 0;    // vertices with a given direction
  std::uint32_t rounds = 0;         // solves until neighbours' signs agreed
  std::uint32_t iterations = 0;     // of conjugate gradients, in total
  std::uint32_t edges = 0;          // between two vertices that have a direction
  std::uint32_t flipped_edges = 0;  // whose two directions oppose each other
  std::uint32_t bent_edges = 0;     // whose two lines differ by more than 60 degrees
  std::uint32_t without = 0;        // vertices of such layers that got no direction
  double seconds = 0.0;
};

struct LayerShare {
  std::string name;
  std::uint32_t vertices = 0;
  double volume = 0.0;                        // m^3, lumped like the mass
  double mass = 0.0;                          // kg
  std::optional<double> youngs_modulus = {};  // Pa, for an implicit scene's layer that has one
};

// How often a defect occurs on a surface, and the vertices of the first occurrences.
struct Finding {
  std::uint64_t count = 0;
  std::vector<std::uint32_t> vertices;
};

// Defects of a skin. Vertices are the file's, the first at each place.
struct SurfaceFindings {
  Finding parts;                  // connected by shared vertices; one vertex of each
  Finding loose_vertices;         // in no triangle
  Finding flat_triangles;         // zero area; vertices in threes
  Finding open_edges;             // of one triangle; vertices in pairs
  Finding non_manifold_edges;     // of three or more; vertices in pairs
  Finding non_manifold_vertices;  // where parts of the surface meet in a point
  Finding turned_edges;           // whose two triangles face opposite ways; vertices in pairs
  Finding inverted_parts;         // closed parts that face inward; one vertex of each
  Finding intersections;          // pairs of triangles; one vertex of each triangle, in pairs
  std::int64_t genus = 0;         // handles, summed over closed parts
};

// Lengths at the first and the 99th percentile, m.
struct Spread {
  double low = 0.0, high = 0.0;
  double ratio() const { return low > 0.0 ? high / low : 0.0; }
};

// Where a skin is open, and how a cage treats it (caps.h). Arrays with one entry per end.
struct OpenEnds {
  std::vector<std::uint32_t> vertex;  // lowest vertex of the loop, file number
  std::vector<std::uint32_t> edges;   // of the loop
  std::vector<std::int32_t> joint;    // moves most of the loop; -1 without a skeleton
  std::vector<double> width;          // m
  std::vector<std::uint8_t> fate;     // OpenEnd::Fate
};

// How a skin was filled.
struct CageReport {
  bool has_skin = false;  // false: a bar or a tetrahedral file, and the rest is unset
  bool is_cage = false;
  std::string reason;  // why a cage, or why not
  SurfaceFindings findings;
  OpenEnds ends;                     // of a cage's skin
  double skin_volume = 0.0;          // enclosed by the skin, m^3; 0 if it is open
  Spread skin_spacing;               // mean edge of each of the skin's vertices
  Spread spacing;                    // the same for the tetrahedra
  Spread edges;                      // of the tetrahedra
  double alpha = 0.0;                // gaps narrower than about twice this were closed over, m
  double offset = 0.0;               // of the wrap from the skin, before it was moved outward, m
  std::uint32_t cut_tetrahedra = 0;  // duplicated for each of the limbs that touch in them
  double wrap_seconds = 0.0, fill_seconds = 0.0, cut_seconds = 0.0;
};

// What filling a surface found. The cache keeps it with the body, so all findings go here or into the
// warnings.
struct FillReport {
  std::uint32_t riders_outside = 0;  // render vertices outside the tetrahedra that they ride on
  double least_barycentric = 0.0;    // the lowest barycentric coordinate, 0 if none is outside
  CageReport cage;
};
// What was found and repaired during the build. The cache keeps it with the model (report_fields.h).
struct Report {
  std::uint32_t vertices = 0, tetrahedra = 0, surface_vertices = 0, surface_triangles = 0;
  double volume = 0.0;                                              // m^3
  double mass = 0.0;                                                // kg
  double mean_edge = 0.0, shortest_edge = 0.0, longest_edge = 0.0;  // m
  std::uint32_t flipped_tetrahedra = 0;  // given with negative volume and reoriented
  std::uint32_t region_fallbacks = 0;    // regions whose weights summed to nothing: w = m
  std::uint32_t vertex_fallbacks = 0;    // vertices whose weights summed to nothing: w = m
  std::uint32_t skipped_regions = 0;     // all weights zero
  std::uint32_t pinned_vertices = 0;     // kinematic ones: pinned, or of a kinematic layer
  FillReport fill;
  std::vector<JointReport> joints;        // of a character's skeleton
  std::vector<RigidReport> rigid_parts;   // of a character, in the order of its skin
  std::uint32_t bone_islands_before = 0;  // pieces of a character's bone layer before joining
  std::uint32_t bone_islands = 0;         // and after vertices were added between them
  std::uint32_t bone_vertices_added = 0;
  FibreReport fibres;
  std::vector<LayerShare> layers;
  std::vector<Warning> warnings;
  bool body_from_cache = false;
  bool is_kept = false;  // the whole model came from the cache
  double seconds = 0.0;  // time to build, or to find a kept model
};

// Thrown when BuildOptions::is_cancelled returns true.
struct Cancelled : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct BuildOptions {
  std::filesystem::path mesher;                         // fascicle-mesher; empty: beside the executable
  double mesher_seconds = 120.0;                        // limits of the helper process: processor time
  std::uint64_t mesher_bytes = std::uint64_t{4} << 30;  // and memory
  std::filesystem::path cache;                          // folder for filled bodies; empty: no cache
  // Polled between the stages of the build, and repeatedly while the mesher runs; true cancels the build.
  // Must not throw.
  std::function<bool()> is_cancelled = {};
};

// What one build keeps for the next when a scene is rebuilt repeatedly with other keys: the body, its
// measures, fibres, contact. The model and its report are bit-identical to a build without it.
class BuildMemory {
 public:
  BuildMemory();
  ~BuildMemory();
  BuildMemory(BuildMemory&&) noexcept;
  BuildMemory& operator=(BuildMemory&&) noexcept;

  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

// Throws scene::SceneError, with advice, for input that cannot be built, and Cancelled.
model::Model build_model(const scene::Scene& scene, Report& report, const BuildOptions& options = {});
// If a build throws, the memory keeps the parts that were complete by then.
model::Model build_model(const scene::Scene& scene, Report& report, const BuildOptions& options,
                         BuildMemory& memory);

// The name of the scene's body. It changes with everything that determines the body except the programs.
// Scenes with the same name differ only in layers, forces, motion and the like. Nothing if a scene was made
// in memory and has no hashes of its inputs.
std::optional<std::string> body_key(const scene::Scene& scene);

}  // namespace fascicle::build
