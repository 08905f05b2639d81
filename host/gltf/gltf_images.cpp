#include "host/gltf/gltf_images.h"

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "host/gltf/gltf_file.h"

namespace fascicle::gltf {
namespace {

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return -1;
}

}  // namespace

ImageBytes ImagesBeside::read(const std::string& pointer, const std::string& uri) {
  const std::filesystem::path file = gltf_buffer_file(gltf_, pointer, uri);
  if (const auto known = bytes_of_.find(file); known != bytes_of_.end()) return known->second;
  std::vector<unsigned char> bytes;
  if (bytes_left_ > 0) {
    std::vector<std::filesystem::path> ignored;
    bytes = read_gltf_buffer(gltf_, pointer, uri, ignored);
  }
  if (bytes_left_ == 0 || bytes.size() > bytes_left_) {
    bytes_left_ = 0;
    gltf_error(gltf_, pointer,
               "the images beside the file have more than " + std::to_string(most_bytes_) + " bytes in all");
  }
  bytes_left_ -= bytes.size();
  return bytes_of_[file] = std::make_shared<const std::vector<unsigned char>>(std::move(bytes));
}

std::vector<unsigned char> data_uri_bytes(const std::string& uri) {
  const std::size_t mark = uri.find(";base64,");
  if (mark == std::string::npos) return {};
  std::vector<unsigned char> bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (std::size_t k = mark + 8; k < uri.size() && uri[k] != '='; ++k) {
    const int value = base64_value(uri[k]);
    if (value < 0) return {};
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<unsigned char>(bits >> count & 0xffu));
  }
  return bytes;
}

std::string media_type_of(const std::vector<unsigned char>& bytes) {
  const auto has = [&](std::size_t at, std::string_view text) {
    return bytes.size() >= at + text.size() &&
           std::equal(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                      [](char c, unsigned char byte) { return static_cast<unsigned char>(c) == byte; });
  };
  if (has(0, "\x89PNG")) return "image/png";
  if (has(0, "\xff\xd8\xff")) return "image/jpeg";
  if (has(0, "RIFF") && has(8, "WEBP")) return "image/webp";
  if (has(0, "\xabKTX 20\xbb")) return "image/ktx2";
  return "";
}

}  // namespace fascicle::gltf
