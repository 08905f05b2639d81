// Where a glTF file's images are when they are not in its buffers: in files beside it, or in data: URIs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fascicle::gltf {

using ImageBytes = std::shared_ptr<const std::vector<unsigned char>>;

// Reads each file once, however many images name it.
class ImagesBeside {
 public:
  // `most_bytes`: of all files together.
  explicit ImagesBeside(std::filesystem::path gltf, std::uint64_t most_bytes = std::uint64_t{2} << 30)
      : gltf_(std::move(gltf)), most_bytes_(most_bytes), bytes_left_(most_bytes) {}

  // The contents of the file that `uri` names, never null. Images of one file get the same pointer. Throws
  // SceneError with `pointer` as read_gltf_buffer does, and for the file with which there are more than
  // most_bytes, and all others after it.
  ImageBytes read(const std::string& pointer, const std::string& uri);

 private:
  std::filesystem::path gltf_;
  std::uint64_t most_bytes_, bytes_left_;
  std::map<std::filesystem::path, ImageBytes> bytes_of_;
};

// The decoded contents of a data: URI; empty if it is not base64.
std::vector<unsigned char> data_uri_bytes(const std::string& uri);

// "image/png", "image/jpeg", "image/webp" or "image/ktx2", by the first bytes; empty for any other.
std::string media_type_of(const std::vector<unsigned char>& bytes);

}  // namespace fascicle::gltf
