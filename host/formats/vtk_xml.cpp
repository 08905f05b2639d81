#include "host/formats/vtk_xml.h"

#include <algorithm>
#include <stdexcept>

#include <zlib.h>

#include "host/base/part_file.h"
#include "host/base/text.h"

namespace fascicle::formats {

namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 20;
// Floats compress poorly at any level; the first is the fastest.
constexpr int compression_level = 1;

}  // namespace

std::string vtk_compressed(std::string_view bytes) {
  const std::uint64_t blocks = (bytes.size() + block_bytes - 1) / block_bytes;
  std::string head, body;
  base::append_bytes(head, blocks);
  base::append_bytes(head, std::uint64_t{block_bytes});
  base::append_bytes(head, std::uint64_t{bytes.size() % block_bytes});
  for (std::uint64_t k = 0; k < blocks; ++k) {
    const std::string_view block = bytes.substr(static_cast<std::size_t>(k) * block_bytes, block_bytes);
    uLongf size = compressBound(static_cast<uLong>(block.size()));
    std::string packed(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                  reinterpret_cast<const Bytef*>(block.data()), static_cast<uLong>(block.size()),
                  compression_level) != Z_OK)
      throw std::runtime_error("zlib could not compress an array");
    base::append_bytes(head, std::uint64_t{size});
    body.append(packed, 0, size);
  }
  return head + body;
}

std::uint64_t vtk_compressed_bound(std::uint64_t bytes) {
  // zlib adds five bytes per 16 KiB of incompressible data, and six per block.
  const std::uint64_t blocks = (bytes + block_bytes - 1) / block_bytes;
  return bytes + bytes / 1000 + 24 + blocks * 32;
}

std::string VtkArrays::add(const std::string& type, const std::string& name, std::size_t components,
                           std::string_view compressed) {
  const std::string tag = "        <DataArray type=\"" + type + "\" Name=\"" + name +
                          "\" NumberOfComponents=\"" + base::number_text(std::uint64_t{components}) +
                          "\" format=\"appended\" offset=\"" +
                          base::number_text(std::uint64_t{data_.size()}) + "\"/>\n";
  data_ += compressed;
  return tag;
}

std::string VtkArrays::file(const std::string& kind, const std::string& pieces) const {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + kind +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
         "compressor=\"vtkZLibDataCompressor\">\n  <" +
         kind + ">\n" + pieces + "  </" + kind + ">\n  <AppendedData encoding=\"raw\">\n_" + data_ +
         "\n  </AppendedData>\n</VTKFile>\n";
}

std::string vtk_field_data(double time, std::span<const VtkNames> names) {
  std::string text =
      "    <FieldData>\n"
      "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">" +
      base::number_text(time) + "</DataArray>\n";
  for (const VtkNames& list : names) {
    if (list.values.empty()) continue;
    text += "      <Array type=\"String\" Name=\"" + list.name + "\" NumberOfTuples=\"" +
            base::number_text(std::uint64_t{list.values.size()}) + "\" format=\"ascii\">";
    // The bytes of each name as numbers, then a 0.
    for (const std::string& value : list.values) {
      for (const char c : value)
        text += base::number_text(std::uint32_t{static_cast<unsigned char>(c)}) + ' ';
      text += "0 ";
    }
    text += "</Array>\n";
  }
  return text + "    </FieldData>\n";
}

VtkFrames::VtkFrames(const BakeInfo& info, const std::string& extension)
    : start_(info.start),
      fps_(info.fps),
      frames_(info.frames),
      extension_(extension),
      files_(info.folder, extension, info.first, info.first_number) {}

double VtkFrames::time_of(std::uint64_t frame) const {
  return start_ + static_cast<double>(frame) / fps_;
}

void VtkFrames::finish() {
  files_.sync();
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  "
      "<Collection>\n";
  for (std::uint64_t k = 0; k <= frames_; ++k)
    text += "    <DataSet timestep=\"" + base::number_text(time_of(k)) + "\" file=\"" +
            frame_file_name(files_.number_of(k), extension_) + "\"/>\n";
  base::write_whole(files_.folder() / vtk_series, text + "  </Collection>\n</VTKFile>\n");
}

}  // namespace fascicle::formats
