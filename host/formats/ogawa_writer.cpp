#include "host/formats/ogawa_writer.h"

#include <string>

namespace fascicle::formats {

namespace {

constexpr std::uint64_t finished_offset = 5, root_offset = 8;

}  // namespace

OgawaWriter::OgawaWriter(const std::filesystem::path& path) : file_(base::PartFile::start(path)) {
  const std::string header("Ogawa\0\0\1\0\0\0\0\0\0\0\0", 16);
  file_.write(header);
  size_ = header.size();
}

OgawaWriter::Child OgawaWriter::data(std::initializer_list<std::string_view> pieces) {
  std::string bytes;
  std::uint64_t length = 0;
  for (const std::string_view piece : pieces) length += piece.size();
  if (length == 0) return empty_data;
  bytes.reserve(sizeof length + length);
  base::append_bytes(bytes, length);
  for (const std::string_view piece : pieces) bytes += piece;
  file_.write(bytes);
  const Child child = size_ | data_bit;
  size_ += bytes.size();
  return child;
}

OgawaWriter::Child OgawaWriter::group(std::span<const Child> children) {
  if (children.empty()) return empty_group;
  std::string bytes;
  base::append_bytes(bytes, std::uint64_t{children.size()});
  base::append_array(bytes, children);
  file_.write(bytes);
  const Child child = size_;
  size_ += bytes.size();
  return child;
}

void OgawaWriter::finish(Child root) {
  std::string offset;
  base::append_bytes(offset, root);
  file_.write_at(root_offset, offset);
  file_.write_at(finished_offset, "\xff");
  file_.finish();
}

}  // namespace fascicle::formats
