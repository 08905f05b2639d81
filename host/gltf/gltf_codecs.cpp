#include "host/gltf/gltf_codecs.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>

#include <draco/compression/decode.h>

namespace fascicle::gltf {
namespace {

// Real streams use at least about a byte per vertex; a hostile one could claim enough to exhaust memory.
constexpr std::uint64_t most_draco_elements = std::uint64_t{1} << 22;
constexpr std::uint64_t most_elements_a_byte = 64;
constexpr std::uint64_t small = 4096;  // always allowed, for any stream length

// The counts in the header of a Draco stream.
struct DracoHeader {
  std::uint64_t faces = 0, vertices = 0;
};

DracoHeader draco_header(std::span<const unsigned char> stream) {
  // "DRACO", version, type, method, flags.
  constexpr std::size_t fixed = 11;
  if (stream.size() < fixed || std::memcmp(stream.data(), "DRACO", 5) != 0) throw CodecError(damaged_stream);
  if (stream[5] != 2 || stream[6] != 2)
    throw CodecError("Draco bitstream " + std::to_string(stream[5]) + "." + std::to_string(stream[6]) +
                     "; glTF has 2.2");
  if (stream[7] != draco::TRIANGULAR_MESH) throw CodecError("the Draco stream holds no triangles");
  if ((stream[10] & 0x80) != 0)
    throw CodecError("the Draco stream carries metadata, which is not read; export without it");
  std::size_t at = fixed;
  const auto next = [&]() -> std::uint64_t {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      if (at == stream.size()) throw CodecError(damaged_stream);
      const unsigned char byte = stream[at++];
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if ((byte & 0x80u) == 0) return value;
    }
    throw CodecError(damaged_stream);
  };
  DracoHeader header;
  if (stream[8] == draco::MESH_SEQUENTIAL_ENCODING) {
    header.faces = next();
    header.vertices = next();
  } else {
    if (at++ == stream.size()) throw CodecError(damaged_stream);  // traversal method
    header.vertices = next();
    header.faces = next();
  }
  return header;
}

template <typename T>
bool fill(const draco::PointAttribute& attribute, draco::PointIndex point, std::int8_t components,
          unsigned char* to) {
  std::array<T, 4> values{};
  if (!attribute.ConvertValue<T>(attribute.mapped_index(point), components, values.data())) return false;
  std::memcpy(to, values.data(), sizeof(T) * static_cast<std::size_t>(components));
  return true;
}

// Whether glTF has the type; signed 32 bits are read as well. Draco would read any byte of the file as a
// bool, which is undefined.
bool is_readable(draco::DataType type) {
  return (type >= draco::DT_INT8 && type <= draco::DT_UINT32) || type == draco::DT_FLOAT32;
}

std::size_t component_bytes(std::uint64_t component) {
  return component == 5120 || component == 5121 ? 1 : component == 5122 || component == 5123 ? 2 : 4;
}

bool fill(const draco::PointAttribute& attribute, draco::PointIndex point, const DracoAttribute& wanted,
          unsigned char* to) {
  const auto components = static_cast<std::int8_t>(wanted.components);
  switch (wanted.component) {
    case 5120:
      return fill<std::int8_t>(attribute, point, components, to);
    case 5121:
      return fill<std::uint8_t>(attribute, point, components, to);
    case 5122:
      return fill<std::int16_t>(attribute, point, components, to);
    case 5123:
      return fill<std::uint16_t>(attribute, point, components, to);
    case 5125:
      return fill<std::uint32_t>(attribute, point, components, to);
    default:
      return fill<float>(attribute, point, components, to);
  }
}

}  // namespace

DracoMesh decode_draco(std::span<const unsigned char> stream, std::uint64_t vertices,
                       const std::vector<DracoAttribute>& wanted) {
  const DracoHeader header = draco_header(stream);
  const std::uint64_t most = most_elements_a_byte * stream.size() + small;
  for (const std::uint64_t elements : {header.faces, header.vertices, vertices})
    if (elements > most_draco_elements || elements > most)
      throw CodecError(std::to_string(elements) + " elements are more than are read from " +
                       std::to_string(stream.size()) + " compressed bytes; export without compression");
  DracoMesh result;
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) throw CodecError(damaged_stream);
    const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
    if (mesh->num_points() != vertices)
      throw CodecError("the compressed mesh has " + std::to_string(mesh->num_points()) +
                       " vertices, and its accessor " + std::to_string(vertices));
    for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f)
      for (const draco::PointIndex& point : mesh->face(f)) {
        if (point.value() >= vertices) throw CodecError(damaged_stream);
        result.corners.push_back(point.value());
      }
    for (const DracoAttribute& attribute : wanted) {
      const draco::PointAttribute* source = mesh->GetAttributeByUniqueId(attribute.id);
      if (source == nullptr)
        throw CodecError("the compressed mesh has no attribute " + std::to_string(attribute.id));
      if (!is_readable(source->data_type()))
        throw CodecError("attribute " + std::to_string(attribute.id) +
                         " of the compressed mesh has a type that glTF lacks; export without compression");
      const std::size_t step =
          component_bytes(attribute.component) * static_cast<std::size_t>(attribute.components);
      std::vector<unsigned char> bytes(step * static_cast<std::size_t>(vertices));
      for (draco::PointIndex p(0); p < mesh->num_points(); ++p) {
        if (source->mapped_index(p).value() >= source->size() ||
            !fill(*source, p, attribute, bytes.data() + step * p.value()))
          throw CodecError(damaged_stream);
      }
      result.attributes.push_back(std::move(bytes));
    }
  } catch (const std::bad_alloc&) {
    throw CodecError(damaged_stream);
  } catch (const std::length_error&) {
    throw CodecError(damaged_stream);
  }
  return result;
}

}  // namespace fascicle::gltf
