#include "tests/formats/vtk_reader.h"

#include <cstdint>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include <zlib.h>

#include "tests/bake/fake_solver.h"

namespace fascicle::tests {

namespace {

std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t at = tag.find(" " + name + "=\"");
  if (at == std::string::npos) return "";
  const std::size_t from = at + name.size() + 3;
  return tag.substr(from, tag.find('"', from) - from);
}

std::uint64_t number_at(const std::string& text, std::size_t at) {
  std::uint64_t value = 0;
  if (at + sizeof value > text.size()) throw std::runtime_error("the file ends in an array's head");
  std::memcpy(&value, text.data() + at, sizeof value);
  return value;
}

// Decompresses the array at `at`, and advances `at` to its end.
std::string inflated(const std::string& text, std::size_t& at) {
  const std::uint64_t blocks = number_at(text, at), whole = number_at(text, at + 8),
                      last = number_at(text, at + 16);
  std::size_t data = at + 24 + 8 * blocks;
  std::string bytes;
  for (std::uint64_t k = 0; k < blocks; ++k) {
    const std::uint64_t packed = number_at(text, at + 24 + 8 * k);
    const std::uint64_t wanted = k + 1 == blocks && last != 0 ? last : whole;
    std::string block(wanted, '\0');
    uLongf size = wanted;
    if (data + packed > text.size() ||
        ::uncompress(reinterpret_cast<Bytef*>(block.data()), &size,
                     reinterpret_cast<const Bytef*>(text.data() + data), packed) != Z_OK ||
        size != wanted)
      throw std::runtime_error("a block does not hold what its head says");
    bytes += block;
    data += packed;
  }
  at = data;
  return bytes;
}

}  // namespace

VtkFile read_vtk(const std::filesystem::path& path) {
  VtkFile vtk;
  const std::string text = read_text(path);
  const std::string open = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t at = text.find(open);
  if (at == std::string::npos) throw std::runtime_error("no appended data");
  vtk.xml = text.substr(0, at);
  if (vtk.xml.find("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"") == std::string::npos)
    throw std::runtime_error("no compressor");
  const std::size_t data = at + open.size();
  std::size_t end = data;
  for (std::size_t from = 0; (from = vtk.xml.find("<DataArray", from)) != std::string::npos; ++from) {
    const std::string tag = vtk.xml.substr(from, vtk.xml.find('>', from) - from);
    if (attribute(tag, "format") != "appended") continue;
    std::size_t start = data + std::stoull(attribute(tag, "offset"));
    if (start != end) throw std::runtime_error("an array does not begin where the one before ends");
    vtk.arrays[attribute(tag, "Name")] = inflated(text, start);
    end = start;
  }
  if (text.substr(end) != "\n  </AppendedData>\n</VTKFile>\n")
    throw std::runtime_error("bytes behind the last array");
  for (std::size_t from = 0; (from = vtk.xml.find("<Array", from)) != std::string::npos; ++from) {
    const std::size_t close = vtk.xml.find('>', from);
    std::vector<std::string>& list = vtk.names[attribute(vtk.xml.substr(from, close - from), "Name")];
    std::istringstream values(vtk.xml.substr(close + 1, vtk.xml.find('<', close) - close - 1));
    std::string name;
    for (int value = 0; values >> value;) {
      if (value != 0) {
        name += static_cast<char>(value);
      } else {
        list.push_back(name);
        name.clear();
      }
    }
  }
  return vtk;
}

}  // namespace fascicle::tests
