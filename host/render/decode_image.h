// Untrusted pictures: PNG by libpng, JPEG by libjpeg, with sizes checked before memory is allocated.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "host/render/looks.h"

namespace fascicle::render {

// Larger ones are refused: 128 MiB once decoded.
inline constexpr std::size_t most_texels = std::size_t{1} << 25;

struct DecodedImage {
  Texels texels;     // empty if nothing could be read
  std::string flaw;  // for users: why it could not be read, or what is wrong with it; empty if nothing is
};

// What the header alone says, with the checks that need no more: 0 x 0 and a flaw if decode_image would
// refuse it.
struct ImageHeader {
  std::size_t width = 0, height = 0;
  const char* type = "";  // image/png or image/jpeg
  std::string flaw;
};
ImageHeader image_header(std::span<const unsigned char> bytes);

// Detects the format by the first bytes. Throws only std::bad_alloc.
DecodedImage decode_image(std::span<const unsigned char> bytes);

}  // namespace fascicle::render
