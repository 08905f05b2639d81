#include "host/formats/joined_document.h"

#include <array>
#include <utility>
#include <vector>

#include "host/base/json_number.h"
#include "host/gltf/gltf_material.h"

namespace fascicle::formats {

using nlohmann::json;

namespace {

constexpr std::array<const char*, 11> lists{"accessors", "animations", "bufferViews", "cameras",
                                            "images",    "materials",  "meshes",      "nodes",
                                            "samplers",  "skins",      "textures"};
constexpr const char* lights = "KHR_lights_punctual";

std::size_t count_of(const json& document, const char* list) {
  const auto found = document.find(list);
  return found != document.end() && found->is_array() ? found->size() : 0;
}

void shift(json& object, const char* key, std::size_t by) {
  const auto found = object.find(key);
  if (found == object.end()) return;
  if (const auto number = base::whole_number<std::size_t>(*found)) *found = *number + by;
}

void shift_each(json& object, const char* key, std::size_t by) {
  const auto found = object.find(key);
  if (found == object.end()) return;
  for (json& number : *found)
    if (const auto own = base::whole_number<std::size_t>(number)) number = *own + by;
}

// Texture indices in a material and its extensions: {"index": n}.
void shift_textures(json& value, std::size_t by) {
  if (value.is_object()) shift(value, "index", by);
  if (!value.is_structured()) return;
  for (auto& [key, inner] : value.items())
    if (key != "extras") shift_textures(inner, by);
}

// How far one document's indices shift when its lists are appended to another's.
struct Shifts {
  std::size_t bytes = 0, lights = 0;
  std::size_t accessors = 0, views = 0, images = 0, materials = 0, meshes = 0, nodes = 0, samplers = 0,
              skins = 0, textures = 0, cameras = 0;
};

void shift_data(json& document, const Shifts& by) {
  for (json& view : document["bufferViews"])
    view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + by.bytes;
  for (json& accessor : document["accessors"]) {
    shift(accessor, "bufferView", by.views);
    for (const char* part : {"indices", "values"})
      if (accessor.contains("sparse")) shift(accessor["sparse"][part], "bufferView", by.views);
  }
  for (json& image : document["images"]) shift(image, "bufferView", by.views);
}

void shift_looks(json& document, const Shifts& by) {
  for (json& texture : document["textures"]) {
    shift(texture, "sampler", by.samplers);
    shift(texture, "source", by.images);
    if (texture.contains("extensions"))
      for (json& extension : texture["extensions"])
        if (extension.is_object()) shift(extension, "source", by.images);
  }
  for (json& material : document["materials"]) shift_textures(material, by.textures);
  for (json& mesh : document["meshes"])
    for (json& primitive : mesh["primitives"]) {
      primitive.erase("extensions");
      shift(primitive, "indices", by.accessors);
      shift(primitive, "material", by.materials);
      for (json& accessor : primitive["attributes"]) accessor = accessor.get<std::size_t>() + by.accessors;
      if (primitive.contains("targets"))
        for (json& target : primitive["targets"])
          for (json& accessor : target) accessor = accessor.get<std::size_t>() + by.accessors;
    }
}

void shift_nodes(json& document, const std::string& name, const Shifts& by) {
  for (json& node : document["nodes"]) {
    const std::string own = node.value("name", std::string());
    node["name"] = own.starts_with(name + "/") ? own : name + "/" + own;
    shift_each(node, "children", by.nodes);
    shift(node, "mesh", by.meshes);
    shift(node, "skin", by.skins);
    shift(node, "camera", by.cameras);
    if (!node.contains("extensions")) continue;
    json kept = json::object();
    if (node["extensions"].contains(lights)) {
      kept[lights] = node["extensions"][lights];
      shift(kept[lights], "light", by.lights);
    }
    node.erase("extensions");
    if (!kept.empty()) node["extensions"] = std::move(kept);
  }
  for (json& skin : document["skins"]) {
    shift(skin, "inverseBindMatrices", by.accessors);
    shift(skin, "skeleton", by.nodes);
    shift_each(skin, "joints", by.nodes);
  }
  for (json& animation : document["animations"]) {
    animation["name"] = name + "/" + animation.value("name", std::string());
    for (const char* list : {"samplers", "channels"})
      if (!animation.contains(list)) animation[list] = json::array();
    for (json& sampler : animation["samplers"])
      for (const char* end : {"input", "output"}) shift(sampler, end, by.accessors);
    for (json& channel : animation["channels"]) shift(channel["target"], "node", by.nodes);
  }
}

void append_texts(json& to, const json& from, const char* key) {
  for (const json& text : from.value(key, json::array())) {
    if (!to.contains(key)) to[key] = json::array();
    bool is_there = false;
    for (const json& known : to[key]) is_there = is_there || known == text;
    if (!is_there) to[key].push_back(text);
  }
}

// Appends the part's lights; returns how many there were before.
std::size_t append_lights(json& to, const json& from) {
  const std::size_t before = to.contains("extensions") && to["extensions"].contains(lights)
                                 ? to["extensions"][lights]["lights"].size()
                                 : 0;
  const json extensions = from.value("extensions", json::object());
  if (!extensions.contains(lights)) return before;
  for (const json& light : extensions[lights].value("lights", json::array()))
    to["extensions"][lights]["lights"].push_back(light);
  return before;
}

}  // namespace

std::vector<std::size_t> shown_roots(const json& document) {
  const json& scenes = gltf::json_member(document, "scenes");
  if (!scenes.empty()) {
    const json& nodes = gltf::json_member(scenes.at(document.value("scene", std::size_t{0})), "nodes");
    return nodes.is_null() ? std::vector<std::size_t>() : nodes.get<std::vector<std::size_t>>();
  }
  const json& nodes = gltf::json_member(document, "nodes");
  std::vector<bool> is_child(nodes.size(), false);
  for (const json& node : nodes)
    for (const json& child : gltf::json_member(node, "children"))
      is_child.at(child.get<std::size_t>()) = true;
  std::vector<std::size_t> roots;
  for (std::size_t n = 0; n < is_child.size(); ++n)
    if (!is_child[n]) roots.push_back(n);
  return roots;
}

std::size_t add_document(gltf::GltfDocument& to, gltf::GltfDocument part, const NodeAbove& above) {
  to.binary.resize((to.binary.size() + 3) / 4 * 4, '\0');
  const std::size_t number = count_of(to.json, "nodes");
  const auto before = [&](const char* list) { return count_of(to.json, list); };
  const Shifts by{.bytes = to.binary.size(),
                  .lights = append_lights(to.json, part.json),
                  .accessors = before("accessors"),
                  .views = before("bufferViews"),
                  .images = before("images"),
                  .materials = before("materials"),
                  .meshes = before("meshes"),
                  .nodes = number + 1,
                  .samplers = before("samplers"),
                  .skins = before("skins"),
                  .textures = before("textures"),
                  .cameras = before("cameras")};
  to.binary += part.binary;
  for (const char* list : lists)
    if (!part.json.contains(list)) part.json[list] = json::array();
  const std::vector<std::size_t> roots = shown_roots(part.json);
  shift_data(part.json, by);
  shift_looks(part.json, by);
  shift_nodes(part.json, above.name, by);

  json children = json::array();
  for (const std::size_t root : roots) children.push_back(root + by.nodes);
  json node{{"name", above.name}};
  node.update(above.transform);
  if (!children.empty()) node["children"] = std::move(children);
  if (!to.json.contains("nodes")) to.json["nodes"] = json::array();
  to.json["nodes"].push_back(std::move(node));
  if (above.parent)
    to.json["nodes"][*above.parent]["children"].push_back(number);
  else
    to.json["scenes"][0]["nodes"].push_back(number);
  for (const char* list : lists)
    for (json& entry : part.json[list]) {
      if (!to.json.contains(list)) to.json[list] = json::array();
      to.json[list].push_back(std::move(entry));
    }
  append_texts(to.json, part.json, "extensionsUsed");
  append_texts(to.json, part.json, "extensionsRequired");
  return number;
}

}  // namespace fascicle::formats
