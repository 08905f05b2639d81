// Streams that a bake writes frame by frame; whole files are host/base/file.h's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>

#include "host/base/file.h"

namespace fascicle::base {

// Suffix of a stream that is not finished.
inline constexpr const char* part_suffix = ".part";

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
  // Writes over what was written before.
  void write_at(std::uint64_t offset, std::string_view bytes) { file_.write_at(offset, bytes); }
  void sync() { file_.sync(); }
  void finish();

 private:
  PartFile(std::filesystem::path path, File file);
  std::filesystem::path path_;
  File file_;
};

// What must wait for the end of a stream: grows under the name PATH.part and goes into another file.
class SpoolFile {
 public:
  static SpoolFile start(const std::filesystem::path& path);
  void write(std::string_view bytes) {
    file_.write(bytes);
    size_ += bytes.size();
  }
  std::uint64_t size() const { return size_; }
  // Appends `bytes` bytes from `offset` on to `to`.
  void copy_to(PartFile& to, std::uint64_t offset, std::uint64_t bytes) const;
  // Appends all of it to `to` and removes it.
  void move_to(PartFile& to);
  void remove();

 private:
  explicit SpoolFile(File file) : file_(std::move(file)) {}
  File file_;
  std::uint64_t size_ = 0;
};

}  // namespace fascicle::base
