// Pictures of strangers: PNG by libpng, JPEG by libjpeg, bounded before memory is taken.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "host/render/looks.h"

namespace fascicle::render {

// Larger ones are refused: 128 MiB once decoded.
inline constexpr std::size_t most_texels = std::size_t{1} << 25;

struct DecodedImage {
  Texels texels;     // empty where nothing could be read
  std::string flaw;  // for people: why it could not be read, or what is wrong with it; empty: nothing
};

// Told apart by their first bytes. Never throws but std::bad_alloc.
DecodedImage decode_image(std::span<const unsigned char> bytes);

}  // namespace fascicle::render
