// A folder of expensive results, each stored under the hash of its inputs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace fascicle::build {

// The default cache folder: $FASCICLE_CACHE_DIR, else $XDG_CACHE_HOME/fascicle, else ~/.cache/fascicle; empty
// if none can be determined.
std::filesystem::path default_cache_folder();

// Nothing here throws: a cache that cannot be read or written only makes the program slower. Entries are
// written atomically and carry a checksum. Several processes may share a folder.
class Cache {
 public:
  static constexpr std::uint64_t default_limit = std::uint64_t{2} << 30;  // bytes

  // An empty folder keeps nothing. If entries exceed `limit` bytes, the least recently used are removed.
  explicit Cache(std::filesystem::path folder, std::uint64_t limit = default_limit);

  // The entry of `key` (hex digits), if it is intact. Counts as a use.
  std::optional<std::string> find(const std::string& key) const;

  // Stores `bytes`, replacing any previous entry.
  void put(const std::string& key, std::string_view bytes) const;

 private:
  std::filesystem::path path_of(const std::string& key) const;
  void make_room(const std::filesystem::path& newest) const;

  std::filesystem::path folder_;
  std::uint64_t limit_;
};

}  // namespace fascicle::build
