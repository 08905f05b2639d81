// PNG by libpng.
#pragma once

#include <string>

#include "host/render/image.h"
#include "host/render/looks.h"

namespace fascicle::render {

// The image as the bytes of a PNG file: 8 bits a channel, tagged as sRGB. Throws std::runtime_error.
std::string encode_png(const Image& image);
// The same for a texture, with its alpha.
std::string encode_png(const Texels& texels);

}  // namespace fascicle::render
