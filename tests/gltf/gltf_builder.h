// Small glTF files made in the test: a document whose one buffer grows with each accessor.
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

  // An accessor over numbers laid one after the other; T settles the component type. Returns its number.
  template <typename T>
  std::size_t add(const std::string& type, const std::vector<T>& numbers,
                  nlohmann::json more = nlohmann::json::object());
  // A view over raw bytes.
  template <typename T>
  std::size_t add_view(const std::vector<T>& numbers);

  // The document with the buffer as a data: URI, as a file beside, or inside a GLB.
  nlohmann::json with_data_uri() const;
  std::vector<unsigned char> glb() const;
};

// A column, half a metre wide and two high, of 12 vertices on 3 levels, open at its ends. Node 0 "armature"
// holds joints 1 "lower", at the origin, and 2 "upper", a metre above; node 3 holds the mesh. The bottom
// follows the lower joint, the top the upper one, the middle both. Raw units are centimetres with Z up; the
// inverse bind matrices turn them round. Clip "bend" turns the upper joint about z by a quarter turn in a
// second, clip "lift" moves the lower one up by 2 m.
GltfBuilder column();

// The column with two blend shapes that clip "bend" moves: the first shifts two vertices of the top, the
// second, sparse, one of the bottom and one of the top. The mesh rests at weights 0.25 and 1.
GltfBuilder column_with_shapes();

// A fresh folder below the system's temporary one, removed with all it holds.
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
