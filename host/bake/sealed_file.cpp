#include "host/bake/sealed_file.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace fascicle::bake {

namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 20;

}  // namespace

bool is_sealed_part(const base::File& file, std::uint64_t begin, std::uint64_t bytes) {
  std::uint64_t checksum = 0;
  if (bytes < sizeof checksum) return false;
  const std::uint64_t end = begin + bytes - sizeof checksum;
  XXH3_state_t hash;
  XXH3_64bits_reset(&hash);
  std::vector<char> piece(std::min<std::uint64_t>(piece_bytes, bytes));
  for (std::uint64_t at = begin; at < end; at += piece_bytes) {
    const std::span<char> part = std::span(piece).first(std::min<std::uint64_t>(piece_bytes, end - at));
    if (!file.read_at(at, part)) return false;
    XXH3_64bits_update(&hash, part.data(), part.size());
  }
  const std::span<char> last = std::span(piece).first(sizeof checksum);
  if (!file.read_at(end, last)) return false;
  std::memcpy(&checksum, last.data(), sizeof checksum);
  return XXH3_64bits_digest(&hash) == checksum;
}

std::string read_sealed(const base::File& file, std::string_view magic) {
  std::string bytes(magic.size(), '\0');
  if (!file.read_at(0, bytes)) return {};
  const std::uint64_t size = file.size();
  if (bytes != magic || size > most_sealed_bytes || !is_sealed_part(file, 0, size)) return bytes;
  bytes.resize(size);
  if (!file.read_at(0, bytes)) bytes.clear();
  return bytes;
}

}  // namespace fascicle::bake
