// build_model in one page: body -> numbering -> one-rings -> layers -> masses -> weights -> the Model's
// arrays.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "host/base/text.h"
#include "host/build/body.h"
#include "host/build/boundary.h"
#include "host/build/box_tree.h"
#include "host/build/build.h"
#include "host/build/build_memory.h"
#include "host/build/check_mesh.h"
#include "host/build/colliders.h"
#include "host/build/contacts.h"
#include "host/build/fibre.h"
#include "host/build/forces.h"
#include "host/build/layers.h"
#include "host/build/limits.h"
#include "host/build/mass.h"
#include "host/build/measures.h"
#include "host/build/mesher.h"
#include "host/build/message.h"
#include "host/build/muscles.h"
#include "host/build/one_ring.h"
#include "host/build/order.h"
#include "host/build/shares.h"
#include "host/build/stiffness.h"
#include "host/build/ties.h"
#include "host/build/volume.h"
#include "host/build/weights.h"
#include "host/build/where.h"
#include "host/model/reach.h"
#include "host/model/surroundings.h"
#include "host/rig/floors.h"

namespace fascicle::build {

namespace {

using model::Model;

// The working unit is the power of two metres at or below the longest side of the bounding box, and the
// origin is the box's centre. So rest coordinates lie in [-1, 1], use the full precision of a float around
// the middle of the body, and opposite corners of a box differ only in sign.
void choose_unit(const mesh::TetMesh& mesh, const std::string& source, Model& model) {
  Vector3d low = mesh.vertices[0], high = mesh.vertices[0];
  for (const Vector3d& p : mesh.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double extent = (high - low).maxCoeff();
  // Squares and cubes of lengths must stay in the normal range.
  if (!(extent > 1e-30 && extent < model::farthest))
    fail(source, "mesh: it is " + std::to_string(extent) + " m long, which cannot be simulated; set `scale`");
  model.unit = std::ldexp(1.0, std::ilogb(extent));
  const Vector3d centre = low + (high - low) / 2.0;
  for (int a = 0; a < 3; ++a) model.rest_origin[static_cast<std::size_t>(a)] = centre[a];
  if (!model::is_in_reach(model.rest_origin))
    fail(source, "mesh: it is " + base::number_text(centre.cwiseAbs().maxCoeff()) +
                     " m away from the origin, which cannot be simulated; move it nearer");
}

// Rest positions in floats; rounding must not invert a tetrahedron.
void write_rest(const mesh::TetMesh& mesh, const std::string& source, Model& model) {
  const Vector3d origin(model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]);
  mesh::TetMesh rounded{mesh.vertices, {}};
  model.rest.reserve(3 * mesh.vertices.size());
  for (Vector3d& p : rounded.vertices)
    for (int a = 0; a < 3; ++a) {
      model.rest.push_back(static_cast<float>((p[a] - origin[a]) / model.unit));
      p[a] = static_cast<double>(model.rest.back());
    }
  std::vector<std::uint32_t> lost;
  model.tetrahedron.reserve(4 * mesh.tetrahedra.size());
  for (const auto& t : mesh.tetrahedra) {
    if (!(signed_volume(rounded, t) > 0.0)) lost.push_back(model.source_vertex[t[0]]);
    model.tetrahedron.insert(model.tetrahedron.end(), t.begin(), t.end());
  }
  std::sort(lost.begin(), lost.end());
  lost.erase(std::unique(lost.begin(), lost.end()), lost.end());
  if (!lost.empty())
    fail(source, "mesh: tetrahedra are too flat for single precision at vertex " + list_of(lost) +
                     " (counted from 0); improve the mesh there");
}

// The lightest vertex's part of a push shared with the heaviest must stay representable in the solver.
constexpr double most_mass_ratio = 0x1p36;

void check_shared_masses(const scene::Scene& scene, const Model& model) {
  if (model.mobility.empty() && !model.has_ties()) return;
  std::optional<std::uint32_t> least, most;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    if (!least || model.mass[i] < model.mass[*least]) least = i;
    if (!most || model.mass[i] > model.mass[*most]) most = i;
  }
  if (!least || model.mass[*most] <= most_mass_ratio * model.mass[*least]) return;
  const auto density = [&](std::uint32_t i) {
    const scene::Layer& layer = scene.layers[model.layer_of(i)];
    return "layers." + layer.name + ".density of " + base::number_text(layer.density);
  };
  fail(scene.source, density(*least) + ": vertices there are over 7e10 times lighter than with " +
                         density(*most) + "; make the densities, or the mesh, more even");
}

void write_layers(const scene::Scene& scene, const Layering& layering, const std::vector<double>& volume,
                  std::vector<float> fibre, Model& model, Report& report) {
  for (const scene::Layer& layer : scene.layers) {
    model.layers.push_back({layer.name, layer.damping, layer.density, layer.kinematic});
    report.layers.push_back({layer.name, 0, 0.0, 0.0, {}});
  }
  std::vector<float> carried;
  model.fibre = std::move(fibre);
  for (std::size_t i = 0; i < layering.layer.size(); ++i) {
    const std::uint32_t l = layering.layer[i];
    const scene::Layer& layer = scene.layers[l];
    const bool kinematic = layering.kinematic[i] != 0;
    const bool has_fibre =
        model.fibre[3 * i] != 0.0f || model.fibre[3 * i + 1] != 0.0f || model.fibre[3 * i + 2] != 0.0f;
    model.mass.push_back(layer.density * volume[i]);
    model.alpha.push_back(kinematic ? 0.0f : model::as_factor(layering.alpha[i]));
    carried.push_back(kinematic ? 0.0f : model::as_factor(1.0 - layer.inertia_scale));
    model.beta.push_back(has_fibre ? static_cast<float>(layer.beta) : 0.0f);
    model.tag.push_back(l | (kinematic ? shader::tag_kinematic : 0u));

    LayerShare& share = report.layers[l];
    ++share.vertices;
    share.volume += volume[i];
    share.mass += model.mass[i];
    report.mass += model.mass[i];
    report.pinned_vertices += kinematic ? 1u : 0u;
  }
  const bool some = std::any_of(carried.begin(), carried.end(), [](float share) { return share != 0.0f; });
  const bool keeps_motion = some || scene.solver.integrator == scene::Integrator::implicit_step;
  if (keeps_motion && std::holds_alternative<rig::Character>(scene.geometry))
    model.carried = std::move(carried);
}

// The longest side of the box around the vertices, m; without carriers if there is a floor.
double extent_without_floors(const Body& body, const scene::Scene& scene) {
  std::vector<Vector3d> places = body.mesh.vertices;
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  const std::vector<char> is_on_floor =
      character != nullptr ? rig::on_floors(*character) : std::vector<char>();
  if (std::find(is_on_floor.begin(), is_on_floor.end(), 1) != is_on_floor.end()) {
    places.clear();
    for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i)
      if (holding_of(body, i) != Holding::carrier) places.push_back(body.mesh.vertices[i]);
  }
  if (places.empty()) return 0.0;
  const BoundingBox box = box_around(places);
  return (box.high - box.low).maxCoeff();
}

// The volumes and masses without what carries floors, if there are any: it may be far larger than the body.
void leave_out_surroundings(const Model& model, const std::vector<double>& volume, Report& report) {
  const std::vector<char> is_beside = model::surroundings_of(model).vertices;
  if (std::find(is_beside.begin(), is_beside.end(), 1) == is_beside.end()) return;
  report.volume = report.mass = 0.0;
  for (LayerShare& share : report.layers) share.volume = share.mass = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (is_beside[i] != 0) continue;
    LayerShare& share = report.layers[model.layer_of(i)];
    share.volume += volume[i];
    share.mass += model.mass[i];
    report.volume += volume[i];
    report.mass += model.mass[i];
  }
}

void warn_of_still_regions(std::vector<std::uint32_t> regions, const Model& model, Report& report) {
  if (regions.empty()) return;
  for (std::uint32_t& r : regions) r = model.source_vertex[r];
  std::sort(regions.begin(), regions.end());
  warn_of_flesh(
      report,
      counted(regions.size(), "vertex lies", "vertices lie") +
          " among tetrahedra so much smaller, flatter or softer than the rest that the region around never "
          "rotates (vertex " +
          list_of(regions) + "); make the mesh or alpha more even there",
      regions);
}

void write_weights(const scene::Scene& scene, const Layering& layering, const std::vector<double>& volume,
                   OneRings rings, WeightMemory* memory, Model& model, Report& report) {
  const RestState state{model.rest, model.mass, model.fibre, model.beta};
  RegionWeights weights = weights_of(scene, layering, rings, memory, model);
  std::vector<float> stiffness = model.alpha;
  for (std::uint32_t i = 0; i < stiffness.size(); ++i)
    if (model.is_kinematic(i)) stiffness[i] = 1.0f;
  if (scene.solver.integrator == scene::Integrator::implicit_step) {
    if (!model.momentum_scaled)
      fail(scene.source,
           "solver.weights: the implicit integrator needs momentum-scaled weights; set \"symmetric\"");
    make_elastic(scene, layering, rings, state, volume, weights, model, report,
                 memory != nullptr ? &memory->elastic : nullptr);
    for (std::uint32_t i = 0; i < stiffness.size(); ++i)
      stiffness[i] = static_cast<float>(model.stiffness[i]);
  }
  Shares shares = make_shares(rings, state, weights, stiffness, model.momentum_scaled);

  report.region_fallbacks = weights.region_fallbacks;
  report.vertex_fallbacks = weights.vertex_fallbacks;
  report.skipped_regions = shares.skipped_regions;
  warn_of_still_regions(std::move(shares.still_regions), model, report);
  model.ring_offset = std::move(rings.offset);
  model.ring = std::move(rings.neighbour);
  model.pull = std::move(shares.pull);
  model.share_taken = std::move(shares.taken);
  model.share_given = std::move(shares.given);
  model.region_rest = std::move(shares.region_rest);
}

void write_skin(const Body& body, Model& model) {
  model.joint_count = body.joint_count;
  model.skin_offset = body.skin.offset;
  model.skin_joint = body.skin.joint;
  for (const double w : body.skin.weight) model.skin_weight.push_back(static_cast<float>(w));
}

void write_render_mesh(const RenderMesh& render, Model& model) {
  for (std::size_t k = 0; k < render.corners.size(); ++k)
    for (std::size_t c = 0; c < 4; ++c) {
      model.surface_vertex.push_back(render.corners[k][c]);
      model.surface_weight.push_back(static_cast<float>(render.weights[k][c]));
    }
  for (const auto& t : render.triangles)
    model.surface_triangle.insert(model.surface_triangle.end(), t.begin(), t.end());
}

void write_probes(const scene::Scene& scene, WhereTest& test, Model& model) {
  for (const scene::ProbeSet& probe : scene.probes) {
    const std::vector<char> inside = test.contains(probe.where, "probe." + probe.name, scene.source);
    model::ProbeSet set{probe.name, {}};
    for (std::uint32_t i = 0; i < inside.size(); ++i)
      if (inside[i]) set.vertices.push_back(i);
    if (set.vertices.empty())
      fail(scene.source, "probe." + probe.name + ": holds no vertex; widen its shapes");
    model.probes.push_back(std::move(set));
  }
}

void report_edges(const mesh::TetMesh& mesh, const OneRings& rings, Report& report) {
  double sum = 0.0;
  std::size_t edges = 0;
  for (std::size_t i = 0; i < rings.size(); ++i)
    for (const std::uint32_t j : rings[i]) {
      if (j < i) continue;
      const double length = (mesh.vertices[j] - mesh.vertices[i]).norm();
      report.shortest_edge = edges == 0 ? length : std::min(report.shortest_edge, length);
      report.longest_edge = std::max(report.longest_edge, length);
      sum += length;
      ++edges;
    }
  report.mean_edge = sum / static_cast<double>(edges);
}

void warn_of_parts(const scene::Scene& scene, const OneRings& rings, const Body& body, const Model& model,
                   Report& report) {
  const Parts parts = connected_parts(rings);
  std::vector<char> held(parts.count, 0), is_flesh(parts.count, 1);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) held[parts.of_vertex[i]] = 1;
    if (holding_of(body, i) == Holding::carrier) is_flesh[parts.of_vertex[i]] = 0;
  }
  std::vector<std::uint32_t> first(parts.count, model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    std::uint32_t& lowest = first[parts.of_vertex[i]];
    lowest = std::min(lowest, model.source_vertex[i]);
  }
  std::vector<std::uint32_t> one_each;
  for (std::uint32_t p = 0; p < parts.count; ++p)
    if (is_flesh[p]) one_each.push_back(first[p]);
  if (one_each.size() > std::max<std::size_t>(body.members.size(), 1)) {
    std::sort(one_each.begin(), one_each.end());
    warn_of_flesh(report,
                  "the mesh has " + std::to_string(one_each.size()) +
                      " parts that do not touch; one vertex of each is listed",
                  one_each);
  }
  // Solids may catch falling parts, so there is no warning.
  if (!scene.colliders.empty()) return;
  std::vector<std::uint32_t> falling;
  for (std::uint32_t p = 0; p < parts.count; ++p)
    if (!held[p]) falling.push_back(first[p]);
  std::sort(falling.begin(), falling.end());
  if (falling.empty()) return;
  warn(report,
       parts.count == 1 ? "nothing holds the body: no vertex is pinned or moved by bones, so gravity makes "
                          "it fall for ever"
                        : counted(falling.size(), "part has", "parts have") +
                              " no vertex that is pinned or moved by bones, and will fall for ever",
       falling);
  report.warnings.back().is_of_gravity = true;
}

constexpr const char* scale_root = "scale its root there";

// A file in millimetres or in hundredths of a metre gives a giant or a dwarf, and gravity acts accordingly.
void warn_of_size(double size, const std::string& name, const std::string& cure, Report& report) {
  constexpr double smallest = 0.05, largest = 20.0;
  if (size >= smallest && size <= largest) return;
  std::ostringstream text;
  text << std::setprecision(3) << name << " is " << size << " m long; if its file is not in metres, " << cure
       << ", or gravity and stiffness will not match its size";
  warn_of_flesh(report, text.str());
}

// Whether all of a character follows the skeleton by its joints and rigid parts alone, as a robot does, so
// that its layers do not matter. If it is the layers that make it rigid, they may be wrong.
bool is_all_rigid(const scene::Scene& scene, const Layering& layering, Measures& measures) {
  const auto all = [](const std::vector<char>& flags) {
    return std::all_of(flags.begin(), flags.end(), [](char flag) { return flag != 0; });
  };
  return std::holds_alternative<rig::Character>(scene.geometry) && all(layering.kinematic) &&
         all(measures.follows_joints());
}

// glibc keeps freed memory: together with a solver's arrays, a sixth of the peak at 107,000 vertices.
void give_freed_memory_back() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::unique_ptr<Ground> lay_ground(const scene::Scene& scene, const BuildOptions& options) {
  auto made = std::make_unique<Ground>();
  Ground& ground = *made;
  Report& report = ground.report;
  Model& model = ground.model;
  if (const auto* character = std::get_if<rig::Character>(&scene.geometry))
    for (const std::string& text : character->notes) warn(report, text);
  check_cancelled(options);
  Body& body = ground.body = make_body(scene, report, options);
  check_cancelled(options);
  model.source_vertex = locality_order(body.mesh, one_rings(body.mesh.vertices.size(), body.mesh.tetrahedra));
  renumber(body, model.source_vertex);
  model.vertex_count = static_cast<std::uint32_t>(body.mesh.vertices.size());
  choose_unit(body.mesh, scene.source, model);
  write_rest(body.mesh, scene.source, model);

  if (std::holds_alternative<rig::Character>(scene.geometry) && scene.characters.empty())
    warn_of_size(extent_without_floors(body, scene), "the character", scale_root, report);
  else if (std::holds_alternative<mesh::TetMesh>(scene.geometry) ||
           std::holds_alternative<mesh::SurfaceMesh>(scene.geometry))
    warn_of_size(extent_without_floors(body, scene), "the mesh", "set mesh.scale", report);

  ground.rings = one_rings(body.mesh.vertices.size(), body.mesh.tetrahedra);
  report_edges(body.mesh, ground.rings, report);
  ground.volume = lumped_volumes(body.mesh);
  ground.measures.emplace(body);
  ground.test.emplace(*ground.measures);
  return made;
}

Ground& ground_of(const scene::Scene& scene, const BuildOptions& options, BuildMemory::Impl& memory) {
  const std::optional<std::string> key = body_key(scene);
  if (!memory.ground || !key || *key != memory.key) {
    memory = {};
    memory.ground = lay_ground(scene, options);
    memory.key = key.value_or("");
  }
  return *memory.ground;
}

Model assemble_model(const scene::Scene& scene, Report& report, const BuildOptions& options,
                     BuildMemory::Impl* memory) {
  const auto start = std::chrono::steady_clock::now();
  std::unique_ptr<Ground> own;
  if (memory == nullptr) own = lay_ground(scene, options);
  Ground& ground = memory == nullptr ? *own : ground_of(scene, options, *memory);
  const Body& body = ground.body;
  Measures& measures = *ground.measures;
  WhereTest& test = *ground.test;
  report = ground.report;
  // Without a memory nobody needs the ground again, so it is not copied.
  Model model = memory == nullptr ? std::move(ground.model) : ground.model;
  OneRings rings;
  model.weight_form = scene.solver.weights;
  model.momentum_scaled = model.weight_form == model::WeightForm::symmetric;

  const Layering layering = assign_layers(scene, test, measures, ground.rings, model.source_vertex, report);
  check_cancelled(options);
  write_layers(scene, layering, ground.volume,
               fibres_of(scene, layering, ground, memory != nullptr ? &memory->fibres : nullptr, report),
               model, report);
  warn_of_parts(scene, ground.rings, body, model, report);
  warn_of_flat_tetrahedra(body.mesh, layering.kinematic, model.source_vertex, report);
  check_cancelled(options);
  if (const std::vector<char> slides = of_sliding_layers(scene, model); !slides.empty())
    rings = sliding_rings(scene, ground.rings, ground.volume, model, slides, report);
  else
    rings = memory == nullptr ? std::move(ground.rings) : ground.rings;
  write_weights(scene, layering, ground.volume, std::move(rings),
                memory != nullptr ? &memory->weights : nullptr, model, report);
  check_cancelled(options);
  std::vector<double> volume_terms;
  for (const scene::Layer& layer : scene.layers) volume_terms.push_back(layer.volume);
  write_volume(volume_terms, model);
  write_ties(scene, model, report);
  std::vector<double> least_volumes;
  for (const scene::Layer& layer : scene.layers) least_volumes.push_back(layer.least_volume);
  write_limits(least_volumes, model);
  add_contact(scene, contact_groups(scene, layering.layer, measures, report),
              memory != nullptr ? &memory->contact : nullptr, model);
  check_shared_masses(scene, model);
  write_colliders(scene, model, report);
  write_skin(body, model);
  if (!scene.characters.empty()) {
    const std::vector<double> sizes = model::extents(model, scene::first_joints(scene));
    for (std::size_t k = 0; k < sizes.size(); ++k)
      warn_of_size(sizes[k], "the character " + scene.characters[k].settings.name, scale_root, report);
  }
  write_muscles(scene, body, test, model, report);
  check_cancelled(options);
  write_render_mesh(body.render, model);
  write_probes(scene, test, model);

  if (ground.boundary.empty()) ground.boundary = boundary_triangles(body.mesh, scene.source);
  ForceTable forces = make_forces(scene, body, test, ground.boundary, model.mass, layering.kinematic);
  model.force_count = static_cast<std::uint32_t>(scene.forces.size());
  model.force_offset = std::move(forces.offset);
  model.force_index = std::move(forces.index);
  model.force_coefficient = std::move(forces.coefficient);

  if (is_all_rigid(scene, layering, measures))
    std::erase_if(report.warnings, [](const Warning& warning) { return warning.is_of_flesh; });
  report.vertices = model.vertex_count;
  report.tetrahedra = model.tetrahedron_count();
  report.surface_vertices = model.surface_count();
  report.surface_triangles = static_cast<std::uint32_t>(model.surface_triangle.size() / 3);
  report.volume = total_volume(body.mesh);
  leave_out_surroundings(model, lumped_volumes(body.mesh), report);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

}  // namespace

Model build_model(const scene::Scene& scene, Report& report, const BuildOptions& options) {
  Model model = assemble_model(scene, report, options, nullptr);
  give_freed_memory_back();
  return model;
}

Model build_model(const scene::Scene& scene, Report& report, const BuildOptions& options,
                  BuildMemory& memory) {
  return assemble_model(scene, report, options, &memory.impl());
}

}  // namespace fascicle::build
