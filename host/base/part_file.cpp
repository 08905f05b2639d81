#include "host/base/part_file.h"

#include <algorithm>
#include <cerrno>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/errors.h"

namespace fascicle::base {

namespace fs = std::filesystem;

namespace {

fs::path with_suffix(const fs::path& path, const char* suffix) {
  return fs::path(path.string() + suffix);
}

// PATH.part of an earlier bake, or its final name: a bake that stopped between its renames has files of both
// kinds.
fs::path kept_form(const fs::path& path) {
  const fs::path part = with_suffix(path, part_suffix);
  if (fs::exists(fs::symlink_status(part))) return part;
  if (!fs::exists(path)) throw LostFile(path);
  return path;
}

// Opens PATH.part. If it already has its final name, it is renamed back first.
File reopen(const fs::path& path) {
  const fs::path part = with_suffix(path, part_suffix);
  if (const fs::path kept = kept_form(path); kept != part) {
    (void)File(kept, FileMode::modify);  // what is refused keeps its name
    rename_over(kept, part);
  }
  return File(part, FileMode::modify);
}

[[noreturn]] void fail_short(const fs::path& path) {
  throw LostFile(with_suffix(path, part_suffix), "holds fewer frames than the checkpoint");
}

// Where the first `lines` lines end.
std::uint64_t end_of_lines(const File& file, const fs::path& path, std::uint64_t lines) {
  const std::uint64_t size = file.size();
  std::vector<char> block(std::size_t{1} << 16);
  std::uint64_t end = 0;
  while (lines > 0) {
    const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), size - end));
    if (count == 0 || !file.read_at(end, std::span(block).first(count))) fail_short(path);
    for (std::size_t i = 0; i < count && lines > 0; ++i) {
      if (block[i] == '\n') --lines;
      ++end;
    }
  }
  return end;
}

}  // namespace

bool has_content(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(path, none) && fs::file_size(path, none) > 0;
}

PartFile::PartFile(fs::path path, File file) : path_(std::move(path)), file_(std::move(file)) {}

PartFile PartFile::start(const fs::path& path) {
  return {path, File(with_suffix(path, part_suffix), FileMode::replace)};
}

PartFile PartFile::resume(const fs::path& path, std::uint64_t bytes) {
  File file = reopen(path);
  if (file.size() < bytes) fail_short(path);
  file.truncate(bytes);
  return {path, std::move(file)};
}

PartFile PartFile::resume_lines(const fs::path& path, std::uint64_t lines) {
  File file = reopen(path);
  file.truncate(end_of_lines(file, path, lines));
  return {path, std::move(file)};
}

void PartFile::check_lines(const fs::path& path, std::uint64_t lines) {
  const File file(kept_form(path), FileMode::modify);
  (void)end_of_lines(file, path, lines);
}

void PartFile::finish() {
  file_.sync();
  file_.close();
  rename_over(with_suffix(path_, part_suffix), path_);
  sync_folder(path_.parent_path());
}

SpoolFile SpoolFile::start(const fs::path& path) {
  return SpoolFile(File(with_suffix(path, part_suffix), FileMode::replace));
}

void SpoolFile::copy_to(PartFile& to, std::uint64_t offset, std::uint64_t bytes) const {
  std::vector<char> block(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, std::uint64_t{1} << 20)));
  for (const std::uint64_t end = offset + bytes; offset < end;) {
    const std::span<char> piece =
        std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), end - offset)));
    if (!file_.read_at(offset, piece))
      throw std::system_error(EIO, std::generic_category(), "cannot read " + file_.path().string());
    to.write({piece.data(), piece.size()});
    offset += piece.size();
  }
}

void SpoolFile::move_to(PartFile& to) {
  copy_to(to, 0, size_);
  remove();
}

void SpoolFile::remove() {
  fs::remove(file_.path());
}

}  // namespace fascicle::base
