// Files that appear whole or not at all. Every failure of the system throws std::system_error with the path.
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
  modify,   // must exist; writes go to its end. Throws BakeError where it is a symbolic link
  replace,  // new and empty: takes the place of what had the name, a symbolic link too, which is not followed
};

enum class Links { followed, refused };

// The whole of an input, or InputError: a regular file of at most `most_bytes`, which keep a wrong name from
// filling the memory. A pipe, a device or a folder of that name is refused and never waited for.
std::string read_input(const std::filesystem::path& path, std::uint64_t most_bytes);
std::vector<unsigned char> read_input_bytes(const std::filesystem::path& path, std::uint64_t most_bytes,
                                            Links links = Links::followed);
// The same; nothing where there is nothing of that name.
std::optional<std::string> read_input_if_there(const std::filesystem::path& path, std::uint64_t most_bytes);

// Of a file of JSON that this program wrote, such as a manifest.
inline constexpr std::uint64_t most_json_bytes = std::uint64_t{256} << 20;
// Of a file of metrics: a row a frame.
inline constexpr std::uint64_t most_metrics_bytes = std::uint64_t{1} << 30;

// An open file, regular where it is read: InputError says that of others. Move-only.
class File {
 public:
  File(std::filesystem::path path, FileMode mode);
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const;
  // Appends all of it.
  void write(std::string_view bytes);
  // Writes over bytes that are there; the next write goes to the end as before.
  void write_at(std::uint64_t offset, std::string_view bytes);
  // Fills `bytes` from `offset`; false if the file ends before.
  bool read_at(std::uint64_t offset, std::span<char> bytes) const;
  // Cuts to `size` bytes; the next write goes there.
  void truncate(std::uint64_t size);
  // On return what was written survives a power cut.
  void sync();
  // Reports what a delayed write still had to say; the destructor cannot.
  void close();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

// Makes a folder for outputs where there is none. Throws BakeError where a symbolic link has its name.
void make_own_folder(const std::filesystem::path& path);

// Makes new and removed names in a folder survive a power cut.
void sync_folder(const std::filesystem::path& folder);

// The new name takes the place of what it named before.
void rename_over(const std::filesystem::path& from, const std::filesystem::path& to);

// With its dot; only ASCII letters are lowered.
std::string lower_extension(const std::filesystem::path& path);

// Suffix of what write_whole writes before the final name appears.
inline constexpr const char* temporary_suffix = ".tmp";
// `path` holds either its old content or all of `bytes`, whatever happens.
void write_whole(const std::filesystem::path& path, std::string_view bytes);
// The same of what lies in several places.
void write_whole(const std::filesystem::path& path, std::span<const std::string_view> pieces);
// The same for several files of one folder: stage() writes the bytes beside `path`, and publish() makes them
// durable before it gives them their names, in this order.
void stage(const std::filesystem::path& path, std::string_view bytes);
void publish(const std::filesystem::path& folder, std::span<const std::filesystem::path> paths);

// The same through a temporary file of a name of its own, so that several may write one path at a time; the
// last one's stays.
void write_whole_beside_others(const std::filesystem::path& path, std::string_view bytes);

// Raw bytes of a number or of an array of numbers, as they lie in memory (files here are little-endian).
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
