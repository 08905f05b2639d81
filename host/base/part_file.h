// Streams that a bake writes frame by frame. For files written whole, see host/base/file.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "host/base/errors.h"
#include "host/base/file.h"

namespace fascicle::base {

// A file of the bake to resume is gone, or holds fewer frames than it should.
struct LostFile : BakeError {
  explicit LostFile(const std::filesystem::path& path,
                    const std::string& why = "the bake to resume has lost this file")
      : BakeError(path.string() + ": " + why + "; start again with --overwrite"),
        reason(path.string() + ": " + why) {}
  std::string reason;  // without the advice
};

// Whether it is a regular file that is not empty.
bool has_content(const std::filesystem::path& path);

// Suffix of an unfinished stream.
inline constexpr const char* part_suffix = ".part";

// A stream that grows frame by frame as PATH.part; finish() renames it to PATH.
class PartFile {
 public:
  // Starts an empty stream.
  static PartFile start(const std::filesystem::path& path);
  // Continues after the first `bytes` bytes of an earlier stream, finished or not. Throws LostFile if it
  // does not exist or is shorter.
  static PartFile resume(const std::filesystem::path& path, std::uint64_t bytes);
  // Continues after the first `lines` lines.
  static PartFile resume_lines(const std::filesystem::path& path, std::uint64_t lines);
  // Throws what resume_lines() would throw, and changes nothing.
  static void check_lines(const std::filesystem::path& path, std::uint64_t lines);

  void write(std::string_view bytes) { file_.write(bytes); }
  // Overwrites earlier bytes.
  void write_at(std::uint64_t offset, std::string_view bytes) { file_.write_at(offset, bytes); }
  void sync() { file_.sync(); }
  void finish();

 private:
  PartFile(std::filesystem::path path, File file);
  std::filesystem::path path_;
  File file_;
};

// Holds data that belongs at the end of a stream: grows as PATH.part and is then appended to another file.
class SpoolFile {
 public:
  static SpoolFile start(const std::filesystem::path& path);
  void write(std::string_view bytes) {
    file_.write(bytes);
    size_ += bytes.size();
  }
  std::uint64_t size() const { return size_; }
  // Appends `bytes` bytes, starting at `offset`, to `to`.
  void copy_to(PartFile& to, std::uint64_t offset, std::uint64_t bytes) const;
  // Appends everything to `to` and removes this file.
  void move_to(PartFile& to);
  void remove();

 private:
  explicit SpoolFile(File file) : file_(std::move(file)) {}
  File file_;
  std::uint64_t size_ = 0;
};

}  // namespace fascicle::base
