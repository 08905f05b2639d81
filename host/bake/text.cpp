#include "host/bake/text.h"

#include <cinttypes>
#include <cstdio>

namespace fascicle::bake {

std::string hash_text(std::uint64_t hash) {
  std::array<char, 17> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%016" PRIx64, hash);
  return buffer.data();
}

}  // namespace fascicle::bake
