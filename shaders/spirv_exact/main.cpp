// spirv_exact IN.spv OUT.spv
//   writes the exact form of a compiled shader; fails if devices could compute it differently.
// spirv_exact --embed NAME IN.spv OUT.cpp
//   writes the module as a C++ source that defines fascicle::shader::NAME_module().

#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "shaders/spirv_exact/exact.h"

namespace {

using fascicle::spirv_exact::Words;

Words read_words(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  const std::streamoff size = file.tellg();
  if (size < 0 || size % 4 != 0) throw std::runtime_error(path + ": not whole words");
  Words words(static_cast<std::size_t>(size) / 4);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(words.data()), size);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return words;
}

// Writes the output completely or not at all: an interrupted build must not leave a partial file with a new
// timestamp.
void write_whole(const std::string& path, const char* data, std::size_t size) {
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(data, static_cast<std::streamsize>(size));
  file.close();
  if (!file || std::rename(part.c_str(), path.c_str()) != 0)
    throw std::runtime_error(path + ": cannot be written");
}

int make_exact(const std::string& in, const std::string& out) {
  const Words exact = fascicle::spirv_exact::add_no_contraction(read_words(in));
  const std::vector<std::string> faults = fascicle::spirv_exact::lint(exact);
  for (const std::string& fault : faults) std::cerr << in << ": " << fault << '\n';
  if (!faults.empty()) return 1;
  write_whole(out, reinterpret_cast<const char*>(exact.data()), exact.size() * 4);
  return 0;
}

int embed(const std::string& name, const std::string& in, const std::string& out) {
  std::string text =
      "#include <cstdint>\n#include <span>\n\nnamespace fascicle::shader {\n\n"
      "std::span<const std::uint32_t> " +
      name + "_module();\n\nnamespace {\n\nconstexpr std::uint32_t words[] = {";
  char word[16];
  std::size_t column = 0;
  for (const std::uint32_t w : read_words(in)) {
    std::snprintf(word, sizeof word, "0x%08x,", w);
    text += column++ % 10 == 0 ? "\n    " : " ";
    text += word;
  }
  text += "\n};\n\n}  // namespace\n\nstd::span<const std::uint32_t> " + name +
          "_module() { return words; }\n\n}  // namespace fascicle::shader\n";
  write_whole(out, text.data(), text.size());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (arguments.size() == 2) return make_exact(arguments[0], arguments[1]);
    if (arguments.size() == 4 && arguments[0] == "--embed")
      return embed(arguments[1], arguments[2], arguments[3]);
    std::cerr << "usage: spirv_exact IN.spv OUT.spv | spirv_exact --embed NAME IN.spv OUT.cpp\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "spirv_exact: " << error.what() << '\n';
    return 1;
  }
}
