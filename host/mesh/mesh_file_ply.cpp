// PLY: ASCII, binary little endian, binary big endian.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/errors.h"
#include "host/mesh/mesh_readers.h"
#include "host/mesh/surface_builder.h"
#include "host/mesh/text_scanner.h"

namespace fascicle::mesh {
namespace {

enum class Encoding { ascii, little_endian, big_endian };
enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Scalar type = Scalar::float32;
  std::optional<Scalar> count_type;  // only lists have one
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t size = 0;  // bytes before the first value
};

std::size_t size_of(Scalar type) {
  switch (type) {
    case Scalar::int8:
    case Scalar::uint8:
      return 1;
    case Scalar::int16:
    case Scalar::uint16:
      return 2;
    case Scalar::int32:
    case Scalar::uint32:
    case Scalar::float32:
      return 4;
    case Scalar::float64:
      return 8;
  }
  return 8;
}

Scalar scalar_named(std::string_view name, const TextScanner& scanner) {
  struct Name {
    std::string_view name;
    Scalar type;
  };
  static constexpr std::array<Name, 16> names = {{{"char", Scalar::int8},
                                                  {"int8", Scalar::int8},
                                                  {"uchar", Scalar::uint8},
                                                  {"uint8", Scalar::uint8},
                                                  {"short", Scalar::int16},
                                                  {"int16", Scalar::int16},
                                                  {"ushort", Scalar::uint16},
                                                  {"uint16", Scalar::uint16},
                                                  {"int", Scalar::int32},
                                                  {"int32", Scalar::int32},
                                                  {"uint", Scalar::uint32},
                                                  {"uint32", Scalar::uint32},
                                                  {"float", Scalar::float32},
                                                  {"float32", Scalar::float32},
                                                  {"double", Scalar::float64},
                                                  {"float64", Scalar::float64}}};
  const auto* found = std::find_if(names.begin(), names.end(), [&](const Name& n) { return n.name == name; });
  if (found == names.end()) scanner.fail(shown(name) + " is not a PLY type; correct the header");
  return found->type;
}

Property read_property(TextScanner& scanner) {
  Property property;
  std::string_view word = scanner.word("a property's type");
  if (word == "list") {
    property.count_type = scalar_named(scanner.word("the type of a list's length"), scanner);
    if (*property.count_type == Scalar::float32 || *property.count_type == Scalar::float64) {
      scanner.fail("a list's length cannot be a float; correct the header");
    }
    word = scanner.word("a list's type");
  }
  property.type = scalar_named(word, scanner);
  property.name = scanner.word("a property's name");
  return property;
}

Header read_header(const std::string& file, std::string_view bytes) {
  constexpr std::string_view last = "\nend_header";
  const std::size_t end = bytes.find(last);
  if (bytes.substr(0, 3) != "ply" || end == std::string_view::npos) {
    throw base::SceneError(
        file +
        ":1: not a PLY file: it needs \"ply\" in the first line and a line \"end_header\"; "
        "export it again");
  }
  Header header;
  header.size = end + last.size();
  if (bytes.substr(header.size, 2) == "\r\n") {
    header.size += 2;
  } else if (bytes.substr(header.size, 1) == "\n") {
    header.size += 1;
  }
  TextScanner scanner(file, bytes.substr(0, end), '\0');
  bool has_format = false;
  if (scanner.word("ply") != "ply") scanner.fail("not a PLY file; export it again");
  while (!scanner.at_end()) {
    const std::string_view keyword = scanner.word("a keyword");
    if (keyword == "comment" || keyword == "obj_info") {
      scanner.skip_line();
    } else if (keyword == "format") {
      const std::string_view encoding = scanner.word("the encoding");
      if (encoding == "ascii") {
        header.encoding = Encoding::ascii;
      } else if (encoding == "binary_little_endian") {
        header.encoding = Encoding::little_endian;
      } else if (encoding == "binary_big_endian") {
        header.encoding = Encoding::big_endian;
      } else {
        scanner.fail("encoding " + shown(encoding) + " is not a PLY encoding; correct the header");
      }
      scanner.word("the format's version");
      has_format = true;
    } else if (keyword == "element") {
      Element element;
      element.name = scanner.word("an element's name");
      element.count = scanner.whole("the number of elements");
      header.elements.push_back(element);
    } else if (keyword == "property") {
      if (header.elements.empty()) scanner.fail("a property before any element; correct the header");
      header.elements.back().properties.push_back(read_property(scanner));
    } else {
      scanner.fail("keyword " + shown(keyword) + " is unknown; correct the header");
    }
  }
  if (!has_format) scanner.fail("the header has no format line; correct it");
  return header;
}

// Reads consecutive values from text or from bytes. fail() reports the position of the last value.
class TextValues {
 public:
  TextValues(const std::string& file, std::string_view bytes, std::size_t header_size)
      : scanner_(file, bytes, '\0') {
    scanner_.skip_if(bytes.substr(0, header_size));
  }
  double value(Scalar) { return scanner_.number("a value"); }
  void skip(Scalar) { scanner_.word("a value"); }
  std::uint64_t length(Scalar) { return scanner_.whole("a list's length"); }
  static std::size_t smallest(Scalar) { return 2; }  // a digit and a space
  bool at_end() { return scanner_.at_end(); }
  std::size_t remaining() const { return scanner_.remaining() + 1; }  // as if a space followed the last value
  [[noreturn]] void fail(const std::string& what) const { scanner_.fail(what); }

 private:
  TextScanner scanner_;
};

class BinaryValues {
 public:
  BinaryValues(const std::string& file, std::string_view bytes, const Header& header)
      : file_(file), bytes_(bytes), at_(header.size), is_big_(header.encoding == Encoding::big_endian) {}

  double value(Scalar type) {
    const std::uint64_t word = take(type);
    switch (type) {
      case Scalar::int8:
        return static_cast<std::int8_t>(word);
      case Scalar::int16:
        return static_cast<std::int16_t>(word);
      case Scalar::int32:
        return static_cast<std::int32_t>(word);
      case Scalar::uint8:
      case Scalar::uint16:
      case Scalar::uint32:
        return static_cast<double>(word);
      case Scalar::float32:
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(word)));
      case Scalar::float64:
        return std::bit_cast<double>(word);
    }
    return 0.0;
  }
  void skip(Scalar type) { take(type); }
  std::uint64_t length(Scalar type) {
    const double count = value(type);
    if (count < 0.0) fail("a list's length is negative; export the mesh again");
    return static_cast<std::uint64_t>(count);
  }
  static std::size_t smallest(Scalar type) { return size_of(type); }
  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t remaining() const { return bytes_.size() - at_; }
  [[noreturn]] void fail(const std::string& what) const {
    throw base::SceneError(file_ + ": byte " + std::to_string(last_) + ": " + what);
  }

 private:
  std::uint64_t take(Scalar type) {
    const std::size_t size = size_of(type);
    last_ = at_;
    if (size > remaining()) fail("the file ends inside the data; it is cut short, export it again");
    std::uint64_t word = 0;
    for (std::size_t k = 0; k < size; ++k) {
      const std::uint64_t byte = static_cast<unsigned char>(bytes_[at_ + k]);
      word |= byte << (8 * (is_big_ ? size - 1 - k : k));
    }
    at_ += size;
    return word;
  }

  std::string file_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::size_t last_ = 0;
  bool is_big_ = false;
};

template <typename Values>
void read_vertex(Values& values, const Element& element, SurfaceMesh& mesh) {
  Vector3d point = Vector3d::Zero();
  for (const Property& property : element.properties) {
    const bool is_coordinate = !property.count_type && property.name.size() == 1 && property.name[0] >= 'x' &&
                               property.name[0] <= 'z';
    if (is_coordinate) {
      const double value = values.value(property.type);
      if (!std::isfinite(value))
        values.fail("a coordinate is not finite; repair the mesh and export it again");
      point[property.name[0] - 'x'] = value;
    } else if (property.count_type) {
      skip_list(values, property);
    } else {
      values.skip(property.type);
    }
  }
  mesh.vertices.push_back(point);
}

template <typename Values>
std::uint64_t list_length(Values& values, const Property& property) {
  const std::uint64_t length = values.length(*property.count_type);
  if (length > values.remaining() / values.smallest(property.type)) {
    values.fail("a list of " + std::to_string(length) + " values is longer than the rest of the file (" +
                std::to_string(values.remaining()) + " bytes); the file is damaged, export it again");
  }
  return length;
}

template <typename Values>
void skip_list(Values& values, const Property& property) {
  const std::uint64_t length = list_length(values, property);
  for (std::uint64_t k = 0; k < length; ++k) values.skip(property.type);
}

bool is_face_list(const Property& property) {
  return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <typename Values>
void read_face(Values& values, const Element& element, SurfaceMesh& mesh,
               std::vector<std::uint32_t>& polygon) {
  for (const Property& property : element.properties) {
    if (is_face_list(property)) {
      polygon.resize(list_length(values, property));
      for (std::uint32_t& v : polygon) {
        const double value = values.value(property.type);
        // Written so that NaN fails too.
        if (!(value >= 0.0 && value < static_cast<double>(mesh.vertices.size())) ||
            value != std::floor(value)) {
          values.fail("a face names a vertex that is not one of the " + std::to_string(mesh.vertices.size()) +
                      ", counted from 0; repair the mesh and export it again");
        }
        v = static_cast<std::uint32_t>(value);
      }
      append_polygon(mesh, polygon, 0, [&](const std::string& what) { values.fail(what); });
    } else if (property.count_type) {
      skip_list(values, property);
    } else {
      values.skip(property.type);
    }
  }
}

template <typename Values>
void check_element(Values& values, const Element& element) {
  std::size_t smallest = 0;
  for (const Property& property : element.properties) {
    smallest += values.smallest(property.count_type.value_or(property.type));
  }
  if (element.count > 0 && smallest == 0) {
    values.fail("element " + shown(element.name) + " has no properties; correct the header");
  }
  if (smallest > 0 && element.count > values.remaining() / smallest) {
    values.fail("element " + shown(element.name) + " has " + std::to_string(element.count) +
                " entries, more than the rest of the file (" + std::to_string(values.remaining()) +
                " bytes) can hold; the count is wrong or the file is cut short");
  }
}

template <typename Values>
SurfaceMesh read_elements(Values values, const Header& header) {
  SurfaceMesh mesh;
  std::vector<std::uint32_t> polygon;
  for (const Element& element : header.elements) {
    check_element(values, element);
    const auto has = [&](std::string_view name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.name == name && !p.count_type; });
    };
    if (element.name == "vertex") {
      if (!mesh.vertices.empty()) values.fail("a second element vertex; join the two");
      if (!has("x") || !has("y") || !has("z"))
        values.fail("element vertex lacks x, y or z; correct the header");
      mesh.vertices.reserve(element.count);
      for (std::uint64_t i = 0; i < element.count; ++i) read_vertex(values, element, mesh);
    } else if (element.name == "face") {
      if (std::none_of(element.properties.begin(), element.properties.end(), is_face_list)) {
        values.fail("element face lacks the list vertex_indices; correct the header");
      }
      for (std::uint64_t i = 0; i < element.count; ++i) read_face(values, element, mesh, polygon);
    } else {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        for (const Property& property : element.properties) {
          if (property.count_type) {
            skip_list(values, property);
          } else {
            values.skip(property.type);
          }
        }
      }
    }
  }
  if (!values.at_end()) values.fail("extra data after the last element; correct the counts in the header");
  if (mesh.triangles.empty()) values.fail("no faces in this file; export a surface");
  return mesh;
}

}  // namespace

SurfaceMesh read_ply(const std::string& file, std::string_view bytes) {
  const Header header = read_header(file, bytes);
  if (header.encoding == Encoding::ascii) return read_elements(TextValues(file, bytes, header.size), header);
  return read_elements(BinaryValues(file, bytes, header), header);
}

}  // namespace fascicle::mesh
