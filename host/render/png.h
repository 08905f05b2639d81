// PNG by libpng.
#pragma once

#include <string>

#include "host/render/image.h"
#include "host/render/looks.h"

namespace fascicle::render {

// The image as a PNG file's bytes: 8 bits a channel, marked as sRGB. Throws std::runtime_error.
std::string encode_png(const Image& image);
// The same of a texture, with its alpha.
std::string encode_png(const Texels& texels);

}  // namespace fascicle::render
