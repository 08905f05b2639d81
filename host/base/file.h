// Files that appear whole or not at all. Every system failure throws std::system_error with the path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::base {

enum class FileMode {
  read,
  modify,   // must exist; writes append. Throws BakeError for a symbolic link or one of several hard links
  replace,  // new and empty; replaces an existing name. A symbolic link is replaced, not followed
};

enum class Links { followed, refused };

// Reads a whole input, a regular file of at most `most_bytes`; throws InputError otherwise. The limit keeps a
// wrong name from filling memory. A pipe, device or folder is refused without waiting for it.
std::string read_input(const std::filesystem::path& path, std::uint64_t most_bytes);
std::vector<unsigned char> read_input_bytes(const std::filesystem::path& path, std::uint64_t most_bytes,
                                            Links links = Links::followed);
// The same; nothing if the path does not exist.
std::optional<std::string> read_input_if_there(const std::filesystem::path& path, std::uint64_t most_bytes);

// For a JSON file that this program wrote, such as a manifest.
inline constexpr std::uint64_t most_json_bytes = std::uint64_t{256} << 20;
// For a file of metrics, one row per frame.
inline constexpr std::uint64_t most_metrics_bytes = std::uint64_t{1} << 30;

// An open file. When opened for reading it must be a regular file; anything else throws InputError.
// Move-only.
class File {
 public:
  File(std::filesystem::path path, FileMode mode);
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const;
  // Appends all bytes.
  void write(std::string_view bytes);
  // Overwrites existing bytes; the next write still appends.
  void write_at(std::uint64_t offset, std::string_view bytes);
  // Fills `bytes` from `offset`; false if the file ends first.
  bool read_at(std::uint64_t offset, std::span<char> bytes) const;
  // Cuts the file to `size` bytes; the next write goes there.
  void truncate(std::uint64_t size);
  // On return, everything written survives a power cut.
  void sync();
  // Reports errors of delayed writes; the destructor cannot.
  void close();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

// Creates a folder for outputs if there is none. Throws BakeError if the path is a symbolic link.
void make_own_folder(const std::filesystem::path& path);

// Makes names created and removed in a folder survive a power cut.
void sync_folder(const std::filesystem::path& folder);

// Replaces whatever the new name referred to.
void rename_over(const std::filesystem::path& from, const std::filesystem::path& to);

// Includes the dot; only ASCII letters are lowered.
std::string lower_extension(const std::filesystem::path& path);

// Suffix of the file that write_whole writes before the final name appears.
inline constexpr const char* temporary_suffix = ".tmp";
// `path` holds either its old content or all of `bytes`, whatever happens.
void write_whole(const std::filesystem::path& path, std::string_view bytes);
// The same for bytes in several pieces.
void write_whole(const std::filesystem::path& path, std::span<const std::string_view> pieces);
// The same for several files of one folder: stage() writes the bytes next to `path`, and publish() makes them
// durable and then renames them, in this order.
void stage(const std::filesystem::path& path, std::string_view bytes);
void publish(const std::filesystem::path& folder, std::span<const std::filesystem::path> paths);

// The same with a unique temporary name, so that several processes may write one path at once; the last one
// wins.
void write_whole_beside_others(const std::filesystem::path& path, std::string_view bytes);

// Raw bytes of a number or an array of numbers, as in memory (files here are little-endian).
template <class T>
void append_bytes(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
std::string_view bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}
template <class T>
void append_array(std::string& out, std::span<const T> values) {
  out += bytes_of(values);
}

}  // namespace fascicle::base
