// Compressed geometry of glTF files, to plain bytes and, for meshopt, back. Streams are hostile: every size
// is bounded by what the file says and by the stream's own length before memory is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace fascicle::gltf {

// what() is what is wrong, without the place.
struct CodecError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr const char* damaged_stream =
    "the compressed stream is damaged; export again, or without compression";

// Whether this build has meshoptimizer; portable ones do not, and the next three throw CodecError there.
bool has_meshopt();

// EXT_meshopt_compression: count x stride bytes. Mode ATTRIBUTES, TRIANGLES or INDICES; filter NONE,
// OCTAHEDRAL, QUATERNION or EXPONENTIAL. Throws CodecError.
std::vector<unsigned char> decode_meshopt(std::span<const unsigned char> stream, std::uint64_t count,
                                          std::uint64_t stride, const std::string& mode,
                                          const std::string& filter);

// The stream of mode ATTRIBUTES that decode_meshopt reads: whole elements of `stride` bytes, a multiple of 4
// of at most 256.
std::vector<unsigned char> encode_meshopt(std::span<const unsigned char> bytes, std::size_t stride);
// That of mode TRIANGLES, which may begin a triangle at another corner, for a multiple of 3, or of INDICES.
std::vector<unsigned char> encode_meshopt_indices(const std::vector<std::uint32_t>& indices, bool triangles);

// One attribute wanted of a Draco stream: its unique id, and the accessor it fills.
struct DracoAttribute {
  std::uint32_t id = 0;
  std::uint64_t component = 0;   // glTF's component type, 5120 to 5126
  std::uint64_t components = 0;  // numbers a vertex, 1 to 4
};

struct DracoMesh {
  std::vector<std::uint32_t> corners;                  // three a triangle
  std::vector<std::vector<unsigned char>> attributes;  // as wanted, tightly packed
};

// KHR_draco_mesh_compression: a triangle mesh of exactly `vertices` vertices. Throws CodecError.
DracoMesh decode_draco(std::span<const unsigned char> stream, std::uint64_t vertices,
                       const std::vector<DracoAttribute>& wanted);

}  // namespace fascicle::gltf
