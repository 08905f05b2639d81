#include "host/build/cache.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <system_error>
#include <vector>

#include "host/base/content_hash.h"
#include "host/base/errors.h"
#include "host/base/file.h"

namespace fascicle::build {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "fascicle cache 1\n";
constexpr const char* suffix = ".entry";
// A temporary file older than this was left by a dead process.
constexpr auto forgotten = std::chrono::hours(1);

std::string checksum_of(std::string_view bytes) {
  base::ContentHash hash;
  hash.add(bytes);
  return hash.text();
}

// Magic, key, checksum of the bytes, bytes.
std::string header_of(const std::string& key, std::string_view bytes) {
  return std::string(magic) + key + "\n" + checksum_of(bytes) + "\n";
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool is_hexadecimal(const std::string& text, std::size_t least_digits) {
  return text.size() >= least_digits && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// KEY.entry, where keys are hashes. The folder may also hold files of others.
bool is_entry(const fs::path& path) {
  return path.extension() == suffix && is_hexadecimal(path.stem().string(), 32);
}

// As base::write_whole_beside_others names it: KEY.entry.NUMBER.tmp.
bool is_entry_in_writing(const fs::path& path) {
  if (path.extension() != base::temporary_suffix) return false;
  const std::string number = path.stem().extension().string();
  return !number.empty() && is_hexadecimal(number.substr(1), 16) && is_entry(path.stem().stem());
}

}  // namespace

fs::path default_cache_folder() {
  if (const std::string own = environment("FASCICLE_CACHE_DIR"); !own.empty()) return own;
  // The XDG base directory specification says to ignore relative paths.
  if (const fs::path caches = environment("XDG_CACHE_HOME"); caches.is_absolute()) return caches / "fascicle";
  if (const fs::path home = environment("HOME"); home.is_absolute()) return home / ".cache" / "fascicle";
  return {};
}

Cache::Cache(fs::path folder, std::uint64_t limit) : folder_(std::move(folder)), limit_(limit) {}

fs::path Cache::path_of(const std::string& key) const {
  return folder_ / (key + suffix);
}

std::optional<std::string> Cache::find(const std::string& key) const {
  if (folder_.empty()) return std::nullopt;
  try {
    const fs::path path = path_of(key);
    const base::File file(path, base::FileMode::read);
    const std::uint64_t size = file.size();
    std::string header = header_of(key, {});
    if (size > limit_ || size < header.size()) return std::nullopt;
    std::string bytes(static_cast<std::size_t>(size) - header.size(), '\0');
    if (!file.read_at(0, header) || !file.read_at(header.size(), bytes)) return std::nullopt;
    if (header != header_of(key, bytes)) return std::nullopt;
    std::error_code ignored;
    fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
    return bytes;
  } catch (const base::InputError&) {
    return std::nullopt;
  } catch (const std::system_error&) {
    return std::nullopt;
  }
}

void Cache::put(const std::string& key, std::string_view bytes) const {
  if (folder_.empty()) return;
  std::string whole = header_of(key, bytes);
  if (whole.size() + bytes.size() > limit_) return;
  whole += bytes;
  try {
    fs::create_directories(folder_);
    base::write_whole_beside_others(path_of(key), whole);
    make_room(path_of(key));
  } catch (const std::system_error&) {
    // Full, read-only or not a folder: the next bake makes the entry again.
  }
}

// Other processes may add and remove entries meanwhile: an entry that is already gone is no error.
void Cache::make_room(const fs::path& newest) const {
  struct Entry {
    fs::file_time_type used;
    fs::path path;
    std::uint64_t size;
  };
  std::vector<Entry> entries;
  std::uint64_t total = 0;
  std::error_code ignored;
  // The file system's clock may be another host's, so it is the reference: files being written must not look
  // forgotten.
  const fs::file_time_type now = fs::last_write_time(newest);
  for (const fs::directory_entry& file : fs::directory_iterator(folder_, ignored)) {
    std::error_code gone;
    if (!file.is_regular_file(gone)) continue;
    const fs::file_time_type used = file.last_write_time(gone);
    const std::uint64_t size = file.file_size(gone);
    if (gone) continue;
    if (is_entry_in_writing(file.path()) && used < now - forgotten) fs::remove(file.path(), ignored);
    if (!is_entry(file.path())) continue;
    total += size;
    if (file.path() != newest) entries.push_back({used, file.path(), size});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.used != b.used ? a.used < b.used : a.path < b.path;
  });
  for (const Entry& entry : entries) {
    if (total <= limit_) break;
    fs::remove(entry.path, ignored);
    total -= entry.size;
  }
}

}  // namespace fascicle::build
