#include "host/scene/gltf_codecs.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>

#include <draco/compression/decode.h>
#include <meshoptimizer.h>

namespace fascicle::scene {
namespace {

// Honest streams shrink a vertex to a byte or more; a hostile one could ask for the machine's memory.
constexpr std::uint64_t most_meshopt_bytes = std::uint64_t{1} << 30;
constexpr std::uint64_t most_bytes_a_byte = 4096;
constexpr std::uint64_t most_draco_elements = std::uint64_t{1} << 22;
constexpr std::uint64_t most_elements_a_byte = 64;
constexpr std::uint64_t small = 4096;  // elements that any stream may hold

constexpr const char* damaged = "the compressed stream is damaged; export again, or without compression";

// What stands at the front of a Draco stream.
struct DracoHeader {
  std::uint64_t faces = 0, vertices = 0;
};

DracoHeader draco_header(std::span<const unsigned char> stream) {
  // "DRACO", version, type, method, flags.
  constexpr std::size_t fixed = 11;
  if (stream.size() < fixed || std::memcmp(stream.data(), "DRACO", 5) != 0) throw CodecError(damaged);
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
      if (at == stream.size()) throw CodecError(damaged);
      const unsigned char byte = stream[at++];
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if ((byte & 0x80u) == 0) return value;
    }
    throw CodecError(damaged);
  };
  DracoHeader header;
  if (stream[8] == draco::MESH_SEQUENTIAL_ENCODING) {
    header.faces = next();
    header.vertices = next();
  } else {
    if (at++ == stream.size()) throw CodecError(damaged);  // how it is traversed
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

std::vector<unsigned char> decode_meshopt(std::span<const unsigned char> stream, std::uint64_t count,
                                          std::uint64_t stride, const std::string& mode,
                                          const std::string& filter) {
  const bool is_attributes = mode == "ATTRIBUTES";
  if (!is_attributes && mode != "TRIANGLES" && mode != "INDICES")
    throw CodecError("mode `" + mode.substr(0, 20) + "` is not ATTRIBUTES, TRIANGLES or INDICES");
  if (is_attributes ? stride == 0 || stride % 4 != 0 || stride > 256 : stride != 2 && stride != 4)
    throw CodecError("a stride of " + std::to_string(stride) + " bytes is not allowed for " + mode);
  if (mode == "TRIANGLES" && count % 3 != 0)
    throw CodecError(std::to_string(count) + " indices do not make whole triangles");
  if (count == 0 || count > most_meshopt_bytes / stride ||
      count * stride > most_bytes_a_byte * (stream.size() + 16))
    throw CodecError(std::to_string(count) + " elements cannot lie in " + std::to_string(stream.size()) +
                     " compressed bytes");
  const auto elements = static_cast<std::size_t>(count), size = static_cast<std::size_t>(stride);
  std::vector<unsigned char> bytes(elements * size);
  const int result =
      is_attributes ? meshopt_decodeVertexBuffer(bytes.data(), elements, size, stream.data(), stream.size())
      : mode == "TRIANGLES"
          ? meshopt_decodeIndexBuffer(bytes.data(), elements, size, stream.data(), stream.size())
          : meshopt_decodeIndexSequence(bytes.data(), elements, size, stream.data(), stream.size());
  if (result != 0) throw CodecError(damaged);
  if (filter == "NONE" || filter.empty()) return bytes;
  if (!is_attributes) throw CodecError("filter `" + filter.substr(0, 20) + "` is for ATTRIBUTES only");
  if (filter == "OCTAHEDRAL" && (size == 4 || size == 8)) {
    meshopt_decodeFilterOct(bytes.data(), elements, size);
  } else if (filter == "QUATERNION" && size == 8) {
    meshopt_decodeFilterQuat(bytes.data(), elements, size);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(bytes.data(), elements, size);
  } else {
    throw CodecError("filter `" + filter.substr(0, 20) + "` is not read for a stride of " +
                     std::to_string(size));
  }
  return bytes;
}

std::vector<unsigned char> encode_meshopt(std::span<const unsigned char> bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  meshopt_encodeVertexVersion(0);  // the only one that the extension allows
  std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(count, stride));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), bytes.data(), count, stride));
  return stream;
}

std::vector<unsigned char> encode_meshopt_indices(const std::vector<std::uint32_t>& indices, bool triangles) {
  const std::size_t count = indices.size();
  const std::size_t vertices =
      indices.empty() ? 0 : std::size_t{*std::max_element(indices.begin(), indices.end())} + 1;
  meshopt_encodeIndexVersion(1);  // the only one that the extension allows
  std::vector<unsigned char> stream(triangles ? meshopt_encodeIndexBufferBound(count, vertices)
                                              : meshopt_encodeIndexSequenceBound(count, vertices));
  stream.resize(triangles ? meshopt_encodeIndexBuffer(stream.data(), stream.size(), indices.data(), count)
                          : meshopt_encodeIndexSequence(stream.data(), stream.size(), indices.data(), count));
  return stream;
}

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
    if (!decoded.ok()) throw CodecError(damaged);
    const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
    if (mesh->num_points() != vertices)
      throw CodecError("the compressed mesh has " + std::to_string(mesh->num_points()) +
                       " vertices, and its accessor " + std::to_string(vertices));
    for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f)
      for (const draco::PointIndex& point : mesh->face(f)) {
        if (point.value() >= vertices) throw CodecError(damaged);
        result.corners.push_back(point.value());
      }
    for (const DracoAttribute& attribute : wanted) {
      const draco::PointAttribute* source = mesh->GetAttributeByUniqueId(attribute.id);
      if (source == nullptr)
        throw CodecError("the compressed mesh has no attribute " + std::to_string(attribute.id));
      const std::size_t step =
          component_bytes(attribute.component) * static_cast<std::size_t>(attribute.components);
      std::vector<unsigned char> bytes(step * static_cast<std::size_t>(vertices));
      for (draco::PointIndex p(0); p < mesh->num_points(); ++p) {
        if (source->mapped_index(p).value() >= source->size() ||
            !fill(*source, p, attribute, bytes.data() + step * p.value()))
          throw CodecError(damaged);
      }
      result.attributes.push_back(std::move(bytes));
    }
  } catch (const std::bad_alloc&) {
    throw CodecError(damaged);
  } catch (const std::length_error&) {
    throw CodecError(damaged);
  }
  return result;
}

}  // namespace fascicle::scene
