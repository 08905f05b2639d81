#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <utility>

#include "host/gltf/gltf_check_steps.h"

namespace fascicle::gltf {
namespace {

using nlohmann::json;

// Limits on accessors without a buffer view: elements in any file, and numbers, of which a large file may
// have more, because the weights of a baked animation grow with the square of its frames.
constexpr std::uint64_t most_elements_without_view = std::uint64_t{1} << 24;
constexpr std::uint64_t most_numbers_without_view = std::uint64_t{1} << 28, numbers_a_byte = 16;

// Of files that several buffers name: a small file could be read without end.
constexpr std::uint64_t most_repeated_bytes = std::uint64_t{16} << 20;

}  // namespace

std::uint64_t gltf_component_bytes(std::uint64_t component) {
  switch (component) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

std::uint64_t gltf_components(const std::string& type) {
  static constexpr std::array<std::pair<const char*, std::uint64_t>, 7> types{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
  for (const auto& [name, count] : types) {
    if (type == name) return count;
  }
  return 0;
}

std::uint64_t GltfCheck::data_uri_bytes(const std::string& pointer, const std::string& uri,
                                        std::size_t start) const {
  const std::size_t length = uri.size() - start;
  if (length % 4 != 0) fail(pointer, "base64 text must come in groups of four characters");
  std::size_t padding = 0;
  while (padding < 2 && padding < length && uri[uri.size() - 1 - padding] == '=') ++padding;
  for (std::size_t i = start; i < uri.size() - padding; ++i) {
    const char c = uri[i];
    const bool is_base64 =
        (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '+' || c == '/';
    if (!is_base64) fail(pointer, "character " + std::to_string(i) + " is not base64");
  }
  return length / 4 * 3 - padding;
}

void GltfCheck::buffers() {
  std::uint64_t total = 0, repeated = 0, read = 0;
  std::set<std::filesystem::path> files;
  out_["buffers"] = json::array();
  for (const GltfPlace& place : objects({&file_.document, ""}, "buffers")) {
    const std::uint64_t length = required_whole(place, "byteLength", gltf_largest_file);
    if (length == 0) fail(place.pointer + "/byteLength", "must be at least 1");
    total += length;
    if (total > gltf_largest_file) {
      fail(place.pointer + "/byteLength",
           "the buffers together have more than " + std::to_string(gltf_largest_file) + " bytes");
    }
    const std::string pointer = place.pointer + "/uri";
    const auto uri = optional_text(place, "uri");
    std::uint64_t have = 0, decoded = length;
    std::string name;
    bool is_repeated = false;
    if (uri && uri->rfind("data:", 0) == 0) {
      static constexpr std::array<const char*, 2> headers{"data:application/octet-stream;base64,",
                                                          "data:application/gltf-buffer;base64,"};
      std::size_t start = 0;
      for (const std::string header : headers) {
        if (uri->rfind(header, 0) == 0) start = header.size();
      }
      if (start == 0)
        fail(pointer, "must begin with `" + std::string(headers[0]) + "` or `" + headers[1] + "`");
      have = decoded = data_uri_bytes(pointer, *uri, start);
      name = *uri;
    } else {
      std::vector<unsigned char> bytes;
      if (uri) {
        is_repeated = !files.insert(gltf_buffer_file(file_.path, pointer, *uri)).second;
        bytes = read_gltf_buffer(file_.path, pointer, *uri, checked_.files_read);
      } else if (buffer_bytes_.empty() && file_.has_binary) {
        bytes = std::move(file_.binary);
      } else if (is_fallback(place)) {
        // The compressed data of its views is elsewhere; one byte stands in for this buffer.
        buffer_bytes_.push_back(1);
        total -= length;
        file_.document["buffers"][buffer_bytes_.size() - 1]["byteLength"] = 1;
        name = "buffer-" + std::to_string(buffer_bytes_.size() - 1);
        checked_.buffers[name] = {0};
        out_["buffers"].push_back({{"byteLength", 1}, {"uri", name}});
        continue;
      } else {
        fail(pointer, "is missing, and there is no BIN chunk for this buffer");
      }
      have = bytes.size();
      read += have;
      if (read > gltf_largest_file)
        fail(pointer, "the files of the buffers together have more than " +
                          std::to_string(gltf_largest_file) + " bytes");
      if (have >= length) bytes.resize(static_cast<std::size_t>(length));
      name = "buffer-" + std::to_string(buffer_bytes_.size());
      checked_.buffers[name] = std::move(bytes);
    }
    if (have < length) {
      fail(place.pointer + "/byteLength",
           std::to_string(length) + ", but there are " + std::to_string(have) + " bytes");
    }
    repeated += is_repeated ? have : 0;
    if (repeated > most_repeated_bytes)
      fail(pointer, "names the file of an earlier buffer, as others do; together they read more than " +
                        std::to_string(most_repeated_bytes) + " bytes again; use one buffer for a file");
    buffer_bytes_.push_back(length);
    out_["buffers"].push_back({{"byteLength", decoded}, {"uri", name}});
    if (is_repeated) out_["buffers"].back()["name"] = repeated_buffer;
  }
}

void GltfCheck::views() {
  out_["bufferViews"] = json::array();
  for (const GltfPlace& place : objects({&file_.document, ""}, "bufferViews")) {
    const std::size_t buffer = required_index(place, "buffer", "buffers");
    const std::uint64_t offset = optional_whole(place, "byteOffset").value_or(0);
    const std::uint64_t length = required_whole(place, "byteLength");
    const std::uint64_t stride = optional_whole(place, "byteStride").value_or(0);
    if (length == 0) fail(place.pointer + "/byteLength", "must be at least 1");
    if (offset + length > buffer_bytes_[buffer]) {
      fail(place.pointer + "/byteLength", "bytes " + std::to_string(offset) + " to " +
                                              std::to_string(offset + length) + " of a buffer of " +
                                              std::to_string(buffer_bytes_[buffer]));
    }
    if (stride > 252 || stride % 4 != 0) {
      fail(place.pointer + "/byteStride", std::to_string(stride) + "; must be a multiple of 4 up to 252");
    }
    views_.push_back({length, stride});
    json view{{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", length}};
    if (stride != 0) view["byteStride"] = stride;
    out_["bufferViews"].push_back(std::move(view));
  }
}

void GltfCheck::fits(const std::string& pointer, std::size_t view, std::uint64_t offset, std::uint64_t stride,
                     std::uint64_t size, std::uint64_t count) const {
  // `count` is bounded, so the product cannot overflow.
  const std::uint64_t end = offset + (count - 1) * stride + size;
  if (end > views_[view].length) {
    fail(pointer, std::to_string(count) + " elements end at byte " + std::to_string(end) +
                      " of a buffer view of " + std::to_string(views_[view].length));
  }
}

json GltfCheck::sparse(const GltfPlace& accessor, std::uint64_t count, std::uint64_t element) const {
  const GltfPlace place = object(accessor, "sparse");
  const std::uint64_t changed = required_whole(place, "count");
  if (changed == 0 || changed > count) {
    fail(place.pointer + "/count", std::to_string(changed) + " of " + std::to_string(count) + " elements");
  }
  const GltfPlace indices = object(place, "indices"), values = object(place, "values");
  const std::uint64_t component = required_whole(indices, "componentType");
  if (component != 5121 && component != 5123 && component != 5125) {
    fail(indices.pointer + "/componentType", std::to_string(component) + "; indices are 5121, 5123 or 5125");
  }
  const std::uint64_t bytes = gltf_component_bytes(component);
  json result{{"count", changed}};
  const auto part = [&](const GltfPlace& from, std::uint64_t size) {
    const std::size_t view = required_index(from, "bufferView", "bufferViews");
    const std::uint64_t offset = optional_whole(from, "byteOffset").value_or(0);
    fits(from.pointer, view, offset, size, size, changed);
    return json{{"bufferView", view}, {"byteOffset", offset}};
  };
  result["indices"] = part(indices, bytes);
  result["indices"]["componentType"] = component;
  result["values"] = part(values, element);
  return result;
}

void GltfCheck::accessors() {
  out_["accessors"] = json::array();
  std::uint64_t file_bytes = 0;
  for (const auto& [name, bytes] : checked_.buffers) file_bytes += bytes.size();
  const std::uint64_t numbers = std::min(most_numbers_without_view, numbers_a_byte * file_bytes);
  for (const GltfPlace& place : objects({&file_.document, ""}, "accessors")) {
    const std::uint64_t component = required_whole(place, "componentType");
    const std::uint64_t bytes = gltf_component_bytes(component);
    if (bytes == 0)
      fail(place.pointer + "/componentType", std::to_string(component) + " is not valid in glTF");
    const auto type = optional_text(place, "type");
    if (!type) fail(place.pointer + "/type", "is missing");
    const std::uint64_t components = gltf_components(*type);
    if (components == 0) fail(place.pointer + "/type", "`" + type->substr(0, 20) + "` is not valid in glTF");
    const std::uint64_t size = bytes * components;
    const std::uint64_t count = required_whole(place, "count");
    if (count == 0) fail(place.pointer + "/count", "must be at least 1");
    const std::uint64_t offset = optional_whole(place, "byteOffset").value_or(0);
    const json* normalized = member(place, "normalized");
    if (normalized != nullptr && !normalized->is_boolean())
      fail(place.pointer + "/normalized", "must be true or false");

    json accessor{{"componentType", component}, {"type", *type}, {"count", count}};
    if (normalized != nullptr) accessor["normalized"] = *normalized;
    const auto view = optional_index(place, "bufferView", "bufferViews");
    if (view) {
      const std::uint64_t stride = views_[*view].stride == 0 ? size : views_[*view].stride;
      if (stride < size) {
        fail(place.pointer + "/bufferView", "its byteStride of " + std::to_string(stride) +
                                                " is less than the " + std::to_string(size) +
                                                " bytes of an element");
      }
      if (count > gltf_largest_file)
        fail(place.pointer + "/count", std::to_string(count) + " elements are more than fit");
      fits(place.pointer + "/count", *view, offset, stride, size, count);
      accessor["bufferView"] = *view;
      accessor["byteOffset"] = offset;
    } else {
      const std::uint64_t most = std::max(most_elements_without_view, numbers / components);
      if (count > most) {
        fail(place.pointer + "/count", std::to_string(count) + " elements without a buffer view; at most " +
                                           std::to_string(most) + " are read from a file of this size");
      }
    }
    if (member(place, "sparse") != nullptr) accessor["sparse"] = sparse(place, count, size);
    accessors_.push_back({*type, component, count, view.has_value()});
    out_["accessors"].push_back(std::move(accessor));
  }
}

}  // namespace fascicle::gltf
