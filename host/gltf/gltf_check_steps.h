// The steps of the check, in four files: gltf_check_data.cpp (buffers, views, accessors),
// gltf_check_compressed.cpp (compressed data), gltf_check.cpp (what is built from them) and
// gltf_check_passed_on.cpp (what only output files need).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_check.h"
#include "host/gltf/gltf_file.h"

namespace fascicle::gltf {

// Limit on any count or offset, so that sums of a few cannot overflow.
inline constexpr std::uint64_t gltf_largest_number = std::uint64_t{1} << 40;

// A value in the document and its JSON pointer.
struct GltfPlace {
  const nlohmann::json* value;
  std::string pointer;
};

// Bytes of a component type, and components of an element type; 0 if glTF has no such type.
std::uint64_t gltf_component_bytes(std::uint64_t component);
std::uint64_t gltf_components(const std::string& type);

class GltfCheck {
 public:
  using json = nlohmann::json;

  explicit GltfCheck(GltfFile file) : file_(std::move(file)) { checked_.path = file_.path; }

  CheckedGltf run() {
    if (!file_.document.is_object()) fail("/", "must be an object");
    out_ = json::object();
    asset();
    extensions();
    buffers();
    meshopt_views();
    draco_primitives();
    views();
    accessors();
    meshes();
    skins();
    nodes();
    scenes();
    animations();
    pass_on();
    checked_.document = std::move(out_);
    checked_.plain = std::move(file_.document);
    return std::move(checked_);
  }

 private:
  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
    gltf_error(file_.path, pointer, what);
  }

  static const json* member(const GltfPlace& place, const char* key) {
    const auto found = place.value->find(key);
    return found == place.value->end() ? nullptr : &*found;
  }

  GltfPlace object(const GltfPlace& parent, const char* key) const {
    const json* value = member(parent, key);
    const std::string pointer = parent.pointer + "/" + key;
    if (value == nullptr) fail(pointer, "is missing");
    if (!value->is_object()) fail(pointer, "must be an object");
    return {value, pointer};
  }

  // The elements of an array; none if it is missing.
  std::vector<GltfPlace> elements(const GltfPlace& parent, const char* key) const {
    const json* value = member(parent, key);
    const std::string pointer = parent.pointer + "/" + key;
    if (value == nullptr) return {};
    if (!value->is_array()) fail(pointer, "must be an array");
    std::vector<GltfPlace> result;
    result.reserve(value->size());
    for (std::size_t i = 0; i < value->size(); ++i)
      result.push_back({&(*value)[i], pointer + "/" + std::to_string(i)});
    return result;
  }

  std::vector<GltfPlace> objects(const GltfPlace& parent, const char* key) const {
    std::vector<GltfPlace> result = elements(parent, key);
    for (const GltfPlace& place : result) {
      if (!place.value->is_object()) fail(place.pointer, "must be an object");
    }
    return result;
  }

  std::uint64_t whole(const json& value, const std::string& pointer, std::uint64_t largest) const {
    if (!value.is_number_unsigned()) fail(pointer, "must be a whole number that is not negative");
    const auto number = value.get<std::uint64_t>();
    if (number > largest) {
      fail(pointer, std::to_string(number) + " is larger than " + std::to_string(largest));
    }
    return number;
  }

  std::optional<std::uint64_t> optional_whole(const GltfPlace& parent, const char* key,
                                              std::uint64_t largest = gltf_largest_number) const {
    const json* value = member(parent, key);
    if (value == nullptr) return std::nullopt;
    return whole(*value, parent.pointer + "/" + key, largest);
  }

  std::uint64_t required_whole(const GltfPlace& parent, const char* key,
                               std::uint64_t largest = gltf_largest_number) const {
    const auto value = optional_whole(parent, key, largest);
    if (!value) fail(parent.pointer + "/" + key, "is missing");
    return *value;
  }

  std::size_t index(const json& value, const std::string& pointer, const char* of) const {
    const auto found = file_.document.find(of);
    const std::size_t count = found != file_.document.end() && found->is_array() ? found->size() : 0;
    const std::uint64_t number = whole(value, pointer, gltf_largest_number);
    if (number >= count) {
      fail(pointer,
           "names number " + std::to_string(number) + " of /" + of + ", which has " + std::to_string(count));
    }
    return static_cast<std::size_t>(number);
  }

  std::optional<std::size_t> optional_index(const GltfPlace& parent, const char* key, const char* of) const {
    const json* value = member(parent, key);
    if (value == nullptr) return std::nullopt;
    return index(*value, parent.pointer + "/" + key, of);
  }

  std::size_t required_index(const GltfPlace& parent, const char* key, const char* of) const {
    const auto value = optional_index(parent, key, of);
    if (!value) fail(parent.pointer + "/" + key, "is missing");
    return *value;
  }

  std::optional<std::string> optional_text(const GltfPlace& parent, const char* key) const {
    const json* value = member(parent, key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) fail(parent.pointer + "/" + key, "must be a string");
    return value->get<std::string>();
  }

  void asset();
  void extensions();
  void buffers();
  std::uint64_t data_uri_bytes(const std::string& pointer, const std::string& uri, std::size_t start) const;
  std::optional<GltfPlace> extension(const GltfPlace& owner, const char* name) const;
  bool is_fallback(const GltfPlace& buffer) const;
  std::span<const unsigned char> compressed_bytes(const GltfPlace& place);
  std::size_t add_buffer(const std::string& pointer, std::vector<unsigned char> bytes);
  void meshopt_views();
  void draco_primitives();
  void draco_primitive(std::size_t mesh, std::size_t number, const std::string& pointer);
  void views();
  void accessors();
  json sparse(const GltfPlace& accessor, std::uint64_t count, std::uint64_t element) const;
  void fits(const std::string& pointer, std::size_t view, std::uint64_t offset, std::uint64_t stride,
            std::uint64_t size, std::uint64_t count) const;
  void meshes();
  json morph_targets(const GltfPlace& primitive, const GltfPlace& attributes) const;
  void morph_weights(const GltfPlace& owner, std::size_t targets) const;
  std::size_t shapes_of(std::size_t node) const;
  void skins();
  void nodes();
  json node(const GltfPlace& place);
  void forest(const std::vector<GltfPlace>& places) const;
  void scenes();
  void animations();
  json animation(const GltfPlace& place);
  void pass_on();

  struct View {
    std::uint64_t length, stride;
  };
  struct Accessor {
    std::string type;
    std::uint64_t component, count;
    bool has_view;
  };

  GltfFile file_;
  CheckedGltf checked_;
  json out_;
  std::vector<std::uint64_t> buffer_bytes_;
  std::map<std::size_t, std::vector<unsigned char>> data_uris_;  // by buffer index, decoded
  std::uint64_t decoded_bytes_ = 0;
  std::vector<View> views_;
  std::vector<Accessor> accessors_;
  std::vector<std::size_t> targets_;  // per mesh: number of morph targets of its primitives
  std::vector<bool> has_matrix_;      // per node
};

}  // namespace fascicle::gltf
