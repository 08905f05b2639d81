#include "host/gltf/gltf_shapes.h"

#include <algorithm>

#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_limits.h"

namespace fascicle::gltf {
namespace {

constexpr std::size_t most_target_positions = std::size_t{1} << 27;
// A moved position has at least 3 bytes in the file and 28 in memory. Two for each byte let every target
// appear on six nodes.
constexpr std::size_t moved_of_any_file = std::size_t{1} << 20, moved_a_byte = 2;

}  // namespace

ShapeLimits::ShapeLimits(const tinygltf::Model& model) : most_positions(most_target_positions) {
  most_moved = std::min(most_target_positions, moved_of_any_file + moved_a_byte * measured_bytes(model));
}

std::vector<rig::BlendShape> read_shapes(const std::filesystem::path& path, const tinygltf::Model& model,
                                         const tinygltf::Primitive& primitive, const std::string& pointer,
                                         std::size_t count, ShapeLimits& limits) {
  std::vector<rig::BlendShape> shapes(primitive.targets.size());
  if (count > 0 && shapes.size() > (limits.most_positions - limits.positions) / count)
    gltf_error(path, pointer + "/targets",
               "the morph targets have more than " + std::to_string(limits.most_positions) +
                   " positions in all; export fewer");
  limits.positions += shapes.size() * count;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const auto found = primitive.targets[k].find("POSITION");
    if (found == primitive.targets[k].end()) continue;
    const std::vector<double> moves = accessor_numbers(path, model, found->second);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3d move(moves[3 * i], moves[3 * i + 1], moves[3 * i + 2]);
      if (move.isZero(0.0)) continue;
      if (++limits.moved > limits.most_moved)
        gltf_error(
            path, pointer + "/targets/" + std::to_string(k),
            "more than " + std::to_string(limits.most_moved) +
                " moved positions of morph targets in all, the most that are read of a file of this size; "
                "export each target once");
      shapes[k].vertex.push_back(static_cast<std::uint32_t>(i));
      shapes[k].move.push_back(move);
    }
  }
  return shapes;
}

std::vector<double> rest_weights(const nlohmann::json& document, std::size_t node, std::size_t mesh,
                                 std::size_t shapes) {
  for (const auto* owner : {&document["nodes"][node], &document["meshes"][mesh]}) {
    const auto found = owner->find("weights");
    if (found != owner->end() && found->size() == shapes) return found->get<std::vector<double>>();
  }
  return std::vector<double>(shapes, 0.0);
}

void add_shapes(const std::vector<rig::BlendShape>& shapes, const std::vector<double>& weights,
                std::vector<Vector3d>& positions) {
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (weights[k] == 0.0) continue;
    for (std::size_t m = 0; m < shapes[k].vertex.size(); ++m)
      positions[shapes[k].vertex[m]] += weights[k] * shapes[k].move[m];
  }
}

}  // namespace fascicle::gltf
