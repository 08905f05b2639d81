#include <cstddef>
#include <string>
#include <string_view>

#include <zlib.h>

#include "host/render/decode_image.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

bool picture_as_it_is(std::string_view bytes) {
  const render::DecodedImage image =
      render::decode_image({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  if (!image.flaw.empty()) check_message(image.flaw);
  return image.flaw.empty();
}

// A PNG with a correct checksum for each of its chunks (length, type, data, CRC of type and data), up to the
// first that is cut off.
std::string sealed_png(std::string_view bytes) {
  constexpr std::size_t signature_bytes = 8, around_data = 12;
  std::string whole(bytes);
  auto* const at = reinterpret_cast<unsigned char*>(whole.data());
  const auto number = [&](std::size_t k) {
    return std::size_t{at[k]} << 24 | std::size_t{at[k + 1]} << 16 | std::size_t{at[k + 2]} << 8 | at[k + 3];
  };
  for (std::size_t chunk = signature_bytes; chunk + around_data <= whole.size();) {
    const std::size_t length = number(chunk);
    if (length > whole.size() - chunk - around_data) break;
    const unsigned long crc = crc32(0, at + chunk + 4, static_cast<uInt>(length + 4));
    for (std::size_t k = 0; k < 4; ++k)
      at[chunk + 8 + length + k] = static_cast<unsigned char>(crc >> (24 - 8 * k));
    chunk += around_data + length;
  }
  return whole;
}

}  // namespace

bool picture(std::string_view bytes) {
  const bool is_whole = picture_as_it_is(bytes);
  if (!bytes.starts_with("\x89PNG")) return is_whole;
  const std::string whole = sealed_png(bytes);
  return whole == bytes ? is_whole : picture_as_it_is(whole);
}

}  // namespace fascicle::fuzz
