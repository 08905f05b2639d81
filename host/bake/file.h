// Files that appear whole or not at all. Every failure of the system throws std::system_error with the path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace fascicle::bake {

enum class FileMode {
  read,
  modify,   // must exist; writes go to its end
  replace,  // empty; made if it is not there
};

// An open file. Move-only.
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

// Makes new and removed names in a folder survive a power cut.
void sync_folder(const std::filesystem::path& folder);

// Suffix of what write_whole writes before the final name appears.
inline constexpr const char* temporary_suffix = ".tmp";
// Suffix of a stream that is not finished.
inline constexpr const char* part_suffix = ".part";

// `path` holds either its old content or all of `bytes`, whatever happens.
void write_whole(const std::filesystem::path& path, std::string_view bytes);
// The same as far as other processes see, also if this one is killed; durable only after sync_file and
// sync_folder.
void write_whole_unsynced(const std::filesystem::path& path, std::string_view bytes);
void sync_file(const std::filesystem::path& path);

// A stream that grows frame by frame under the name PATH.part and becomes PATH in finish().
class PartFile {
 public:
  // Starts an empty stream.
  static PartFile start(const std::filesystem::path& path);
  // Goes on after the first `bytes` bytes of an earlier stream, unfinished or finished. Throws BakeError if
  // it is not there or holds less.
  static PartFile resume(const std::filesystem::path& path, std::uint64_t bytes);
  // Goes on after the first `lines` lines.
  static PartFile resume_lines(const std::filesystem::path& path, std::uint64_t lines);

  void write(std::string_view bytes) { file_.write(bytes); }
  void sync() { file_.sync(); }
  void finish();

 private:
  PartFile(std::filesystem::path path, File file);
  std::filesystem::path path_;
  File file_;
};

// Raw bytes of a number or of an array of numbers, as they lie in memory (files here are little-endian).
template <class T>
void append_bytes(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
void append_array(std::string& out, std::span<const T> values) {
  out.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

}  // namespace fascicle::bake
