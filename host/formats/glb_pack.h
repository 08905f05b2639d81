// The bytes of a glTF document compressed (EXT_meshopt_compression), without loss.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Compressed bytes that become views of a document: where they will lie in its buffer 0, what they hold.
struct PackedView {
  std::uint64_t offset = 0, bytes = 0;  // compressed
  std::uint64_t count = 0;
  std::size_t stride = 4;
  const char* mode = "ATTRIBUTES";
};

// As a stream, its length a multiple of 4.
std::string packed_bytes(const std::vector<unsigned char>& stream);

// Views over compressed bytes: what they hold lies in buffer 1, which no file has.
class PackedViews {
 public:
  // `has_stride`: the accessors need it said.
  nlohmann::json view(const PackedView& packed, bool has_stride);
  // Both buffers, and that a reader must know how.
  void declare(nlohmann::json& document, std::uint64_t binary_bytes) const;

 private:
  std::uint64_t plain_bytes_ = 0;
};

// Every view of the document that numbers of one size fill; images and what nobody knows stay as they are.
// Of `perhaps_unused` accessors those that nothing refers to become empty ones, and their bytes are left out.
void pack_views(gltf::GltfDocument& document, const std::set<std::size_t>& perhaps_unused,
                PackedViews& views);

}  // namespace fascicle::formats
