#include "host/render/decode_image.h"

#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>
#include <vector>

#include <jpeglib.h>
#include <png.h>

namespace fascicle::render {
namespace {

std::string too_large(std::size_t width, std::size_t height) {
  return std::to_string(width) + " x " + std::to_string(height) +
         " is larger than supported; make it smaller";
}

bool fits(std::size_t width, std::size_t height) {
  return width > 0 && height > 0 && width <= most_texels / height;
}

// A short file must not cost much memory and time: a size that it cannot hold is refused. Neither bound can
// refuse a whole file. Deflate makes at most 258 bytes of 2 bits; a JPEG's Huffman code spends at least one
// bit on each block of 64 texels, which arithmetic coding need not.
constexpr std::size_t most_inflated_per_byte = 258 * 8 / 2, most_jpeg_texels_per_byte = 64 * 8;

std::string too_short(std::size_t width, std::size_t height, std::size_t bytes) {
  return "is cut off or damaged: " + std::to_string(bytes) + " bytes cannot hold " + std::to_string(width) +
         " x " + std::to_string(height);
}

// Bits of a texel as the header says, which libpng has checked (PNG specification, 11.2.2).
std::size_t png_bits(std::span<const unsigned char> bytes) {
  constexpr std::size_t depth_at = 24, colour_at = 25;
  const unsigned colour = bytes[colour_at];
  const std::size_t channels = colour == 2 ? 3 : colour == 4 ? 2 : colour == 6 ? 4 : 1;
  return channels * bytes[depth_at];
}

// Opens a PNG; returns why it cannot be read, with nothing left open, or an empty text.
std::string open_png(png_image& png, std::span<const unsigned char> bytes) {
  // The simplified interface reports errors by value.
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0)
    return std::string("is not a readable PNG: ") + png.message;
  std::string flaw;
  if (!fits(png.width, png.height)) {
    flaw = too_large(png.width, png.height);
  } else if (std::size_t{png.width} * png.height / 8 * png_bits(bytes) / most_inflated_per_byte >
             bytes.size()) {
    flaw = too_short(png.width, png.height, bytes.size());
  }
  if (!flaw.empty()) png_image_free(&png);
  return flaw;
}

DecodedImage decode_png(std::span<const unsigned char> bytes) {
  DecodedImage image;
  png_image png{};
  image.flaw = open_png(png, bytes);
  if (!image.flaw.empty()) return image;
  png.format = PNG_FORMAT_RGBA;
  Texels texels{png.width, png.height, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(png))};
  if (png_image_finish_read(&png, nullptr, texels.values.data(), 0, nullptr) == 0) {
    image.flaw = std::string("is a damaged PNG: ") + png.message;
    return image;
  }
  image.texels = std::move(texels);
  return image;
}

// libjpeg reports errors by longjmp: between setjmp and the call nothing may need a destructor.
struct JpegErrors {
  jpeg_error_mgr manager;  // first, so that a pointer to it is also a pointer to this struct
  std::jmp_buf leave;
  bool has_many_scans;
};

[[noreturn]] void leave_jpeg(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<JpegErrors*>(jpeg->err)->leave, 1);
}

// Decoding goes over the whole picture once per scan, so a file with very many scans could keep a reader busy
// for long.
constexpr std::size_t most_scans = 500, most_scanned_texels = 64 * most_texels;

void watch_scans(j_common_ptr jpeg) {
  if (jpeg->is_decompressor == 0) return;
  const auto& reader = *reinterpret_cast<j_decompress_ptr>(jpeg);
  const auto scans = static_cast<std::size_t>(reader.input_scan_number);
  if (scans > most_scans || scans * reader.image_width * reader.image_height > most_scanned_texels) {
    reinterpret_cast<JpegErrors*>(jpeg->err)->has_many_scans = true;
    leave_jpeg(jpeg);
  }
}

struct JpegReader {
  jpeg_decompress_struct jpeg{};
  JpegErrors errors{};
  jpeg_progress_mgr progress{};
  std::array<char, JMSG_LENGTH_MAX> message{};
};

// Decodes into `rgba`, 4 bytes a texel, which the caller allocates between the two steps. False on failure.
bool open_jpeg(JpegReader& reader, std::span<const unsigned char> bytes) {
  reader.jpeg.err = jpeg_std_error(&reader.errors.manager);
  reader.errors.manager.error_exit = leave_jpeg;
  reader.errors.manager.emit_message = [](j_common_ptr jpeg, int level) {
    if (level < 0) ++jpeg->err->num_warnings;
  };
  if (setjmp(reader.errors.leave) != 0) return false;
  jpeg_create_decompress(&reader.jpeg);
  reader.progress.progress_monitor = watch_scans;
  reader.jpeg.progress = &reader.progress;
  jpeg_mem_src(&reader.jpeg, bytes.data(), bytes.size());
  jpeg_read_header(&reader.jpeg, TRUE);
  reader.jpeg.out_color_space = JCS_EXT_RGBA;  // alpha is set to 255
  return true;
}

bool read_jpeg(JpegReader& reader, std::uint8_t* rgba) {
  if (setjmp(reader.errors.leave) != 0) return false;
  jpeg_start_decompress(&reader.jpeg);
  while (reader.jpeg.output_scanline < reader.jpeg.output_height) {
    JSAMPROW row = rgba + std::size_t{4} * reader.jpeg.output_width * reader.jpeg.output_scanline;
    jpeg_read_scanlines(&reader.jpeg, &row, 1);
  }
  jpeg_finish_decompress(&reader.jpeg);
  return true;
}

// Why a JPEG whose header was read, or was not, is refused.
std::string flaw_of_jpeg(JpegReader& reader, bool is_read, std::size_t bytes) {
  const std::size_t width = reader.jpeg.image_width, height = reader.jpeg.image_height;
  if (!is_read && reader.errors.has_many_scans)
    return "has too many scans for a picture of this size; save it as baseline JPEG";
  if (!is_read) {
    (*reader.errors.manager.format_message)(reinterpret_cast<j_common_ptr>(&reader.jpeg),
                                            reader.message.data());
    return std::string("is not a readable JPEG: ") + reader.message.data();
  }
  if (!fits(width, height)) return too_large(width, height);
  if (reader.jpeg.arith_code == 0 && width * height / most_jpeg_texels_per_byte > bytes)
    return too_short(width, height, bytes);
  return "";
}

DecodedImage decode_jpeg(std::span<const unsigned char> bytes) {
  DecodedImage image;
  JpegReader reader;
  Texels texels;
  image.flaw = flaw_of_jpeg(reader, open_jpeg(reader, bytes), bytes.size());
  if (image.flaw.empty()) {
    const unsigned width = reader.jpeg.image_width, height = reader.jpeg.image_height;
    texels = {width, height, std::vector<std::uint8_t>(std::size_t{4} * width * height)};
    image.flaw = flaw_of_jpeg(reader, read_jpeg(reader, texels.values.data()), bytes.size());
    if (image.flaw.empty()) {
      if (reader.errors.manager.num_warnings > 0)
        image.flaw = "is a damaged JPEG; what can be read of it is drawn";
      image.texels = std::move(texels);
    }
  }
  jpeg_destroy_decompress(&reader.jpeg);
  return image;
}

bool is_png(std::span<const unsigned char> bytes) {
  return bytes.size() > 8 && std::memcmp(bytes.data(), "\x89PNG\r\n\x1a\n", 8) == 0;
}

bool is_jpeg(std::span<const unsigned char> bytes) {
  return bytes.size() > 3 && std::memcmp(bytes.data(), "\xff\xd8\xff", 3) == 0;
}

constexpr const char* neither = "is neither PNG nor JPEG";

}  // namespace

ImageHeader image_header(std::span<const unsigned char> bytes) {
  ImageHeader header;
  if (is_png(bytes)) {
    png_image png{};
    header.flaw = open_png(png, bytes);
    if (!header.flaw.empty()) return header;
    header.width = png.width;
    header.height = png.height;
    header.type = "image/png";
    png_image_free(&png);
  } else if (is_jpeg(bytes)) {
    JpegReader reader;
    header.flaw = flaw_of_jpeg(reader, open_jpeg(reader, bytes), bytes.size());
    if (header.flaw.empty()) {
      header.width = reader.jpeg.image_width;
      header.height = reader.jpeg.image_height;
      header.type = "image/jpeg";
    }
    jpeg_destroy_decompress(&reader.jpeg);
  } else {
    header.flaw = neither;
  }
  return header;
}

DecodedImage decode_image(std::span<const unsigned char> bytes) {
  if (is_png(bytes)) return decode_png(bytes);
  if (is_jpeg(bytes)) return decode_jpeg(bytes);
  return {{}, neither};
}

}  // namespace fascicle::render
