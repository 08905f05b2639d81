// What no character needs. Files made from a glTF file copy it, change its indices and add to its lists. What
// they could not use is dropped from the document that is passed on.
#include "host/gltf/gltf_check_steps.h"
#include "host/gltf/gltf_material.h"

namespace fascicle::gltf {
namespace {

using nlohmann::json;

// Entries that are not objects become empty objects, so that indices stay valid.
void keep_objects(json& document, const char* list) {
  const auto found = document.find(list);
  if (found == document.end()) return;
  if (!found->is_array()) {
    document.erase(found);
    return;
  }
  for (json& entry : *found)
    if (!entry.is_object()) entry = json::object();
}

void keep_indices(json& object, const json& list) {
  for (auto entry = object.begin(); entry != object.end();)
    entry = json_index(*entry, list) ? std::next(entry) : object.erase(entry);
}

// Attributes have a value for each vertex: readers would look beyond one with fewer.
void keep_counts(json& attributes, const json& accessors) {
  const auto position = attributes.find("POSITION");
  if (position == attributes.end()) return;
  const auto count_of = [&](const json& number) { return accessors[number.get<std::size_t>()]["count"]; };
  const json count = count_of(*position);
  for (auto entry = attributes.begin(); entry != attributes.end();)
    entry = count_of(*entry) == count ? std::next(entry) : attributes.erase(entry);
}

void keep_texts(json& document, const char* list) {
  const auto found = document.find(list);
  if (found == document.end()) return;
  json texts = json::array();
  if (found->is_array())
    for (const json& entry : *found)
      if (entry.is_string()) texts.push_back(entry);
  if (texts.empty())
    document.erase(found);
  else
    *found = std::move(texts);
}

void keep_lights(json& document) {
  constexpr const char* name = "KHR_lights_punctual";
  const auto extensions = document.find("extensions");
  if (extensions == document.end()) return;
  if (!extensions->is_object()) {
    document.erase(extensions);
    return;
  }
  const auto lights = extensions->find(name);
  if (lights == extensions->end()) return;
  if (!lights->is_object())
    extensions->erase(lights);
  else
    keep_objects(*lights, "lights");
}

}  // namespace

void GltfCheck::pass_on() {
  json& document = file_.document;
  for (const char* list : {"cameras", "images", "materials", "samplers", "textures"})
    keep_objects(document, list);
  keep_texts(document, "extensionsUsed");
  keep_lights(document);
  const json &views = json_member(document, "bufferViews"), &accessors = json_member(document, "accessors");
  if (document.contains("images"))
    for (json& image : document["images"])
      if (image.contains("bufferView") && !json_index(image["bufferView"], views)) image.erase("bufferView");
  if (!document.contains("meshes")) return;
  for (json& mesh : document["meshes"])
    for (json& primitive : mesh["primitives"]) {
      keep_indices(primitive["attributes"], accessors);
      keep_counts(primitive["attributes"], accessors);
      if (primitive.contains("targets"))
        for (json& target : primitive["targets"]) keep_indices(target, accessors);
    }
}

}  // namespace fascicle::gltf
