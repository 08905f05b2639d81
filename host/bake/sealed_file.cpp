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

bool is_sealed_file(const base::File& file) {
  std::uint64_t checksum = 0;
  const std::uint64_t size = file.size();
  if (size < sizeof checksum || size > most_sealed_bytes) return false;
  const std::uint64_t end = size - sizeof checksum;
  XXH3_state_t hash;
  XXH3_64bits_reset(&hash);
  std::vector<char> piece(std::min<std::uint64_t>(piece_bytes, size));
  for (std::uint64_t at = 0; at < end; at += piece_bytes) {
    const std::span<char> bytes = std::span(piece).first(std::min<std::uint64_t>(piece_bytes, end - at));
    if (!file.read_at(at, bytes)) return false;
    XXH3_64bits_update(&hash, bytes.data(), bytes.size());
  }
  const std::span<char> last = std::span(piece).first(sizeof checksum);
  if (!file.read_at(end, last)) return false;
  std::memcpy(&checksum, last.data(), sizeof checksum);
  return XXH3_64bits_digest(&hash) == checksum;
}

}  // namespace

std::string read_sealed(const base::File& file, std::string_view magic) {
  std::string bytes(magic.size(), '\0');
  if (!file.read_at(0, bytes)) return {};
  if (bytes != magic || !is_sealed_file(file)) return bytes;
  bytes.resize(file.size());
  if (!file.read_at(0, bytes)) bytes.clear();
  return bytes;
}

}  // namespace fascicle::bake
