// Decodes compressed views and primitives into plain ones with their own buffers. This step runs before any
// other step reads buffer views.
#include <algorithm>
#include <array>
#include <set>

#include "host/gltf/gltf_check_steps.h"
#include "host/gltf/gltf_codecs.h"

namespace fascicle::gltf {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 2> meshopt_names{"EXT_meshopt_compression", "KHR_meshopt_compression"};
constexpr const char* draco_name = "KHR_draco_mesh_compression";

// Limit on all decompressed data together.
constexpr std::uint64_t most_decoded_bytes = gltf_largest_file;

unsigned digit(char c) {
  if (c >= 'A' && c <= 'Z') return static_cast<unsigned>(c - 'A');
  if (c >= 'a' && c <= 'z') return static_cast<unsigned>(c - 'a') + 26;
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0') + 52;
  return c == '+' ? 62 : 63;
}

// The text was checked to be base64.
std::vector<unsigned char> from_base64(const std::string& uri) {
  std::vector<unsigned char> bytes;
  unsigned held = 0;
  int bits = 0;
  for (std::size_t i = uri.find(',') + 1; i < uri.size() && uri[i] != '='; ++i) {
    held = held << 6 | digit(uri[i]);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<unsigned char>(held >> bits));
    held &= (1u << bits) - 1u;
  }
  return bytes;
}

void erase_name(json& document, const char* list, const std::string& name) {
  const auto found = document.find(list);
  if (found == document.end() || !found->is_array()) return;
  json kept = json::array();
  for (const json& each : *found)
    if (each != name) kept.push_back(each);
  if (kept.empty()) {
    document.erase(list);
  } else {
    *found = std::move(kept);
  }
}

void erase_extension(json& owner, const std::string& name) {
  owner["extensions"].erase(name);
  if (owner["extensions"].empty()) owner.erase("extensions");
}

}  // namespace

std::optional<GltfPlace> GltfCheck::extension(const GltfPlace& owner, const char* name) const {
  const json* extensions = member(owner, "extensions");
  if (extensions == nullptr || !extensions->is_object() || !extensions->contains(name)) return std::nullopt;
  return object({extensions, owner.pointer + "/extensions"}, name);
}

// The fallback buffer for readers without meshopt; this reader decodes its views from elsewhere.
bool GltfCheck::is_fallback(const GltfPlace& buffer) const {
  return std::any_of(meshopt_names.begin(), meshopt_names.end(), [&](const char* name) {
    const std::optional<GltfPlace> found = extension(buffer, name);
    if (!found) return false;
    const json* fallback = member(*found, "fallback");
    return fallback != nullptr && fallback->is_boolean() && fallback->get<bool>();
  });
}

std::span<const unsigned char> GltfCheck::compressed_bytes(const GltfPlace& place) {
  const std::size_t buffer = required_index(place, "buffer", "buffers");
  const std::uint64_t offset = optional_whole(place, "byteOffset").value_or(0);
  const std::uint64_t length = required_whole(place, "byteLength");
  if (length == 0 || offset + length > buffer_bytes_[buffer])
    fail(place.pointer + "/byteLength", "bytes " + std::to_string(offset) + " to " +
                                            std::to_string(offset + length) + " of a buffer of " +
                                            std::to_string(buffer_bytes_[buffer]));
  const std::string uri = out_["buffers"][buffer]["uri"];
  if (uri.starts_with("data:") && !data_uris_.contains(buffer)) data_uris_[buffer] = from_base64(uri);
  const std::vector<unsigned char>& bytes =
      uri.starts_with("data:") ? data_uris_[buffer] : checked_.buffers.at(uri);
  return std::span(bytes).subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
}

// Adds the bytes as a new buffer; returns its index.
std::size_t GltfCheck::add_buffer(const std::string& pointer, std::vector<unsigned char> bytes) {
  decoded_bytes_ += bytes.size();
  if (decoded_bytes_ > most_decoded_bytes)
    fail(pointer,
         "the compressed data has more than " + std::to_string(most_decoded_bytes) + " bytes in all");
  const std::size_t number = buffer_bytes_.size();
  const std::string name = "buffer-" + std::to_string(number);
  buffer_bytes_.push_back(bytes.size());
  out_["buffers"].push_back({{"byteLength", bytes.size()}, {"uri", name}, {"name", decoded_buffer}});
  file_.document["buffers"].push_back({{"byteLength", bytes.size()}});
  checked_.buffers[name] = std::move(bytes);
  return number;
}

void GltfCheck::meshopt_views() {
  const std::vector<GltfPlace> places = objects({&file_.document, ""}, "bufferViews");
  for (std::size_t v = 0; v < places.size(); ++v) {
    for (const char* name : meshopt_names) {
      const std::optional<GltfPlace> place = extension(places[v], name);
      if (!place) continue;
      const std::span<const unsigned char> stream = compressed_bytes(*place);
      const std::uint64_t count = required_whole(*place, "count"),
                          stride = required_whole(*place, "byteStride");
      const std::string mode = optional_text(*place, "mode").value_or(""),
                        filter = optional_text(*place, "filter").value_or("NONE");
      std::vector<unsigned char> bytes;
      try {
        bytes = decode_meshopt(stream, count, stride, mode, filter);
      } catch (const CodecError& error) {
        fail(place->pointer, error.what());
      }
      json plain{{"byteOffset", 0u}, {"byteLength", bytes.size()}};
      plain["buffer"] = add_buffer(place->pointer, std::move(bytes));
      json& view = file_.document["bufferViews"][v];
      // The extension's stride is that of the compressed elements. Where the view has none, its accessors are
      // tightly packed, and may have elements of several sizes, such as a clip's times and rotations.
      for (const char* kept : {"byteStride", "target"})
        if (view.contains(kept)) plain[kept] = view[kept];
      view = std::move(plain);
      break;
    }
  }
  for (const char* name : meshopt_names)
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) erase_name(file_.document, list, name);
  // The buffers are no longer fallbacks.
  for (json& buffer : file_.document["buffers"]) {
    if (!buffer.is_object() || !buffer.contains("extensions") || !buffer["extensions"].is_object()) continue;
    for (const char* name : meshopt_names) buffer["extensions"].erase(name);
    if (buffer["extensions"].empty()) buffer.erase("extensions");
  }
}

void GltfCheck::draco_primitives() {
  const GltfPlace top{&file_.document, ""};
  const std::size_t meshes = objects(top, "meshes").size();
  for (std::size_t m = 0; m < meshes; ++m) {
    const std::string mesh_pointer = "/meshes/" + std::to_string(m);
    const std::size_t primitives = objects({&file_.document["meshes"][m], mesh_pointer}, "primitives").size();
    for (std::size_t p = 0; p < primitives; ++p)
      draco_primitive(m, p, mesh_pointer + "/primitives/" + std::to_string(p));
  }
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    erase_name(file_.document, list, draco_name);
}

void GltfCheck::draco_primitive(std::size_t mesh, std::size_t number, const std::string& pointer) {
  json& primitive = file_.document["meshes"][mesh]["primitives"][number];
  const GltfPlace owner{&primitive, pointer};
  const std::optional<GltfPlace> place = extension(owner, draco_name);
  if (!place) return;
  const std::size_t view = required_index(*place, "bufferView", "bufferViews");
  const GltfPlace attributes = object(owner, "attributes"), ids = object(*place, "attributes");
  if (!attributes.value->contains("POSITION")) fail(attributes.pointer + "/POSITION", "is missing");

  // Accessors are copied, because other primitives may share them.
  const auto accessor_of = [&](const json& value, const std::string& at) {
    const std::size_t accessor = index(value, at, "accessors");
    const json& found = file_.document["accessors"][accessor];
    if (!found.is_object()) fail("/accessors/" + std::to_string(accessor), "must be an object");
    return accessor;
  };
  std::vector<std::string> names;
  std::vector<DracoAttribute> wanted;
  std::vector<json> accessors;
  std::uint64_t vertices = 0;
  for (const auto& [name, id] : ids.value->items()) {
    const json* named = member(attributes, name.c_str());
    if (named == nullptr) fail(ids.pointer + "/" + name, "is not an attribute of the primitive");
    const std::size_t accessor = accessor_of(*named, attributes.pointer + "/" + name);
    const GltfPlace of{&file_.document["accessors"][accessor], "/accessors/" + std::to_string(accessor)};
    const std::uint64_t count = required_whole(of, "count");
    if (!names.empty() && count != vertices)
      fail(of.pointer + "/count",
           std::to_string(count) + " and " + std::to_string(vertices) + " vertices in one compressed mesh");
    vertices = count;
    const std::string type = optional_text(of, "type").value_or("");
    const std::uint64_t components = gltf_components(type);
    if (components == 0 || components > 4) fail(of.pointer + "/type", "cannot be of a compressed mesh");
    const std::uint64_t component = required_whole(of, "componentType");
    if (gltf_component_bytes(component) == 0)
      fail(of.pointer + "/componentType", std::to_string(component) + " is not valid in glTF");
    names.push_back(name);
    wanted.push_back({.id = static_cast<std::uint32_t>(whole(id, ids.pointer + "/" + name, 0xffffffffu)),
                      .component = component,
                      .components = components});
    accessors.push_back(*of.value);
  }
  if (names.empty()) fail(ids.pointer, "must name at least one attribute");
  // The stream may also be compressed with meshopt; its view has been decoded by now.
  const GltfPlace packed{&file_.document["bufferViews"][view], "/bufferViews/" + std::to_string(view)};
  if (!packed.value->is_object()) fail(packed.pointer, "must be an object");
  DracoMesh decoded;
  try {
    decoded = decode_draco(compressed_bytes(packed), vertices, wanted);
  } catch (const CodecError& error) {
    fail(place->pointer, error.what());
  }

  const auto add = [&](std::vector<unsigned char> bytes, json accessor) {
    const std::size_t length = bytes.size();
    json& views = file_.document["bufferViews"];
    views.push_back(
        {{"buffer", add_buffer(pointer, std::move(bytes))}, {"byteOffset", 0u}, {"byteLength", length}});
    accessor["bufferView"] = views.size() - 1;
    accessor["byteOffset"] = 0u;
    accessor.erase("sparse");
    file_.document["accessors"].push_back(std::move(accessor));
    return file_.document["accessors"].size() - 1;
  };
  for (std::size_t k = 0; k < names.size(); ++k) {
    // In plain vertex views, the stride must be a multiple of 4.
    const std::size_t row = static_cast<std::size_t>(wanted[k].components) *
                            static_cast<std::size_t>(gltf_component_bytes(wanted[k].component));
    const std::size_t step = (row + 3) / 4 * 4;
    std::vector<unsigned char> bytes(step * static_cast<std::size_t>(vertices), 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(vertices); ++i)
      std::copy_n(decoded.attributes[k].begin() + static_cast<std::ptrdiff_t>(i * row), row,
                  bytes.begin() + static_cast<std::ptrdiff_t>(i * step));
    primitive["attributes"][names[k]] = add(std::move(bytes), std::move(accessors[k]));
    file_.document["bufferViews"].back()["byteStride"] = step;
  }
  std::vector<unsigned char> corners;
  for (const std::uint32_t corner : decoded.corners)
    for (int shift = 0; shift < 32; shift += 8)
      corners.push_back(static_cast<unsigned char>(corner >> shift));
  if (corners.empty()) fail(place->pointer, "the compressed mesh has no triangles");
  primitive["indices"] = add(
      std::move(corners), {{"componentType", 5125u}, {"type", "SCALAR"}, {"count", decoded.corners.size()}});
  primitive["mode"] = 4u;
  erase_extension(primitive, draco_name);
}

}  // namespace fascicle::gltf
