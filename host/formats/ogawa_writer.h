// Ogawa, the container of Alembic files: blocks of data, and groups that list their children by offset.
// Everything is written once, children before their group, so files of any length can be streamed.
//
//   file    "Ogawa", uint8 255 (0 while unfinished), uint8 0 1 (version), uint64 offset of the root group
//   data    uint64 size, then the bytes
//   group   uint64 count, then for each child its uint64 offset, with the highest bit set for data
// Offset 0 is a group without children, 2^63 is data without bytes. Little-endian.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string_view>

#include "host/base/part_file.h"

namespace fascicle::formats {

class OgawaWriter {
 public:
  using Child = std::uint64_t;  // in the encoding of a group's list
  static constexpr Child data_bit = std::uint64_t{1} << 63;
  static constexpr Child empty_group = 0;
  static constexpr Child empty_data = data_bit;

  explicit OgawaWriter(const std::filesystem::path& path);
  // Writes the pieces as one block.
  Child data(std::initializer_list<std::string_view> pieces);
  Child group(std::span<const Child> children);
  // Finishes the file and gives it its final name.
  void finish(Child root);

 private:
  base::PartFile file_;
  std::uint64_t size_ = 0;
};

}  // namespace fascicle::formats
