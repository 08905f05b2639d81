#include "host/scene/paint_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "host/base/json_text.h"
#include "host/base/nearest_name.h"
#include "host/base/text.h"
#include "host/scene/input_files.h"

namespace fascicle::scene {
namespace {

using nlohmann::json;

constexpr int version = 1;
constexpr const char* version_key = "fascicle_paint";
// Allowed deviation of a direction's length from 1: rounding to single precision, or to a few hand-typed
// digits.
constexpr double length_tolerance = 1e-3;

class Reader {
 public:
  Reader(const std::filesystem::path& file, const mesh::SurfaceMesh& surface)
      : file_(file), surface_(surface) {}

  rig::Paint run(std::string_view text) {
    json document;
    try {
      document = json::parse(base::shallow_json(text));
    } catch (const json::exception&) {
      fail("/", "not valid JSON, or nested too deep, or with too many keys");
    }
    must_have("", document, {version_key, "surface", "vertices", "attributes"});
    if (document[version_key] != version)
      fail(std::string("/") + version_key,
           "is not " + std::to_string(version) + ", the only version supported");
    rig::Paint paint;
    paint.vertices = surface_.vertices.size();
    if (document["vertices"] != paint.vertices)
      fail("/vertices", "is " + shown(document["vertices"]) + ", and the character has " +
                            std::to_string(paint.vertices) + " vertices; " + advice);
    paint.surface = rig::surface_hash(surface_);
    if (document["surface"] != paint.surface)
      fail("/surface", "is " + shown(document["surface"]) + ", and the character's mesh has " +
                           paint.surface + "; " + advice);
    const json& attributes = document["attributes"];
    if (!attributes.is_object()) fail("/attributes", "takes an object");
    for (const auto& [name, values] : attributes.items()) check_name(name);
    for (const rig::PaintKind& kind : rig::paint_kinds()) {
      const auto found = attributes.find(kind.name);
      if (found == attributes.end()) continue;
      rig::PaintedVertices read = read_attribute(kind, *found);
      if (!read.vertex.empty()) paint.attributes.push_back(std::move(read));
    }
    return paint;
  }

 private:
  static constexpr const char* advice =
      "it was painted on another mesh; put that one back, or paint this one anew";

  [[noreturn]] void fail(const std::string& pointer, const std::string& what) const {
    throw InputFileError(file_.string() + ": " + pointer + ": " + what);
  }

  static std::string shown_name(std::string_view text) {
    constexpr std::size_t longest = 40;
    return base::shown_text(text.substr(0, longest));
  }
  static std::string shown(const json& value) {
    return shown_name(value.is_structured() ? std::string(value.type_name())
                                            : value.dump(-1, ' ', false, json::error_handler_t::replace));
  }

  void must_have(const std::string& pointer, const json& object, std::initializer_list<const char*> names) {
    if (!object.is_object()) fail(pointer.empty() ? "/" : pointer, "takes an object");
    for (const char* name : names)
      if (!object.contains(name)) fail(pointer + "/" + name, "is missing");
    for (const auto& [name, value] : object.items())
      if (std::find(names.begin(), names.end(), name) == names.end())
        fail(pointer + "/" + shown_name(name), "is unknown; a paint file has no such member");
  }

  void check_name(const std::string& name) {
    if (rig::find_paint_kind(name) != nullptr) return;
    std::vector<std::string> names;
    for (const rig::PaintKind& kind : rig::paint_kinds()) names.emplace_back(kind.name);
    fail("/attributes/" + shown_name(name), "cannot be painted; _RIGID, _LAYER, _STIFFNESS and _FIBER can" +
                                                base::nearest_name_hint(name, names));
  }

  rig::PaintedVertices read_attribute(const rig::PaintKind& kind, const json& object) {
    const std::string pointer = std::string("/attributes/") + kind.name;
    must_have(pointer, object, {"vertex", "value"});
    const json &vertices = object["vertex"], &values = object["value"];
    if (!vertices.is_array()) fail(pointer + "/vertex", "takes a list of whole numbers");
    if (!values.is_array()) fail(pointer + "/value", "takes a list of numbers");
    if (values.size() != kind.width * vertices.size())
      fail(pointer + "/value",
           "has " + std::to_string(values.size()) + (values.size() == 1 ? " number for " : " numbers for ") +
               std::to_string(vertices.size()) + (vertices.size() == 1 ? " vertex; " : " vertices; ") +
               "must be " + std::to_string(kind.width) + " per vertex");
    rig::PaintedVertices read{kind.name, {}, {}};
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const std::string here = pointer + "/vertex/" + std::to_string(k);
      if (!vertices[k].is_number_unsigned()) fail(here, "takes a whole number");
      const auto vertex = vertices[k].get<std::uint64_t>();
      if (vertex >= surface_.vertices.size())
        fail(here, "is vertex " + std::to_string(vertex) + " of " + std::to_string(surface_.vertices.size()) +
                       ", which are counted from 0");
      if (!read.vertex.empty() && vertex <= read.vertex.back()) fail(here, "is not above the one before it");
      read.vertex.push_back(static_cast<std::uint32_t>(vertex));
    }
    for (std::size_t k = 0; k < values.size(); ++k)
      read.value.push_back(value_of(kind, values[k], pointer + "/value/" + std::to_string(k)));
    if (kind.is_direction) check_directions(read.value, pointer);
    return read;
  }

  float value_of(const rig::PaintKind& kind, const json& number, const std::string& pointer) const {
    if (!number.is_number()) fail(pointer, "takes a number");
    const auto value = number.get<double>();
    if (!(value >= kind.least && value <= kind.most))
      fail(pointer, "is " + shown(number) + "; must be from " + base::number_text(kind.least) + " to " +
                        base::number_text(kind.most));
    if (kind.is_whole && value != std::floor(value))
      fail(pointer, "is " + shown(number) + "; takes a whole number");
    return static_cast<float>(value);
  }

  void check_directions(const std::vector<float>& values, const std::string& pointer) const {
    for (std::size_t k = 0; k + 2 < values.size(); k += 3) {
      const double length =
          Eigen::Vector3d(double{values[k]}, double{values[k + 1]}, double{values[k + 2]}).norm();
      if (length == 0.0 || std::abs(length - 1.0) <= length_tolerance) continue;
      fail(pointer + "/value/" + std::to_string(k),
           "begins a direction of length " + base::short_text(length) + "; must be 1, or 0 for none");
    }
  }

  const std::filesystem::path& file_;
  const mesh::SurfaceMesh& surface_;
};

template <class Number>
void append_list(const std::vector<Number>& numbers, std::string& text) {
  text += '[';
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (k > 0) text += k % 32 == 0 ? ",\n" : ",";
    text += base::number_text(numbers[k]);
  }
  text += ']';
}

}  // namespace

rig::Paint parse_paint(std::string_view text, const std::filesystem::path& file,
                       const mesh::SurfaceMesh& surface) {
  return Reader(file, surface).run(text);
}

// Written by hand, because the library would write a single-precision number with the digits of a double.
std::string paint_text(const rig::Paint& paint) {
  std::string text = "{\"" + std::string(version_key) + "\": " + std::to_string(version) +
                     ",\n\"surface\": \"" + paint.surface +
                     "\",\n\"vertices\": " + std::to_string(paint.vertices) + ",\n\"attributes\": {";
  for (const rig::PaintedVertices& attribute : paint.attributes) {
    text += &attribute == paint.attributes.data() ? "\n\"" : ",\n\"";
    text += attribute.name + "\": {\"vertex\": ";
    append_list(attribute.vertex, text);
    text += ",\n\"value\": ";
    append_list(attribute.value, text);
    text += '}';
  }
  return text + "}}\n";
}

}  // namespace fascicle::scene
