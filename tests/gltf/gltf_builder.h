// Builds small glTF files: a document with one buffer that grows with each accessor.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace fascicle::tests {

class GltfBuilder {
 public:
  nlohmann::json document;
  std::vector<unsigned char> bytes;

  // Adds an accessor over packed numbers; T gives the component type. Returns its index.
  template <typename T>
  std::size_t add(const std::string& type, const std::vector<T>& numbers,
                  nlohmann::json more = nlohmann::json::object());
  // Adds a view over raw bytes.
  template <typename T>
  std::size_t add_view(const std::vector<T>& numbers);

  // The document with the buffer as a data: URI, as a separate file, or inside a GLB.
  nlohmann::json with_data_uri() const;
  std::vector<unsigned char> glb() const;
};

// A column, half a metre wide and two high, of 12 vertices on 3 levels, open at its ends. Node 0 "armature"
// holds joints 1 "lower", at the origin, and 2 "upper", a metre above; node 3 holds the mesh. The bottom
// follows the lower joint, the top the upper one, the middle both. Raw units are centimetres with Z up, which
// the inverse bind matrices convert. Clip "bend" rotates the upper joint about z by 90 degrees in a second,
// clip "lift" moves the lower one up by 2 m.
GltfBuilder column();

// The column with two blend shapes that clip "bend" moves: the first moves two vertices of the top; the
// second, sparse, one of the bottom and one of the top. The mesh rests at weights 0.25 and 1.
GltfBuilder column_with_shapes();

// A new folder in the system's temporary folder, removed with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const std::string& text) const;
  std::filesystem::path write(const std::string& name, const std::vector<unsigned char>& bytes) const;

 private:
  std::filesystem::path path_;
};

std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace fascicle::tests
