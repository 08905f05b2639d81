#include <algorithm>
#include <string>

#include <meshoptimizer.h>

#include "host/gltf/gltf_codecs.h"

namespace fascicle::gltf {
namespace {

// Real streams use at least about a byte per vertex; a hostile one could claim enough to exhaust memory.
constexpr std::uint64_t most_meshopt_bytes = std::uint64_t{1} << 30;
constexpr std::uint64_t most_bytes_a_byte = 4096;

}  // namespace

bool has_meshopt() {
  return true;
}

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
  if (result != 0) throw CodecError(damaged_stream);
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

}  // namespace fascicle::gltf
