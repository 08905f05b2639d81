#include "host/gltf/gltf_triangles.h"

#include <utility>

#include "host/gltf/gltf_attributes.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_library.h"

namespace fascicle::gltf {
namespace {

std::vector<std::uint32_t> read_corners(const std::filesystem::path& path, const tinygltf::Model& model,
                                        const tinygltf::Primitive& primitive, const std::string& pointer,
                                        std::size_t count) {
  std::vector<std::uint32_t> corners;
  if (primitive.indices < 0) {
    for (std::size_t i = 0; i < count; ++i) corners.push_back(static_cast<std::uint32_t>(i));
  } else {
    const int type = model.accessors[static_cast<std::size_t>(primitive.indices)].componentType;
    const bool is_index = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    for (const double corner : attribute_numbers(path, model, pointer + "/indices", primitive.indices,
                                                 TINYGLTF_TYPE_SCALAR, is_index, 0)) {
      if (corner >= static_cast<double>(count))
        gltf_error(path, pointer + "/indices",
                   "names vertex " + std::to_string(static_cast<std::uint64_t>(corner)) + " of " +
                       std::to_string(count) + ", counted from 0; export the mesh again");
      corners.push_back(static_cast<std::uint32_t>(corner));
    }
  }
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES && corners.size() % 3 != 0)
    gltf_error(path, pointer + (primitive.indices < 0 ? "/attributes/POSITION" : "/indices"),
               std::to_string(corners.size()) + " corners do not make whole triangles");
  return corners;
}

std::vector<std::array<std::uint32_t, 3>> expand(const std::vector<std::uint32_t>& corners, int mode) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    return triangles;
  }
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    std::array<std::uint32_t, 3> t{corners[mode == TINYGLTF_MODE_TRIANGLE_FAN ? 0 : i], corners[i + 1],
                                   corners[i + 2]};
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1) std::swap(t[1], t[2]);  // glTF 2.0, 3.7.2.1
    // Repeated corners join strips; skip those degenerate triangles.
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  return triangles;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> read_triangles(const std::filesystem::path& path,
                                                         const tinygltf::Model& model,
                                                         const tinygltf::Primitive& primitive,
                                                         const std::string& pointer, std::size_t count) {
  return expand(read_corners(path, model, primitive, pointer, count), primitive.mode);
}

}  // namespace fascicle::gltf
