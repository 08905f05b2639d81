// A folder of results that took long, each under the hash of what it was made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace fascicle::build {

// The folder that results are kept in by default: $FASCICLE_CACHE_DIR, else $XDG_CACHE_HOME/fascicle, else
// ~/.cache/fascicle; empty where none of these can be told.
std::filesystem::path default_cache_folder();

// Nothing here throws: a cache that cannot be read or written only makes the program slower. Entries appear
// whole or not at all and carry a checksum. Several processes may use one folder.
class Cache {
 public:
  static constexpr std::uint64_t default_limit = std::uint64_t{2} << 30;  // bytes

  // An empty folder keeps nothing. Where entries outgrow `limit` bytes, those that were not used for longest
  // go.
  explicit Cache(std::filesystem::path folder, std::uint64_t limit = default_limit);

  // The entry of `key` (hex digits), if it is whole. Counts as a use.
  std::optional<std::string> find(const std::string& key) const;

  // Keeps `bytes`, in place of what was there.
  void put(const std::string& key, std::string_view bytes) const;

 private:
  std::filesystem::path path_of(const std::string& key) const;
  void make_room(const std::filesystem::path& newest) const;

  std::filesystem::path folder_;
  std::uint64_t limit_;
};

}  // namespace fascicle::build
