#include "tests/fuzz/seal.h"

#include <cstdint>
#include <cstring>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace fascicle::fuzz {

void seal(std::string& bytes, std::size_t begin, std::size_t end) {
  std::uint64_t checksum = 0;
  if (begin > end || bytes.size() < sizeof checksum || end > bytes.size() - sizeof checksum) return;
  checksum = XXH3_64bits(bytes.data() + begin, end - begin);
  std::memcpy(bytes.data() + end, &checksum, sizeof checksum);
}

std::string sealed(std::string_view bytes, std::size_t begin) {
  std::string whole(bytes);
  if (whole.size() >= sizeof(std::uint64_t)) seal(whole, begin, whole.size() - sizeof(std::uint64_t));
  return whole;
}

}  // namespace fascicle::fuzz
