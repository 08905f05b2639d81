#include "host/formats/frame_files.h"

#include <algorithm>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"

namespace fascicle::formats {

namespace fs = std::filesystem;

namespace {

constexpr const char* prefix = "frame_";
constexpr std::size_t prefix_length = 6;
constexpr std::size_t least_digits = 6;

}  // namespace

std::string frame_file_name(std::uint64_t number, const std::string& extension) {
  std::string digits = base::number_text(number);
  if (digits.size() < least_digits) digits.insert(0, least_digits - digits.size(), '0');
  return prefix + digits + '.' + extension;
}

bool is_frame_file_name(const std::string& name, const std::string& extension) {
  const std::string suffix = '.' + extension;
  if (name.size() < prefix_length + least_digits + suffix.size() || !name.starts_with(prefix) ||
      !name.ends_with(suffix))
    return false;
  return std::all_of(name.begin() + prefix_length,
                     name.end() - static_cast<std::string::difference_type>(suffix.size()),
                     [](char c) { return c >= '0' && c <= '9'; });
}

FrameFiles::FrameFiles(const fs::path& folder, const std::string& extension, std::uint64_t first,
                       std::uint64_t first_number)
    : folder_(folder / extension), extension_(extension), first_number_(first_number) {
  base::make_own_folder(folder_);
  for (std::uint64_t k = 0; k < first; ++k)
    if (!base::has_content(path_of(k))) throw base::LostFile(path_of(k));
  const auto remove_frame = [&](std::uint64_t k) {
    const bool was_staged = fs::remove(path_of(k).string() + base::temporary_suffix);
    return fs::remove(path_of(k)) || was_staged;
  };
  for (std::uint64_t k = first; remove_frame(k); ++k) {
  }
}

fs::path FrameFiles::path_of(std::uint64_t frame) const {
  return folder_ / frame_file_name(number_of(frame), extension_);
}

void FrameFiles::write(std::uint64_t frame, std::string_view bytes) {
  base::stage(path_of(frame), bytes);
  staged_.push_back(path_of(frame));
}

void FrameFiles::sync() {
  base::publish(folder_, staged_);
  staged_.clear();
}

}  // namespace fascicle::formats
