// Replaces gltf_meshopt.cpp in portable builds, which do not link meshoptimizer.
#include "host/gltf/gltf_codecs.h"

namespace fascicle::gltf {
namespace {

[[noreturn]] void refuse() {
  throw CodecError(
      "this build of fascicle has no meshoptimizer; export without meshopt compression, or use a build that "
      "is "
      "not portable");
}

}  // namespace

bool has_meshopt() {
  return false;
}

std::vector<unsigned char> decode_meshopt(std::span<const unsigned char>, std::uint64_t, std::uint64_t,
                                          const std::string&, const std::string&) {
  refuse();
}

std::vector<unsigned char> encode_meshopt(std::span<const unsigned char>, std::size_t) {
  refuse();
}

std::vector<unsigned char> encode_meshopt_indices(const std::vector<std::uint32_t>&, bool) {
  refuse();
}

}  // namespace fascicle::gltf
