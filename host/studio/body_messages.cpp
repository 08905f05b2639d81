#include "host/studio/body_messages.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "host/model/surroundings.h"
#include "host/render/colour.h"
#include "host/render/decode_image.h"
#include "host/render/model_surface.h"
#include "host/scene/solids.h"
#include "host/studio/wire.h"

namespace fascicle::studio {
namespace {

// Limits on all textures together: bytes, number, and what the browser decodes, 4 bytes each.
constexpr std::size_t most_texture_bytes = std::size_t{128} << 20, most_textures = 128;
constexpr std::size_t most_texels = std::size_t{1} << 28;
constexpr std::size_t most_places = 64;  // per warning
// Where an array's message stores the number of the body with which it was first sent.
constexpr std::size_t body_offset = 4, body_bytes = 4;

const char* wrap_name(gltf::TextureWrap wrap) {
  return wrap == gltf::TextureWrap::clamp ? "clamp" : wrap == gltf::TextureWrap::mirror ? "mirror" : "repeat";
}

std::string hex_colour(const render::Vector3f& linear) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", unsigned{render::byte_of_linear(linear[0])},
                unsigned{render::byte_of_linear(linear[1])}, unsigned{render::byte_of_linear(linear[2])});
  return text.data();
}

Json point_json(std::span<const double, 3> point) {
  return {point[0], point[1], point[2]};
}

std::array<double, 3> rest_place(const model::Model& model, std::uint32_t i) {
  std::array<double, 3> place{};
  for (std::size_t a = 0; a < 3; ++a)
    place[a] = model.rest_origin[a] + model.unit * double{model.rest[3 * std::size_t{i} + a]};
  return place;
}

std::vector<float> rest_places(const model::Model& model) {
  std::vector<float> places;
  places.reserve(model.rest.size());
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (const double x : rest_place(model, i)) places.push_back(static_cast<float>(x));
  return places;
}

// Rest position of each render vertex: the weighted sum of its four embedding vertices.
std::vector<float> surface_rest(const model::Model& model) {
  std::vector<float> places;
  for (std::size_t k = 0; k < model.surface_vertex.size(); k += 4) {
    std::array<double, 3> place{};
    for (std::size_t c = 0; c < 4; ++c) {
      const std::array<double, 3> corner = rest_place(model, model.surface_vertex[k + c]);
      for (std::size_t a = 0; a < 3; ++a) place[a] += double{model.surface_weight[k + c]} * corner[a];
    }
    for (const double x : place) places.push_back(static_cast<float>(x));
  }
  return places;
}

// One per render vertex; empty if the body has no surroundings.
std::vector<std::uint8_t> surroundings(const model::Model& model) {
  const std::vector<char> is_beside = model::surroundings_of(model).surface;
  if (std::count(is_beside.begin(), is_beside.end(), 1) == 0) return {};
  return {is_beside.begin(), is_beside.end()};
}

std::vector<std::uint8_t> surface_layers(const model::Model& model) {
  std::vector<std::uint8_t> layers;
  for (std::size_t k = 0; k < model.surface_vertex.size(); k += 4) {
    const auto first = model.surface_weight.begin() + static_cast<std::ptrdiff_t>(k);
    const auto most = static_cast<std::size_t>(std::max_element(first, first + 4) - first);
    layers.push_back(static_cast<std::uint8_t>(model.layer_of(model.surface_vertex[k + most])));
  }
  return layers;
}

std::vector<std::uint32_t> muscle_vertices(const model::Model& model) {
  std::vector<std::uint32_t> pairs;
  for (std::uint32_t i = 0; i < model.vertex_count && model.muscle_count > 0; ++i)
    for (std::uint32_t k = model.muscle_offset[i]; k < model.muscle_offset[i + 1]; ++k) {
      pairs.push_back(i);
      pairs.push_back(model.region_muscle[k].muscle);
    }
  return pairs;
}

bool has_same_items(const std::string& a, const std::string& b) {
  constexpr std::size_t behind = body_offset + body_bytes;
  return a.size() == b.size() && a.size() >= behind && std::memcmp(a.data(), b.data(), body_offset) == 0 &&
         std::memcmp(a.data() + behind, b.data() + behind, a.size() - behind) == 0;
}

void add_look_textures(const gltf::Looks& read, const std::string& file, BodyLooks& looks,
                       std::vector<std::int32_t>& numbers, const pipeline::Say& say) {
  std::size_t bytes = 0, texels = 0;
  for (const gltf::LookTexture& texture : read.textures) {
    numbers.push_back(-1);
    render::ImageHeader picture = render::image_header(*texture.bytes);
    if (picture.flaw.empty() &&
        (bytes + texture.bytes->size() > most_texture_bytes || looks.images.size() == most_textures ||
         texels + picture.width * picture.height > most_texels))
      picture.flaw = "exceeds the studio's limit on textures";
    if (!picture.flaw.empty()) {
      pipeline::say_warning(
          say, file + ": " + texture.name + " " + picture.flaw + "; its surface gets its plain colour");
      continue;
    }
    bytes += texture.bytes->size();
    texels += picture.width * picture.height;
    numbers.back() = static_cast<std::int32_t>(looks.images.size());
    looks.textures.push_back({{"name", texture.name},
                              {"type", picture.type},
                              {"wrap", {wrap_name(texture.across), wrap_name(texture.down)}}});
    looks.images.push_back(std::make_shared<const std::string>(texture.bytes->begin(), texture.bytes->end()));
  }
}

// The constant properties of the solids, and where they start; frames have their current positions.
Json solids_json(const BodyParts& parts) {
  Json list = Json::array();
  if (parts.scene == nullptr || !parts.model.has_colliders()) return list;
  for (const scene::Collider& collider : parts.scene->colliders) {
    const scene::Solid solid = scene::bound_solid_of(*parts.scene, collider);
    const auto list_of = [](const auto& v) { return Json{v[0], v[1], v[2]}; };
    const scene::Vector3d up = solid.axes.col(1);
    list.push_back({{"name", collider.name},
                    {"shape", names_of(collider.shape)[static_cast<std::size_t>(collider.shape)]},
                    {"half_size", list_of(solid.half_size)},
                    {"radius", solid.radius},
                    {"middle", list_of(solid.center)},
                    {"up", list_of(up)}});
  }
  return list;
}

Json joints_json(const BodyParts& parts) {
  Json list = Json::array();
  const auto* character =
      parts.scene == nullptr ? nullptr : std::get_if<rig::Character>(&parts.scene->geometry);
  if (character == nullptr || !parts.model.has_skeleton()) return list;
  for (const rig::Joint& joint : character->skeleton) {
    Json one{{"name", joint.name}, {"parent", joint.parent}};
    if (parts.report != nullptr)
      for (const build::JointReport& found : parts.report->joints)
        if (found.name == joint.name) {
          one["is_bone"] = found.is_bone;
          one["is_kinematic"] = found.is_kinematic;
          one["reason"] = found.reason;
          break;
        }
    list.push_back(std::move(one));
  }
  return list;
}

}  // namespace

std::vector<std::uint32_t> strongest_joints(const model::Model& model) {
  std::vector<std::uint32_t> joints;
  for (std::uint32_t i = 0; i < model.vertex_count && model.has_skeleton(); ++i) {
    const auto first = model.skin_weight.begin() + model.skin_offset[i];
    const auto last = model.skin_weight.begin() + model.skin_offset[i + 1];
    joints.push_back(
        model
            .skin_joint[static_cast<std::size_t>(std::max_element(first, last) - model.skin_weight.begin())]);
  }
  return joints;
}

SharedBytes message_text(const Json& json) {
  return std::make_shared<const std::string>(scene::dump(json));
}

BodyLooks read_body_looks(const std::filesystem::path& character, const model::Model& model,
                          const pipeline::Say& say) {
  BodyLooks looks;
  if (character.empty() || model.surface_count() == 0) return looks;
  const std::string file = character.string();
  try {
    const gltf::Rig rig = gltf::read_rig(character);
    const gltf::Looks read = gltf::read_looks(character, rig);
    for (const std::string& note : read.notes) pipeline::say_warning(say, file + ": " + note);
    if (!read.has_colours) return looks;
    bool has_uvs = false, has_colours = false;
    for (const gltf::PartLooks& part : read.parts) {
      has_uvs = has_uvs || !part.uvs.empty();
      has_colours = has_colours || !part.colours.empty();
    }
    for (std::size_t p = 0; p < read.parts.size(); ++p) {
      const gltf::PartLooks& part = read.parts[p];
      for (std::size_t i = 0; i < rig.parts[p].positions.size(); ++i) {
        looks.material.push_back(part.material);
        for (int a = 0; a < 2 && has_uvs; ++a)
          looks.uvs.push_back(part.uvs.empty() ? 0.0f : static_cast<float>(part.uvs[i][a]));
        for (int a = 0; a < 3 && has_colours; ++a)
          looks.colours.push_back(part.colours.empty() ? 1.0f : static_cast<float>(part.colours[i][a]));
      }
    }
    if (looks.material.size() != model.surface_count()) {
      pipeline::say_warning(
          say, file + ": its vertices do not match the surface; it is shown without its colours");
      return {};
    }
    std::vector<std::int32_t> numbers;
    add_look_textures(read, file, looks, numbers, say);
    for (const gltf::LookMaterial& material : read.materials) {
      const Eigen::Vector4d& c = material.base_colour;
      looks.materials.push_back(
          {{"name", material.name},
           {"colour", {c[0], c[1], c[2], c[3]}},
           {"alpha_cutoff", material.alpha_cutoff},
           {"texture", material.texture < 0 ? -1 : numbers[static_cast<std::size_t>(material.texture)]}});
    }
    return looks;
  } catch (const scene::SceneError& error) {
    pipeline::say_warning(say, std::string(error.what()) + "; the character is shown without its colours");
    return {};
  }
}

std::vector<ArrayMessage> array_messages(const BodyParts& parts, const BodyLooks& looks, std::uint32_t body,
                                         const std::vector<ArrayMessage>& before) {
  const model::Model& model = parts.model;
  std::vector<ArrayMessage> all;
  const auto keep = [&](const std::string& name, std::string bytes) {
    for (const ArrayMessage& old : before)
      if (old.name == name && has_same_items(*old.bytes, bytes)) {
        all.push_back(old);
        return;
      }
    all.push_back({name, std::make_shared<const std::string>(std::move(bytes))});
  };
  const auto add = [&]<class Item>(const std::string& name, const std::vector<Item>& items) {
    keep(name, encode_array(name, body, std::span<const Item>(items)));
  };
  const auto add_where_there = [&](const std::string& name, const auto& items) {
    if (!items.empty()) add(name, items);
  };
  if (model.surface_count() > 0) {
    add("surface.rest", surface_rest(model));
    add("surface.triangle", model.surface_triangle);
    add("surface.layer", surface_layers(model));
    add_where_there("surface.surroundings", surroundings(model));
    add_where_there("surface.material", looks.material);
    add_where_there("surface.uv", looks.uvs);
    add_where_there("surface.colour", looks.colours);
  }
  add("rest", rest_places(model));
  add("tetrahedron", model.tetrahedron);
  std::vector<std::uint8_t> layer, kinematic;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    layer.push_back(static_cast<std::uint8_t>(model.layer_of(i)));
    kinematic.push_back(model.is_kinematic(i) ? 1 : 0);
  }
  add("layer", layer);
  add("kinematic", kinematic);
  add("fibre", model.fibre);
  add_where_there("muscle.vertex", muscle_vertices(model));
  add_where_there("skin.joint", strongest_joints(model));
  for (std::size_t k = 0; k < looks.images.size(); ++k) {
    const std::string& image = *looks.images[k];
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(image.data());
    const std::string name = "texture." + std::to_string(k);
    keep(name, encode_array(name, body, std::span<const std::uint8_t>(bytes, image.size())));
  }
  return all;
}

Json layers_json(const model::Model& model) {
  std::vector<std::uint32_t> vertices(model.layers.size(), 0);
  std::vector<double> masses(model.layers.size(), 0.0);
  const std::vector<char> is_beside = model::surroundings_of(model).vertices;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    ++vertices[model.layer_of(i)];
    if (is_beside[i] == 0) masses[model.layer_of(i)] += model.mass[i];
  }
  Json layers = Json::array();
  for (std::size_t l = 0; l < model.layers.size(); ++l)
    layers.push_back({{"name", model.layers[l].name},
                      {"kinematic", model.layers[l].kinematic},
                      {"vertices", vertices[l]},
                      {"mass", masses[l]},
                      {"colour", hex_colour(render::layer_colour(model.layers[l].name, l))}});
  return layers;
}

Json counts_json(const model::Model& model) {
  return {{"vertices", model.vertex_count},
          {"tetrahedra", model.tetrahedron_count()},
          {"surface_vertices", model.surface_count()},
          {"surface_triangles", model.surface_triangle.size() / 3},
          {"joints", model.joint_count}};
}

std::vector<ArrayMessage> shape_messages(const model::Model& model, const std::string& prefix) {
  std::vector<ArrayMessage> all;
  const auto add = [&]<class Item>(const char* name, const std::vector<Item>& items) {
    const std::string whole = prefix + name;
    all.push_back(
        {whole, std::make_shared<const std::string>(encode_array(whole, 0, std::span<const Item>(items)))});
  };
  if (model.surface_count() > 0) {
    add("surface.rest", surface_rest(model));
    add("surface.triangle", model.surface_triangle);
    add("surface.layer", surface_layers(model));
  }
  add("rest", rest_places(model));
  add("tetrahedron", model.tetrahedron);
  std::vector<std::uint8_t> layer;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    layer.push_back(static_cast<std::uint8_t>(model.layer_of(i)));
  add("layer", layer);
  return all;
}

// Of the rest shape, m: of the model's vertices but those that carry surroundings, and of what else these
// carry.
std::pair<std::array<double, 3>, std::array<double, 3>> bounds_of(const model::Model& model) {
  const model::Surroundings beside = model::surroundings_of(model);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  const auto extend = [&](std::size_t axis, double place) {
    low[axis] = std::min(low[axis], place);
    high[axis] = std::max(high[axis], place);
  };
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (std::size_t a = 0; a < 3 && beside.vertices[i] == 0; ++a) extend(a, rest_place(model, i)[a]);
  const std::vector<float> surface = surface_rest(model);
  for (std::size_t s = 0; s < beside.surface.size(); ++s) {
    const bool is_on_carrier = beside.vertices[model.surface_vertex[4 * s]] != 0;
    for (std::size_t a = 0; a < 3 && is_on_carrier && beside.surface[s] == 0; ++a)
      extend(a, double{surface[3 * s + a]});
  }
  return {low, high};
}

Json body_json(const BodyParts& parts, const BodyLooks& looks, std::uint32_t body,
               const std::vector<ArrayMessage>& arrays) {
  const model::Model& model = parts.model;
  const auto [low, high] = bounds_of(model);
  Json muscles = Json::array(), probes = Json::array(), names = Json::array();
  for (std::uint32_t m = 0; m < model.muscle_count; ++m)
    muscles.push_back(
        {{"name", parts.scene != nullptr ? parts.scene->muscles.at(m).name : std::to_string(m)}});
  for (const model::ProbeSet& probe : model.probes) probes.push_back({{"name", probe.name}});
  for (const ArrayMessage& array : arrays) names.push_back(array.name);
  return {{"type", "body"},
          {"body", body},
          {"counts", counts_json(model)},
          {"unit", model.unit},
          {"bounds", {point_json(low), point_json(high)}},
          {"has_contact", model.has_contact()},
          {"layers", layers_json(model)},
          {"solids", solids_json(parts)},
          {"joints", joints_json(parts)},
          {"muscles", std::move(muscles)},
          {"probes", std::move(probes)},
          {"materials", looks.materials},
          {"textures", looks.textures},
          {"arrays", std::move(names)}};
}

Json clip_json(const scene::Scene& scene, std::uint64_t frames, std::uint32_t substeps,
               std::uint32_t iterations) {
  Json clips = Json::array();
  if (const auto* character = std::get_if<rig::Character>(&scene.geometry);
      character && scene.characters.empty())
    for (const rig::Clip& clip : character->clips) clips.push_back(clip.name);
  return {{"type", "clip"},
          {"name", scene::clip_name(scene)},
          {"clips", std::move(clips)},
          {"fps", scene.fps},
          {"start", scene.start},
          {"frames", frames},
          {"substeps", substeps},
          {"iterations", iterations}};
}

Json warnings_json(const model::Model& model, const std::vector<build::Warning>& warnings) {
  // Warnings number vertices as in the mesh that the model was built from.
  std::vector<std::uint32_t> number(model.vertex_count, model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (model.source_vertex[i] < model.vertex_count) number[model.source_vertex[i]] = i;
  Json list = Json::array();
  for (const build::Warning& warning : warnings) {
    Json places = Json::array(), vertices = Json::array();
    for (const std::uint32_t v : warning.vertices) {
      if (places.size() == most_places) break;
      if (v >= model.vertex_count || number[v] >= model.vertex_count) continue;
      places.push_back(point_json(rest_place(model, number[v])));
      vertices.push_back(number[v]);
    }
    list.push_back(
        {{"text", warning.text}, {"places", std::move(places)}, {"vertices", std::move(vertices)}});
  }
  return list;
}

}  // namespace fascicle::studio
