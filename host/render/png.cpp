#include "host/render/png.h"

#include <stdexcept>

#include <png.h>

namespace fascicle::render {

namespace {

std::string encoded(unsigned width, unsigned height, png_uint_32 format, const std::uint8_t* pixels) {
  // The simplified interface reports errors by value: no longjmp through C++ frames.
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = width;
  png.height = height;
  png.format = format;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, 0, nullptr) == 0)
    throw std::runtime_error(std::string("the picture cannot be written as PNG: ") + png.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::string encode_png(const Image& image) {
  return encoded(image.width, image.height, PNG_FORMAT_RGB, image.pixels.data());
}

std::string encode_png(const Texels& texels) {
  return encoded(texels.width, texels.height, PNG_FORMAT_RGBA, texels.values.data());
}

}  // namespace fascicle::render
