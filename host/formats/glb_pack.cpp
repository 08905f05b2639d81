#include "host/formats/glb_pack.h"

#include <cstring>
#include <map>
#include <span>

#include "host/gltf/gltf_codecs.h"

namespace fascicle::formats {

using nlohmann::json;

namespace {

constexpr const char* meshopt_extension = "EXT_meshopt_compression";

std::size_t bytes_of_element(const json& accessor) {
  static const std::map<std::string, std::size_t> widths{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                         {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  const int type = accessor.at("componentType");
  const std::size_t component = type >= 5125 ? 4 : type >= 5122 ? 2 : 1;
  return component * widths.at(accessor.at("type").get<std::string>());
}

// How the meshes, skins and animations of a document use its accessors.
struct Uses {
  std::set<std::size_t> all, triangles, other_indices;

  explicit Uses(const json& document) {
    const json none = json::array();
    const auto each = [&](const json& in, const char* key, const auto& use) {
      for (const json& item : in.contains(key) ? in[key] : none) use(item);
    };
    const auto add = [&](const json& in, const char* key) {
      if (in.contains(key)) all.insert(in[key].get<std::size_t>());
    };
    each(document, "meshes", [&](const json& mesh) {
      each(mesh, "primitives", [&](const json& primitive) {
        for (const json& number : primitive["attributes"]) all.insert(number.get<std::size_t>());
        each(primitive, "targets", [&](const json& target) {
          for (const json& number : target) all.insert(number.get<std::size_t>());
        });
        add(primitive, "indices");
        if (primitive.contains("indices"))
          (primitive.value("mode", 4) == 4 ? triangles : other_indices)
              .insert(primitive["indices"].get<std::size_t>());
      });
    });
    each(document, "skins", [&](const json& skin) { add(skin, "inverseBindMatrices"); });
    each(document, "animations", [&](const json& animation) {
      each(animation, "samplers", [&](const json& sampler) {
        add(sampler, "input");
        add(sampler, "output");
      });
    });
  }
};

// The contents of a buffer view.
struct Content {
  std::set<std::size_t> sizes;  // bytes per element
  std::size_t accessors = 0;
  bool has_start = false;  // an accessor begins at offset 0
  bool is_indices = false, is_triangles = true, is_numbers = false;
  bool stays = false;
  bool was_dropped = false;  // held an accessor that was removed
};

std::vector<Content> contents_of(json& document, const std::set<std::size_t>& perhaps_unused) {
  const Uses uses(document);
  std::vector<Content> contents(document["bufferViews"].size());
  json& accessors = document["accessors"];
  for (std::size_t a = 0; a < accessors.size(); ++a) {
    json& accessor = accessors[a];
    if (accessor.contains("sparse"))
      for (const char* part : {"indices", "values"})
        contents[accessor["sparse"][part]["bufferView"].get<std::size_t>()].stays = true;
    if (!accessor.contains("bufferView")) continue;
    Content& content = contents[accessor["bufferView"].get<std::size_t>()];
    if (perhaps_unused.contains(a) && !uses.all.contains(a)) {
      content.was_dropped = true;
      accessor = {{"componentType", 5126}, {"count", 1}, {"type", "SCALAR"}};
      continue;
    }
    content.sizes.insert(bytes_of_element(accessor));
    ++content.accessors;
    content.has_start |= accessor.value("byteOffset", std::size_t{0}) == 0;
    const bool is_triangles = uses.triangles.contains(a), is_other = uses.other_indices.contains(a);
    (is_triangles || is_other ? content.is_indices : content.is_numbers) = true;
    content.is_triangles &= is_triangles && !is_other;
    if (!uses.all.contains(a)) content.stays = true;
  }
  if (document.contains("images"))
    for (const json& image : document["images"])
      if (image.contains("bufferView")) contents[image["bufferView"].get<std::size_t>()].stays = true;
  return contents;
}

std::vector<std::uint32_t> indices_in(std::span<const unsigned char> bytes, std::size_t size) {
  std::vector<std::uint32_t> indices(bytes.size() / size, 0);
  for (std::size_t i = 0; i < indices.size(); ++i)
    for (std::size_t b = 0; b < size; ++b) indices[i] |= std::uint32_t{bytes[i * size + b]} << (8 * b);
  return indices;
}

// Compresses a view's bytes; does not set the result's `offset`. Count 0: leave it uncompressed.
std::pair<PackedView, std::vector<unsigned char>> pack(std::vector<unsigned char> bytes, const json& view,
                                                       const Content& content) {
  PackedView packed;
  if (content.stays || content.accessors == 0 || (content.is_indices && content.is_numbers)) return {};
  const std::size_t size = *content.sizes.begin();
  if (content.is_indices) {
    if (content.sizes.size() != 1 || (size != 2 && size != 4) || bytes.size() < size) return {};
    bytes.resize(bytes.size() / size * size);
    packed.stride = size;
    packed.count = bytes.size() / size;
    const bool triangles =
        content.is_triangles && content.accessors == 1 && content.has_start && packed.count % 3 == 0;
    packed.mode = triangles ? "TRIANGLES" : "INDICES";
    return {packed, gltf::encode_meshopt_indices(indices_in(bytes, size), triangles)};
  }
  packed.stride = view.contains("byteStride") ? view["byteStride"].get<std::size_t>()
                  : content.sizes.size() == 1 ? size
                                              : 4;
  if (packed.stride % 4 != 0 || packed.stride > 256) return {};
  bytes.resize((bytes.size() + packed.stride - 1) / packed.stride * packed.stride, 0);
  packed.count = bytes.size() / packed.stride;
  return {packed, gltf::encode_meshopt(bytes, packed.stride)};
}

void list_once(json& document, const char* list, const char* extension) {
  json& names = document[list];
  if (!names.is_array()) names = json::array();
  for (const json& name : names)
    if (name == extension) return;
  names.push_back(extension);
}

}  // namespace

std::string packed_bytes(const std::vector<unsigned char>& stream) {
  std::string bytes(stream.begin(), stream.end());
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  return bytes;
}

json PackedViews::view(const PackedView& packed, bool has_stride) {
  const std::uint64_t plain = packed.count * packed.stride;
  json view{{"buffer", 1},
            {"byteOffset", plain_bytes_},
            {"byteLength", plain},
            {"extensions",
             {{meshopt_extension,
               {{"buffer", 0},
                {"byteOffset", packed.offset},
                {"byteLength", packed.bytes},
                {"byteStride", packed.stride},
                {"mode", packed.mode},
                {"count", packed.count}}}}}};
  if (has_stride) view["byteStride"] = packed.stride;
  plain_bytes_ += (plain + 3) / 4 * 4;
  return view;
}

void PackedViews::declare(json& document, std::uint64_t binary_bytes) const {
  document["buffers"] = json::array(
      {{{"byteLength", binary_bytes}},
       {{"byteLength", plain_bytes_}, {"extensions", {{meshopt_extension, {{"fallback", true}}}}}}});
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    for (const char* extension : {meshopt_extension, "KHR_mesh_quantization"})
      list_once(document, list, extension);
}

void pack_views(gltf::GltfDocument& document, const std::set<std::size_t>& perhaps_unused,
                PackedViews& views) {
  const std::vector<Content> contents = contents_of(document.json, perhaps_unused);
  std::string binary;
  json& list = document.json["bufferViews"];
  for (std::size_t v = 0; v < list.size(); ++v) {
    json& view = list[v];
    const auto* from = reinterpret_cast<const unsigned char*>(document.binary.data()) +
                       view.value("byteOffset", std::size_t{0});
    const std::size_t length = view["byteLength"];
    const Content& content = contents[v];
    if (content.was_dropped && content.accessors == 0 && !content.stays) {
      // Views are referred to by index, so this one stays, as a view of one byte.
      view = {{"buffer", 0}, {"byteLength", 1}};
      continue;
    }
    auto [packed, stream] = pack({from, from + length}, view, content);
    packed.offset = binary.size();
    if (packed.count > 0) {
      const std::string bytes = packed_bytes(stream);
      packed.bytes = stream.size();
      json compressed = views.view(packed, view.contains("byteStride"));
      for (const auto& [key, value] : view.items())
        if (!compressed.contains(key)) compressed[key] = value;
      view = std::move(compressed);
      binary += bytes;
      continue;
    }
    view["buffer"] = 0;
    view["byteOffset"] = binary.size();
    binary.append(reinterpret_cast<const char*>(from), length);
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
  }
  document.binary = std::move(binary);
}

}  // namespace fascicle::formats
