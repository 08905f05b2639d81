#include "host/gltf/gltf_limits.h"

#include <algorithm>

#include "host/gltf/gltf_attributes.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_library.h"

namespace fascicle::gltf {

namespace {

// Upper bounds, far above any character. The bound also scales with the file's size, because a small file may
// name one accessor many times: a vertex with joints and weights has at least 16 bytes, so bytes / 2 lets
// each mesh appear eight times.
constexpr std::size_t most_vertices = std::size_t{1} << 24, vertices_of_any_file = std::size_t{1} << 20;
// The rest is bounded by the vertices. Parts have few bytes in the file and many in memory.
constexpr std::size_t vertices_a_part = 8;
constexpr std::size_t corners_a_vertex = 6;         // two triangles
constexpr std::size_t influence_sets_a_vertex = 2;  // eight joints
// A rig has the matrices of a part's skin once for each part, and so its morph targets.
constexpr std::size_t bind_matrices_a_vertex = 1, targets_a_vertex = 1;

// Channels may share their keys, as exporters do for those that stand still; a number of its own takes a byte
// or more.
constexpr std::size_t most_key_numbers = std::size_t{1} << 26, keys_of_any_file = std::size_t{1} << 20;
constexpr std::size_t keys_a_byte = 16;  // as many as an accessor without bytes may have

}  // namespace

std::size_t stored_bytes(const tinygltf::Model& model) {
  std::size_t bytes = 0;
  for (const tinygltf::Buffer& buffer : model.buffers)
    if (buffer.name.empty()) bytes += buffer.data.size();
  return bytes;
}

std::size_t measured_bytes(const tinygltf::Model& model) {
  std::size_t bytes = 0;
  for (const tinygltf::Buffer& buffer : model.buffers) bytes += buffer.data.size();
  return std::min(bytes, 4 * stored_bytes(model));
}

PartLimits::PartLimits(const std::filesystem::path& path, const tinygltf::Model& model)
    : path_(path), model_(model) {
  most_vertices_ = std::min(most_vertices, vertices_of_any_file + measured_bytes(model) / 2);
}

void PartLimits::count(std::size_t& sum, std::size_t more, std::size_t most, const std::string& what,
                       const std::string& pointer) const {
  sum += more;
  if (sum <= most) return;
  gltf_error(path_, pointer,
             "more than " + std::to_string(most) + " " + what +
                 " in all, the most that are read of a file of this size; export each mesh once, and each "
                 "material with its own vertices");
}

void PartLimits::add(const GltfPart& part) {
  const tinygltf::Primitive& primitive = model_.meshes[part.mesh].primitives[part.primitive];
  const auto length_of = [&](int accessor) {
    return model_.accessors[static_cast<std::size_t>(accessor)].count;
  };
  const std::string pointer =
      "/meshes/" + std::to_string(part.mesh) + "/primitives/" + std::to_string(part.primitive);
  count(parts_, 1, most_vertices_ / vertices_a_part, "parts", pointer);
  const int position = attribute_accessor(primitive, "POSITION");
  if (position < 0) return;  // its reader says what is wrong
  const std::size_t vertices = length_of(position);
  count(vertices_, vertices, most_vertices_, "vertices", pointer + "/attributes/POSITION");
  count(corners_, primitive.indices < 0 ? vertices : length_of(primitive.indices),
        corners_a_vertex * most_vertices_, "corners of triangles", pointer);
  // read_shapes bounds their positions.
  count(targets_, primitive.targets.size(), targets_a_vertex * most_vertices_, "morph targets",
        pointer + "/targets");
  if (part.skin < 0) return;
  for (int set = 0;; ++set) {
    const std::string name = "JOINTS_" + std::to_string(set);
    if (attribute_accessor(primitive, name) < 0) break;
    count(influence_sets_, vertices, influence_sets_a_vertex * most_vertices_, "sets of joints and weights",
          pointer + "/attributes/" + name);
  }
  const tinygltf::Skin& skin = model_.skins[static_cast<std::size_t>(part.skin)];
  const std::size_t given = skin.inverseBindMatrices < 0 ? 0 : length_of(skin.inverseBindMatrices);
  count(bind_matrices_, std::max(given, skin.joints.size()), bind_matrices_a_vertex * most_vertices_,
        "inverse bind matrices", pointer);
}

KeyLimits::KeyLimits(const std::filesystem::path& path, const tinygltf::Model& model)
    : path_(path),
      model_(model),
      most_(std::min(most_key_numbers, keys_of_any_file + keys_a_byte * measured_bytes(model))) {}

void KeyLimits::add(std::size_t animation, int accessor) {
  const tinygltf::Accessor& a = model_.accessors[static_cast<std::size_t>(accessor)];
  numbers_ += a.count *
              static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type)));
  if (numbers_ > most_)
    gltf_error(path_, "/animations/" + std::to_string(animation),
               "more than " + std::to_string(most_) +
                   " numbers of clips in all, the most that are read of a file of this size; export fewer");
}

}  // namespace fascicle::gltf
