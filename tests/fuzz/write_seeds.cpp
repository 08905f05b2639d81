// fuzz_seeds FOLDER: writes the seeds, one folder per reader.
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/fuzz/readers.h"

int main(int count, char** arguments) try {
  if (count != 2) {
    std::cerr << "fuzz_seeds: takes a folder\n";
    return 2;
  }
  for (const fascicle::fuzz::Seed& seed : fascicle::fuzz::seeds()) {
    const std::filesystem::path folder = std::filesystem::path(arguments[1]) / seed.reader;
    std::filesystem::create_directories(folder);
    std::ofstream file(folder / seed.name, std::ios::binary);
    file.write(seed.bytes.data(), static_cast<std::streamsize>(seed.bytes.size()));
    if (!file.flush()) throw std::runtime_error(folder.string() + ": cannot be written");
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << "fuzz_seeds: " << error.what() << '\n';
  return 1;
}
