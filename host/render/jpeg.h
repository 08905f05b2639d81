// JPEG by libjpeg.
#pragma once

#include <string>

#include "host/render/looks.h"

namespace fascicle::render {

// Encodes a texture without its alpha. `quality`: 1 to 100, as in libjpeg. Throws std::runtime_error.
std::string encode_jpeg(const Texels& texels, int quality);

}  // namespace fascicle::render
