// Decodes compressed geometry of glTF files, and encodes meshopt. Streams are untrusted: every size is
// checked against the file's claims and the stream's length before memory is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace fascicle::gltf {

// what() is the fault, without its place in the file.
struct CodecError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr const char* damaged_stream =
    "the compressed stream is damaged; export again, or without compression";

// Whether this build has meshoptimizer. Portable builds do not; the next three functions then throw
// CodecError.
bool has_meshopt();

// EXT_meshopt_compression; returns count x stride bytes. Mode: ATTRIBUTES, TRIANGLES or INDICES. Filter:
// NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL. Throws CodecError.
std::vector<unsigned char> decode_meshopt(std::span<const unsigned char> stream, std::uint64_t count,
                                          std::uint64_t stride, const std::string& mode,
                                          const std::string& filter);

// Encodes a stream of mode ATTRIBUTES for decode_meshopt. `bytes`: whole elements of `stride` bytes;
// `stride`: a multiple of 4, at most 256.
std::vector<unsigned char> encode_meshopt(std::span<const unsigned char> bytes, std::size_t stride);
// Mode TRIANGLES needs a multiple of 3 indices and may rotate the corners of a triangle; otherwise mode
// INDICES.
std::vector<unsigned char> encode_meshopt_indices(const std::vector<std::uint32_t>& indices, bool triangles);

// An attribute to extract from a Draco stream: its unique id, and the type of the accessor it fills.
struct DracoAttribute {
  std::uint32_t id = 0;
  std::uint64_t component = 0;   // glTF's component type, 5120 to 5126
  std::uint64_t components = 0;  // numbers per vertex, 1 to 4
};

struct DracoMesh {
  std::vector<std::uint32_t> corners;                  // three per triangle
  std::vector<std::vector<unsigned char>> attributes;  // in the order of `wanted`, tightly packed
};

// KHR_draco_mesh_compression: a triangle mesh of exactly `vertices` vertices. Throws CodecError.
DracoMesh decode_draco(std::span<const unsigned char> stream, std::uint64_t vertices,
                       const std::vector<DracoAttribute>& wanted);

}  // namespace fascicle::gltf
