#include "host/build/build_memory.h"

#include <span>
#include <string_view>
#include <utility>

#include "host/base/content_hash.h"
#include "host/build/contacts.h"
#include "host/build/fibre.h"
#include "host/build/filled_body.h"
#include "host/build/limits.h"
#include "host/scene/scene_json.h"

namespace fascicle::build {

namespace {

using model::Model;

// Characters made in code have no file whose hash could identify them.
void add_character(base::ContentHash& hash, const rig::Character& character) {
  add_points(hash, character.surface.vertices);
  for (const auto& weights : character.weights) hash.add_array(std::span<const double>(weights));
  for (const rig::Joint& joint : character.skeleton) {
    hash.add(std::string_view(joint.name));
    hash.add_array(std::span<const double>(joint.inverse_bind.data(), 16));
  }
}

// Everything that fibre_directions reads besides the body.
std::string fibre_key_of(const scene::Scene& scene, const std::vector<std::uint32_t>& layer_of) {
  base::ContentHash hash;
  hash.add_array(std::span<const std::uint32_t>(layer_of));
  for (const scene::Layer& layer : scene.layers) {
    hash.add(layer.fibre_field);
    hash.add(layer.kinematic);
    hash.add(layer.fibre.has_value());
    for (int a = 0; a < 3 && layer.fibre; ++a) hash.add((*layer.fibre)[a]);
  }
  hash.add(std::string_view(scene::dump(scene::json_of(scene.fibres))));
  return hash.text();
}

// Everything that region_weights and ElasticMemory read besides the body.
std::string weights_key_of(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                           const Model& model) {
  base::ContentHash hash;
  hash.add_array(std::span<const std::uint32_t>(rings.offset));
  hash.add_array(std::span<const std::uint32_t>(rings.neighbour));
  hash.add(model.weight_form);
  hash.add_array(std::span<const std::uint32_t>(layering.layer));
  hash.add_array(std::span<const char>(layering.kinematic));
  hash.add_array(std::span<const double>(model.mass));
  hash.add_array(std::span<const float>(model.fibre));
  hash.add_array(std::span<const float>(model.beta));
  for (const scene::Layer& layer : scene.layers) hash.add(layer.sliding);
  return hash.text();
}

// Everything that write_contact reads besides the body, except the friction and the masses.
std::string contact_key_of(const scene::Scene& scene, const ContactGroups& groups, const Model& model) {
  scene::ContactSettings settings = scene.contact;
  settings.friction = 0.0;
  base::ContentHash hash;
  hash.add(std::string_view(scene::dump(scene::json_of(settings))));
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) hash.add(model.is_kinematic(i));
  hash.add_array(std::span<const char>(groups.meets_nothing));
  hash.add_array(std::span<const std::uint32_t>(groups.groups));
  hash.add_array(std::span<const std::uint32_t>(groups.ignored));
  hash.add(groups.meets_others_only);
  // Layers that slide share no regions with the flesh below, which makes a gap of the border.
  hash.add_array(std::span<const std::uint32_t>(model.ring_offset));
  hash.add_array(std::span<const std::uint32_t>(model.ring));
  return hash.text();
}

void copy_contact(const Model& from, Model& to) {
  to.contact = from.contact;
  to.contact_near = from.contact_near;
  to.contact_tetrahedron = from.contact_tetrahedron;
  to.contact_depth = from.contact_depth;
  to.contact_number = from.contact_number;
  to.contact_offset = from.contact_offset;
  to.contact_entry = from.contact_entry;
  to.contact_rest_box = from.contact_rest_box;
  to.contact_ignored = from.contact_ignored;
  to.contact_group = from.contact_group;
}

}  // namespace

BuildMemory::BuildMemory() : impl_(std::make_unique<Impl>()) {}
BuildMemory::~BuildMemory() = default;
BuildMemory::BuildMemory(BuildMemory&&) noexcept = default;
BuildMemory& BuildMemory::operator=(BuildMemory&&) noexcept = default;

std::optional<std::string> body_key(const scene::Scene& scene) {
  if (scene.input_hashes.empty()) return std::nullopt;
  scene::Json parameters = scene::json_of(scene);
  for (const char* key : {"name", "source", "text", "layers", "flesh", "fibres", "muscles", "pins", "probes",
                          "forces", "colliders", "gravity", "solver"})
    parameters.erase(key);
  // For several characters, the fill uses the poses of the clip that joins theirs.
  if (scene.characters.empty())
    for (const char* key : {"fps", "start", "end", "frames", "motion", "clip", "clip_name", "contact"})
      parameters.erase(key);
  base::ContentHash hash;
  hash.add(std::string_view(scene::dump(parameters)));
  // The scene file itself is not part of the body; the files it names are.
  for (const auto& [file, file_hash] : scene.input_hashes)
    if (file != scene.source) hash.add(std::string_view(file_hash));
  if (const auto* character = std::get_if<rig::Character>(&scene.geometry)) add_character(hash, *character);
  if (const auto* surface = std::get_if<mesh::SurfaceMesh>(&scene.geometry))
    add_points(hash, surface->vertices);
  return hash.text();
}

std::vector<float> fibres_of(const scene::Scene& scene, const Layering& layering, Ground& ground,
                             FibreMemory* memory, Report& report) {
  const auto solve = [&] {
    return fibre_directions(scene, layering.layer, ground.rings, *ground.measures, report);
  };
  if (memory == nullptr) return solve();
  std::string key = fibre_key_of(scene, layering.layer);
  if (memory->key != key) {
    memory->key.clear();
    const auto known = static_cast<std::ptrdiff_t>(report.warnings.size());
    memory->directions = solve();
    memory->report = report.fibres;
    memory->warnings.assign(report.warnings.begin() + known, report.warnings.end());
    memory->key = std::move(key);
  } else {
    report.fibres = memory->report;
    report.warnings.insert(report.warnings.end(), memory->warnings.begin(), memory->warnings.end());
  }
  return memory->directions;
}

RegionWeights weights_of(const scene::Scene& scene, const Layering& layering, const OneRings& rings,
                         WeightMemory* memory, const Model& model) {
  const RestState state{model.rest, model.mass, model.fibre, model.beta};
  if (memory == nullptr) return region_weights(rings, state, model.weight_form);
  if (std::string key = weights_key_of(scene, layering, rings, model); key != memory->key) {
    *memory = {};
    memory->weights = region_weights(rings, state, model.weight_form);
    memory->key = std::move(key);
  }
  return memory->weights;
}

void add_contact(const scene::Scene& scene, const ContactGroups& groups, ContactMemory* memory,
                 Model& model) {
  if (memory == nullptr) return write_contact(scene.contact, scene.source, model, groups);
  if (std::string key = contact_key_of(scene, groups, model); key != memory->key) {
    memory->key.clear();
    write_contact(scene.contact, scene.source, model, groups);
    copy_contact(model, memory->arrays);
    memory->key = std::move(key);
    return;
  }
  copy_contact(memory->arrays, model);
  if (!model.has_contact()) return;
  for (shader::ContactPoint& point : model.contact) point.friction = model::as_factor(scene.contact.friction);
  write_mobility(model);
}

}  // namespace fascicle::build
