// Lossless compression of a glTF document's buffer (EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Compressed bytes that become a view of a document: their place in buffer 0, and what they hold.
struct PackedView {
  std::uint64_t offset = 0, bytes = 0;  // compressed
  std::uint64_t count = 0;
  std::size_t stride = 4;
  const char* mode = "ATTRIBUTES";
};

// The stream, padded to a multiple of 4 bytes.
std::string packed_bytes(const std::vector<unsigned char>& stream);

// Views of compressed bytes. Uncompressed, they refer to buffer 1, a fallback that is not in the file.
class PackedViews {
 public:
  // `has_stride`: the accessors need an explicit stride.
  nlohmann::json view(const PackedView& packed, bool has_stride);
  // Declares both buffers and the required extensions.
  void declare(nlohmann::json& document, std::uint64_t binary_bytes) const;

 private:
  std::uint64_t plain_bytes_ = 0;
};

// Compresses every view filled by numbers of one size; images and unknown contents stay uncompressed.
// Accessors in `perhaps_unused` that nothing refers to become empty, and their bytes are dropped.
void pack_views(gltf::GltfDocument& document, const std::set<std::size_t>& perhaps_unused,
                PackedViews& views);

}  // namespace fascicle::formats
