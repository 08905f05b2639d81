#include "host/formats/gltf_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"

namespace fascicle::formats {

using nlohmann::json;

namespace {

constexpr int unsigned_short = 5123, unsigned_int = 5125, floats = 5126;  // componentType

const char* type_of(std::size_t width) {
  return width == 1 ? "SCALAR" : width == 3 ? "VEC3" : width == 4 ? "VEC4" : "MAT4";
}

template <class T>
std::size_t add(gltf::GltfDocument& document, std::span<const T> values, std::size_t width, int type) {
  const std::size_t view =
      add_view(document, {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  json& accessors = document.json["accessors"];
  accessors.push_back({{"bufferView", view},
                       {"componentType", type},
                       {"count", values.size() / width},
                       {"type", type_of(width)}});
  return accessors.size() - 1;
}

}  // namespace

std::size_t add_view(gltf::GltfDocument& document, std::string_view bytes) {
  std::string& binary = document.binary;
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  json& views = document.json["bufferViews"];
  views.push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
  binary += bytes;
  return views.size() - 1;
}

std::size_t add_accessor(gltf::GltfDocument& document, std::span<const float> values, std::size_t width,
                         bool with_bounds) {
  const std::size_t number = add(document, values, width, floats);
  if (!with_bounds) return number;
  std::vector<float> least(width, std::numeric_limits<float>::max()), greatest(width, -least[0]);
  for (std::size_t i = 0; i < values.size(); ++i) {
    least[i % width] = std::min(least[i % width], values[i]);
    greatest[i % width] = std::max(greatest[i % width], values[i]);
  }
  document.json["accessors"][number]["min"] = least;
  document.json["accessors"][number]["max"] = greatest;
  return number;
}

std::size_t add_accessor(gltf::GltfDocument& document, std::span<const std::uint16_t> values,
                         std::size_t width) {
  return add(document, values, width, unsigned_short);
}

std::size_t add_accessor(gltf::GltfDocument& document, std::span<const std::uint32_t> indices) {
  return add(document, indices, 1, unsigned_int);
}

std::size_t add_still_accessor(json& document, std::size_t count) {
  json& accessors = document["accessors"];
  accessors.push_back(
      {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}, {"min", {0, 0, 0}}, {"max", {0, 0, 0}}});
  return accessors.size() - 1;
}

std::string glb_head(std::string text, std::uint64_t binary_bytes) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::uint64_t total = 12 + 8 + text.size() + 8 + binary_bytes;
  if (total > std::numeric_limits<std::uint32_t>::max())
    throw base::BakeError("glb: " + base::number_text(total) +
                          " bytes are more than a .glb holds (4 GiB); give a larger --glb-stride");
  std::string head = "glTF";
  base::append_bytes(head, std::uint32_t{2});
  base::append_bytes(head, static_cast<std::uint32_t>(total));
  base::append_bytes(head, static_cast<std::uint32_t>(text.size()));
  head += "JSON" + text;
  base::append_bytes(head, static_cast<std::uint32_t>(binary_bytes));
  return head + std::string("BIN\0", 4);
}

void require_finite(const json& value) {
  if (value.is_number_float() && !std::isfinite(value.get<double>()))
    throw base::BakeError(
        "glb: a number of the character is not finite; its sizes or places are absurdly large");
  if (value.is_structured())
    for (const json& part : value) require_finite(part);
}

std::string glb_text(gltf::GltfDocument document) {
  require_finite(document.json);
  document.binary.resize((document.binary.size() + 3) / 4 * 4, '\0');
  document.json["buffers"] = json::array({{{"byteLength", document.binary.size()}}});
  return glb_head(document.json.dump(-1, ' ', false, json::error_handler_t::replace),
                  document.binary.size()) +
         document.binary;
}

}  // namespace fascicle::formats
