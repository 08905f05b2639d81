#include "host/render/png.h"

#include <stdexcept>

#include <png.h>

namespace fascicle::render {

std::string encode_png(const Image& image) {
  // The simplified interface reports errors by value: no longjmp through C++ frames.
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr) == 0)
    throw std::runtime_error(std::string("the picture cannot be written as PNG: ") + png.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace fascicle::render
