// A primitive's triangles, whether it has a list, a strip or a fan of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
struct Primitive;
}  // namespace tinygltf

namespace fascicle::gltf {

// As indices into the primitive's own `count` vertices; degenerate triangles that only join strips are left
// out. `pointer`: JSON pointer to the primitive, for messages. Throws SceneError.
std::vector<std::array<std::uint32_t, 3>> read_triangles(const std::filesystem::path& path,
                                                         const tinygltf::Model& model,
                                                         const tinygltf::Primitive& primitive,
                                                         const std::string& pointer, std::size_t count);

}  // namespace fascicle::gltf
