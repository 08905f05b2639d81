#include "host/render/jpeg.h"

#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include <jpeglib.h>

namespace fascicle::render {
namespace {

// libjpeg reports errors by longjmp: between setjmp and the call nothing may need a destructor.
struct JpegWriter {
  jpeg_error_mgr errors{};  // first, so that a pointer to it is also a pointer to this struct
  std::jmp_buf leave{};
  jpeg_compress_struct jpeg{};
  unsigned char* bytes = nullptr;  // allocated by malloc
  unsigned long size = 0;
};

[[noreturn]] void leave_writer(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<JpegWriter*>(jpeg->err)->leave, 1);
}

bool write_jpeg(JpegWriter& writer, const Texels& texels, int quality, std::uint8_t* row) {
  writer.jpeg.err = jpeg_std_error(&writer.errors);
  writer.errors.error_exit = leave_writer;
  if (setjmp(writer.leave) != 0) return false;
  jpeg_create_compress(&writer.jpeg);
  jpeg_mem_dest(&writer.jpeg, &writer.bytes, &writer.size);
  writer.jpeg.image_width = texels.width;
  writer.jpeg.image_height = texels.height;
  writer.jpeg.input_components = 3;
  writer.jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&writer.jpeg);
  jpeg_set_quality(&writer.jpeg, quality, TRUE);
  jpeg_start_compress(&writer.jpeg, TRUE);
  for (std::size_t y = 0; y < texels.height; ++y) {
    for (std::size_t x = 0; x < texels.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) row[3 * x + c] = texels.values[4 * (y * texels.width + x) + c];
    JSAMPROW line = row;
    jpeg_write_scanlines(&writer.jpeg, &line, 1);
  }
  jpeg_finish_compress(&writer.jpeg);
  return true;
}

}  // namespace

std::string encode_jpeg(const Texels& texels, int quality) {
  JpegWriter writer;
  std::vector<std::uint8_t> row(std::size_t{3} * texels.width);
  const bool is_written = write_jpeg(writer, texels, quality, row.data());
  jpeg_destroy_compress(&writer.jpeg);
  std::string bytes;
  if (is_written) bytes.assign(reinterpret_cast<const char*>(writer.bytes), writer.size);
  std::free(writer.bytes);
  if (!is_written) throw std::runtime_error("the picture cannot be written as JPEG");
  return bytes;
}

}  // namespace fascicle::render
