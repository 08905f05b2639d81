// Reads VTK's XML files with compressed raw appended data, by the format's description and zlib alone.
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

// Throws std::runtime_error with what is out of place.
VtkFile read_vtk(const std::filesystem::path& path);

}  // namespace fascicle::tests
