#include "host/page/base64.h"

#include <algorithm>
#include <cstdint>

namespace fascicle::page {

std::string base64(std::string_view bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - k);
    std::uint32_t bits = 0;
    for (std::size_t c = 0; c < count; ++c)
      bits |= std::uint32_t{static_cast<std::uint8_t>(bytes[k + c])} << (16 - 8 * c);
    for (std::size_t c = 0; c < 4; ++c) text += c <= count ? digits[bits >> (18 - 6 * c) & 63u] : '=';
  }
  return text;
}

}  // namespace fascicle::page
