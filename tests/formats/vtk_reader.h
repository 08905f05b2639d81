// Reads VTK's XML files with compressed raw appended data, written from the format's description with only
// zlib.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace fascicle::tests {

struct VtkFile {
  std::string xml;                                        // up to the appended data
  std::map<std::string, std::string> arrays;              // bytes of the appended arrays, by name
  std::map<std::string, std::vector<std::string>> names;  // lists of names in the field data
};

// Throws std::runtime_error that names what is invalid.
VtkFile read_vtk(const std::filesystem::path& path);

}  // namespace fascicle::tests
