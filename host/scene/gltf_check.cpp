#include "host/scene/gltf_check.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

namespace fascicle::scene {
namespace {

using nlohmann::json;

constexpr std::uint64_t deepest_node = 1024;
constexpr std::uint64_t most_elements_without_view = std::uint64_t{1} << 24;
constexpr std::uint64_t largest_number = std::uint64_t{1}
                                         << 40;  // of any count or offset: sums of a few do not overflow

// A value of the document and the way to it.
struct Place {
  const json* value;
  std::string pointer;
};

class Check {
 public:
  explicit Check(GltfFile file) : file_(std::move(file)) { checked_.path = file_.path; }

  CheckedGltf run() {
    if (!file_.document.is_object()) fail("/", "must be an object");
    out_ = json::object();
    asset();
    extensions();
    buffers();
    views();
    accessors();
    meshes();
    skins();
    nodes();
    scenes();
    animations();
    checked_.document = std::move(out_);
    return std::move(checked_);
  }

 private:
  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
    gltf_error(file_.path, pointer, what);
  }

  static const json* member(const Place& place, const char* key) {
    const auto found = place.value->find(key);
    return found == place.value->end() ? nullptr : &*found;
  }

  Place object(const Place& parent, const char* key) const {
    const json* value = member(parent, key);
    const std::string pointer = parent.pointer + "/" + key;
    if (value == nullptr) fail(pointer, "is missing");
    if (!value->is_object()) fail(pointer, "must be an object");
    return {value, pointer};
  }

  // The elements of an array; none if it is missing.
  std::vector<Place> elements(const Place& parent, const char* key) const {
    const json* value = member(parent, key);
    const std::string pointer = parent.pointer + "/" + key;
    if (value == nullptr) return {};
    if (!value->is_array()) fail(pointer, "must be an array");
    std::vector<Place> result;
    result.reserve(value->size());
    for (std::size_t i = 0; i < value->size(); ++i)
      result.push_back({&(*value)[i], pointer + "/" + std::to_string(i)});
    return result;
  }

  std::vector<Place> objects(const Place& parent, const char* key) const {
    std::vector<Place> result = elements(parent, key);
    for (const Place& place : result) {
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

  std::optional<std::uint64_t> optional_whole(const Place& parent, const char* key,
                                              std::uint64_t largest = largest_number) const {
    const json* value = member(parent, key);
    if (value == nullptr) return std::nullopt;
    return whole(*value, parent.pointer + "/" + key, largest);
  }

  std::uint64_t required_whole(const Place& parent, const char* key,
                               std::uint64_t largest = largest_number) const {
    const auto value = optional_whole(parent, key, largest);
    if (!value) fail(parent.pointer + "/" + key, "is missing");
    return *value;
  }

  std::size_t index(const json& value, const std::string& pointer, const char* of) const {
    const auto found = file_.document.find(of);
    const std::size_t count = found != file_.document.end() && found->is_array() ? found->size() : 0;
    const std::uint64_t number = whole(value, pointer, largest_number);
    if (number >= count) {
      fail(pointer,
           "names number " + std::to_string(number) + " of /" + of + ", which has " + std::to_string(count));
    }
    return static_cast<std::size_t>(number);
  }

  std::optional<std::size_t> optional_index(const Place& parent, const char* key, const char* of) const {
    const json* value = member(parent, key);
    if (value == nullptr) return std::nullopt;
    return index(*value, parent.pointer + "/" + key, of);
  }

  std::size_t required_index(const Place& parent, const char* key, const char* of) const {
    const auto value = optional_index(parent, key, of);
    if (!value) fail(parent.pointer + "/" + key, "is missing");
    return *value;
  }

  std::optional<std::string> optional_text(const Place& parent, const char* key) const {
    const json* value = member(parent, key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) fail(parent.pointer + "/" + key, "must be a string");
    return value->get<std::string>();
  }

  void asset();
  void extensions();
  void buffers();
  std::uint64_t data_uri_bytes(const std::string& pointer, const std::string& uri, std::size_t start) const;
  void views();
  void accessors();
  json sparse(const Place& accessor, std::uint64_t count, std::uint64_t element) const;
  void fits(const std::string& pointer, std::size_t view, std::uint64_t offset, std::uint64_t stride,
            std::uint64_t size, std::uint64_t count) const;
  void meshes();
  void skins();
  void nodes();
  json node(const Place& place);
  void forest(const std::vector<Place>& places) const;
  void scenes();
  void animations();
  json animation(const Place& place);

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
  std::vector<View> views_;
  std::vector<Accessor> accessors_;
  std::vector<bool> has_matrix_;  // of a node
};

void Check::asset() {
  const Place place = object({&file_.document, ""}, "asset");
  const auto version = optional_text(place, "version");
  if (!version) fail("/asset/version", "is missing");
  if (version->rfind("2.", 0) != 0)
    fail("/asset/version", "`" + version->substr(0, 20) + "`; only glTF 2 is read");
  const auto minimum = optional_text(place, "minVersion");
  if (minimum && *minimum != "2.0")
    fail("/asset/minVersion", "`" + minimum->substr(0, 20) + "`; only glTF 2.0 is read");
  out_["asset"] = {{"version", "2.0"}};
}

// Extensions that change how a surface looks, or no more than the types of numbers that are read here anyway.
void Check::extensions() {
  static constexpr std::array<const char*, 5> harmless{"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                                       "KHR_lights_punctual", "KHR_mesh_quantization"};
  for (const Place& place : elements({&file_.document, ""}, "extensionsRequired")) {
    if (!place.value->is_string()) fail(place.pointer, "must be a string");
    const auto name = place.value->get<std::string>();
    const bool is_harmless = std::any_of(harmless.begin(), harmless.end(),
                                         [&](const char* prefix) { return name.rfind(prefix, 0) == 0; });
    if (!is_harmless) {
      fail(place.pointer,
           "the file needs the extension `" + name.substr(0, 60) + "`, which is not read; export without it");
    }
  }
}

std::uint64_t Check::data_uri_bytes(const std::string& pointer, const std::string& uri,
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

void Check::buffers() {
  std::uint64_t total = 0;
  out_["buffers"] = json::array();
  for (const Place& place : objects({&file_.document, ""}, "buffers")) {
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
        bytes = read_gltf_buffer(file_.path, pointer, *uri, checked_.files_read);
      } else if (buffer_bytes_.empty() && file_.has_binary) {
        bytes = std::move(file_.binary);
      } else {
        fail(pointer, "is missing, and there is no BIN chunk for this buffer");
      }
      have = bytes.size();
      if (have >= length) bytes.resize(static_cast<std::size_t>(length));
      name = "buffer-" + std::to_string(buffer_bytes_.size());
      checked_.buffers[name] = std::move(bytes);
    }
    if (have < length) {
      fail(place.pointer + "/byteLength",
           std::to_string(length) + ", but there are " + std::to_string(have) + " bytes");
    }
    buffer_bytes_.push_back(length);
    out_["buffers"].push_back({{"byteLength", decoded}, {"uri", name}});
  }
}

void Check::views() {
  out_["bufferViews"] = json::array();
  for (const Place& place : objects({&file_.document, ""}, "bufferViews")) {
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

std::uint64_t component_bytes(std::uint64_t component) {
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

std::uint64_t component_count(const std::string& type) {
  static constexpr std::array<std::pair<const char*, std::uint64_t>, 7> types{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
  for (const auto& [name, count] : types) {
    if (type == name) return count;
  }
  return 0;
}

void Check::fits(const std::string& pointer, std::size_t view, std::uint64_t offset, std::uint64_t stride,
                 std::uint64_t size, std::uint64_t count) const {
  // count is bounded so that the product stays far from overflow.
  const std::uint64_t end = offset + (count - 1) * stride + size;
  if (end > views_[view].length) {
    fail(pointer, std::to_string(count) + " elements end at byte " + std::to_string(end) +
                      " of a buffer view of " + std::to_string(views_[view].length));
  }
}

json Check::sparse(const Place& accessor, std::uint64_t count, std::uint64_t element) const {
  const Place place = object(accessor, "sparse");
  const std::uint64_t changed = required_whole(place, "count");
  if (changed == 0 || changed > count) {
    fail(place.pointer + "/count", std::to_string(changed) + " of " + std::to_string(count) + " elements");
  }
  const Place indices = object(place, "indices"), values = object(place, "values");
  const std::uint64_t component = required_whole(indices, "componentType");
  if (component != 5121 && component != 5123 && component != 5125) {
    fail(indices.pointer + "/componentType", std::to_string(component) + "; indices are 5121, 5123 or 5125");
  }
  const std::uint64_t bytes = component_bytes(component);
  json result{{"count", changed}};
  const auto part = [&](const Place& from, std::uint64_t size) {
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

void Check::accessors() {
  out_["accessors"] = json::array();
  for (const Place& place : objects({&file_.document, ""}, "accessors")) {
    const std::uint64_t component = required_whole(place, "componentType");
    const std::uint64_t bytes = component_bytes(component);
    if (bytes == 0)
      fail(place.pointer + "/componentType", std::to_string(component) + " is not one that glTF has");
    const auto type = optional_text(place, "type");
    if (!type) fail(place.pointer + "/type", "is missing");
    const std::uint64_t components = component_count(*type);
    if (components == 0)
      fail(place.pointer + "/type", "`" + type->substr(0, 20) + "` is not one that glTF has");
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
    } else if (count > most_elements_without_view) {
      fail(place.pointer + "/count", std::to_string(count) + " elements without a buffer view; at most " +
                                         std::to_string(most_elements_without_view) + " are read");
    }
    if (member(place, "sparse") != nullptr) accessor["sparse"] = sparse(place, count, size);
    accessors_.push_back({*type, component, count, view.has_value()});
    out_["accessors"].push_back(std::move(accessor));
  }
}

void Check::meshes() {
  out_["meshes"] = json::array();
  for (const Place& place : objects({&file_.document, ""}, "meshes")) {
    json primitives = json::array();
    for (const Place& primitive : objects(place, "primitives")) {
      json result{{"mode", optional_whole(primitive, "mode").value_or(4)}};
      if (result["mode"].get<std::uint64_t>() > 6) fail(primitive.pointer + "/mode", "must be 0 to 6");
      if (const auto indices = optional_index(primitive, "indices", "accessors")) {
        if (!accessors_[*indices].has_view)
          fail(primitive.pointer + "/indices", "its accessor has no buffer view");
        result["indices"] = *indices;
      }
      const Place attributes = object(primitive, "attributes");
      result["attributes"] = json::object();
      for (const auto& [name, value] : attributes.value->items()) {
        const bool is_needed =
            name == "POSITION" || name.rfind("JOINTS_", 0) == 0 || name.rfind("WEIGHTS_", 0) == 0;
        if (is_needed)
          result["attributes"][name] = index(value, attributes.pointer + "/" + name, "accessors");
      }
      primitives.push_back(std::move(result));
    }
    if (primitives.empty()) fail(place.pointer + "/primitives", "must have at least one");
    out_["meshes"].push_back({{"primitives", std::move(primitives)}});
  }
}

void Check::skins() {
  out_["skins"] = json::array();
  for (const Place& place : objects({&file_.document, ""}, "skins")) {
    json joints = json::array();
    std::set<std::size_t> seen;
    for (const Place& joint : elements(place, "joints")) {
      const std::size_t number = index(*joint.value, joint.pointer, "nodes");
      if (!seen.insert(number).second)
        fail(joint.pointer, "names node " + std::to_string(number) + " a second time");
      joints.push_back(number);
    }
    if (joints.empty()) fail(place.pointer + "/joints", "a skin needs at least one joint");
    json skin{{"joints", std::move(joints)}};
    if (const auto matrices = optional_index(place, "inverseBindMatrices", "accessors")) {
      const Accessor& accessor = accessors_[*matrices];
      const std::string pointer = place.pointer + "/inverseBindMatrices";
      if (accessor.type != "MAT4" || accessor.component != 5126)
        fail(pointer, "its accessor must be MAT4 of floats (5126)");
      if (accessor.count < seen.size()) {
        fail(pointer,
             std::to_string(accessor.count) + " matrices for " + std::to_string(seen.size()) + " joints");
      }
      skin["inverseBindMatrices"] = *matrices;
    }
    out_["skins"].push_back(std::move(skin));
  }
}

json Check::node(const Place& place) {
  json result = json::object();
  if (const auto name = optional_text(place, "name")) result["name"] = *name;
  if (const auto mesh = optional_index(place, "mesh", "meshes")) result["mesh"] = *mesh;
  if (const auto skin = optional_index(place, "skin", "skins")) result["skin"] = *skin;
  json children = json::array();
  for (const Place& child : elements(place, "children"))
    children.push_back(index(*child.value, child.pointer, "nodes"));
  if (!children.empty()) result["children"] = std::move(children);
  const auto numbers = [&](const char* key, std::size_t count) {
    if (member(place, key) == nullptr) return false;
    const std::vector<Place> values = elements(place, key);
    if (values.size() != count)
      fail(place.pointer + "/" + key, "must have " + std::to_string(count) + " numbers");
    json array = json::array();
    for (const Place& value : values) {
      if (!value.value->is_number()) fail(value.pointer, "must be a number");
      array.push_back(value.value->get<double>());
    }
    result[key] = std::move(array);
    return true;
  };
  has_matrix_.push_back(numbers("matrix", 16));
  if (has_matrix_.back()) {
    const json& m = result["matrix"];
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
      fail(place.pointer + "/matrix", "its last row must be 0 0 0 1");
    }
    return result;
  }
  numbers("translation", 3);
  numbers("scale", 3);
  if (numbers("rotation", 4)) {
    double square = 0.0;
    for (const json& value : result["rotation"]) square += value.get<double>() * value.get<double>();
    // Written by hand a quaternion may be a little off; far off, it is no rotation.
    if (!(square > 0.25 && square < 4.0))
      fail(place.pointer + "/rotation", "must be a quaternion of length 1");
  }
  return result;
}

// Every node has at most one parent, so what no root leads to lies on a cycle.
void Check::forest(const std::vector<Place>& places) const {
  const json& nodes = out_.at("nodes");
  constexpr std::size_t nothing = ~std::size_t{0};
  std::vector<std::size_t> parent(places.size(), nothing);
  static const json no_children = json::array();
  const auto children = [&](std::size_t i) -> const json& {
    const auto found = nodes[i].find("children");
    return found == nodes[i].end() ? no_children : *found;
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::size_t c = 0;
    for (const json& child : children(i)) {
      const auto number = child.get<std::size_t>();
      if (parent[number] != nothing || number == i) {
        fail(places[i].pointer + "/children/" + std::to_string(c),
             "node " + std::to_string(number) + " is " +
                 (number == i ? "its own child"
                              : "already a child of node " + std::to_string(parent[number])));
      }
      parent[number] = i;
      ++c;
    }
  }
  std::vector<std::uint64_t> depth(places.size(), 0);
  std::vector<std::size_t> stack;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (parent[i] == nothing) {
      depth[i] = 1;
      stack.push_back(i);
    }
  }
  while (!stack.empty()) {
    const std::size_t i = stack.back();
    stack.pop_back();
    if (depth[i] > deepest_node) {
      fail(places[i].pointer, "lies deeper than " + std::to_string(deepest_node) + " nodes");
    }
    for (const json& child : children(i)) {
      depth[child.get<std::size_t>()] = depth[i] + 1;
      stack.push_back(child.get<std::size_t>());
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (depth[i] == 0)
      fail(places[i].pointer + "/children", "node " + std::to_string(i) + " is below itself");
  }
}

void Check::nodes() {
  out_["nodes"] = json::array();
  const std::vector<Place> places = objects({&file_.document, ""}, "nodes");
  for (const Place& place : places) out_["nodes"].push_back(node(place));
  forest(places);
}

void Check::scenes() {
  const Place top{&file_.document, ""};
  out_["scenes"] = json::array();
  for (const Place& place : objects(top, "scenes")) {
    json roots = json::array();
    for (const Place& root : elements(place, "nodes"))
      roots.push_back(index(*root.value, root.pointer, "nodes"));
    out_["scenes"].push_back({{"nodes", std::move(roots)}});
  }
  if (const auto scene = optional_index(top, "scene", "scenes")) out_["scene"] = *scene;
}

json Check::animation(const Place& place) {
  struct Sampler {
    std::size_t input, output;
    bool is_spline;
  };
  std::vector<Sampler> samplers;
  json result{{"samplers", json::array()}, {"channels", json::array()}};
  if (const auto name = optional_text(place, "name")) result["name"] = *name;
  for (const Place& sampler : objects(place, "samplers")) {
    const std::size_t input = required_index(sampler, "input", "accessors");
    const std::size_t output = required_index(sampler, "output", "accessors");
    const std::string interpolation = optional_text(sampler, "interpolation").value_or("LINEAR");
    if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE") {
      fail(sampler.pointer + "/interpolation",
           "`" + interpolation.substr(0, 20) + "`; must be LINEAR, STEP or CUBICSPLINE");
    }
    if (accessors_[input].type != "SCALAR" || accessors_[input].component != 5126) {
      fail(sampler.pointer + "/input", "its accessor must be SCALAR of floats (5126)");
    }
    samplers.push_back({input, output, interpolation == "CUBICSPLINE"});
    result["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
  }
  std::set<std::pair<std::size_t, std::string>> seen;
  for (const Place& channel : objects(place, "channels")) {
    const json* number = member(channel, "sampler");
    if (number == nullptr) fail(channel.pointer + "/sampler", "is missing");
    const std::uint64_t s = whole(*number, channel.pointer + "/sampler", largest_number);
    if (s >= samplers.size()) {
      fail(channel.pointer + "/sampler",
           "names sampler " + std::to_string(s) + " of " + std::to_string(samplers.size()));
    }
    const Place target = object(channel, "target");
    const auto path = optional_text(target, "path");
    if (!path) fail(target.pointer + "/path", "is missing");
    const auto node = optional_index(target, "node", "nodes");
    // Morph weights and what extensions animate move no joint.
    if (!node || *path == "weights" || *path == "pointer") continue;
    if (*path != "translation" && *path != "rotation" && *path != "scale") {
      fail(target.pointer + "/path",
           "`" + path->substr(0, 20) + "`; must be translation, rotation, scale or weights");
    }
    if (has_matrix_[*node]) {
      fail(target.pointer + "/node",
           "node " + std::to_string(*node) + " is given as a matrix and cannot be animated");
    }
    if (!seen.emplace(*node, *path).second) {
      fail(target.pointer, "the " + *path + " of node " + std::to_string(*node) + " is animated twice");
    }
    const Sampler& sampler = samplers[static_cast<std::size_t>(s)];
    const Accessor& output = accessors_[sampler.output];
    const bool is_rotation = *path == "rotation";
    const std::string pointer = place.pointer + "/samplers/" + std::to_string(s) + "/output";
    if (output.type != (is_rotation ? "VEC4" : "VEC3")) {
      fail(pointer, "its accessor must be " + std::string(is_rotation ? "VEC4" : "VEC3") + " for a " + *path);
    }
    const std::uint64_t wanted = accessors_[sampler.input].count * (sampler.is_spline ? 3 : 1);
    if (output.count != wanted) {
      fail(pointer, std::to_string(output.count) + " values where the keys need " + std::to_string(wanted));
    }
    result["channels"].push_back({{"sampler", s}, {"target", {{"node", *node}, {"path", *path}}}});
  }
  return result;
}

void Check::animations() {
  out_["animations"] = json::array();
  for (const Place& place : objects({&file_.document, ""}, "animations"))
    out_["animations"].push_back(animation(place));
}

}  // namespace

CheckedGltf check_gltf(GltfFile file) {
  return Check(std::move(file)).run();
}

}  // namespace fascicle::scene
