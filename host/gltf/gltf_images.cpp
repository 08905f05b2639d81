#include "host/gltf/gltf_images.h"

#include "host/gltf/gltf_file.h"

namespace fascicle::gltf {

ImageBytes ImagesBeside::read(const std::string& pointer, const std::string& uri) {
  const std::filesystem::path file = gltf_buffer_file(gltf_, pointer, uri);
  if (const auto known = bytes_of_.find(file); known != bytes_of_.end()) return known->second;
  std::vector<unsigned char> bytes;
  if (bytes_left_ > 0) {
    std::vector<std::filesystem::path> ignored;
    bytes = read_gltf_buffer(gltf_, pointer, uri, ignored);
  }
  if (bytes_left_ == 0 || bytes.size() > bytes_left_) {
    bytes_left_ = 0;
    gltf_error(gltf_, pointer,
               "the images beside the file have more than " + std::to_string(most_bytes_) + " bytes in all");
  }
  bytes_left_ -= bytes.size();
  return bytes_of_[file] = std::make_shared<const std::vector<unsigned char>>(std::move(bytes));
}

}  // namespace fascicle::gltf
