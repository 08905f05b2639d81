#include "tests/fuzz/one_file.h"

#include <fstream>
#include <stdexcept>

namespace fascicle::fuzz {
namespace {

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

}  // namespace

void OneFile::write(std::string_view bytes) const {
  write_file(path_, bytes);
}

void OneFile::write_beside(const std::string& name, std::string_view bytes) const {
  write_file(folder_.path() / name, bytes);
}

}  // namespace fascicle::fuzz
