#include "host/gltf/gltf_shapes.h"

#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_library.h"

namespace fascicle::gltf {

std::vector<rig::BlendShape> read_shapes(const std::filesystem::path& path, const tinygltf::Model& model,
                                         const tinygltf::Primitive& primitive, const std::string& pointer,
                                         std::size_t count, std::size_t& left) {
  std::vector<rig::BlendShape> shapes(primitive.targets.size());
  if (count > 0 && shapes.size() > left / count)
    gltf_error(path, pointer + "/targets",
               "the morph targets have more than " + std::to_string(most_target_positions) +
                   " positions in all; export fewer");
  left -= shapes.size() * count;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const auto found = primitive.targets[k].find("POSITION");
    if (found == primitive.targets[k].end()) continue;
    const std::vector<double> moves = accessor_numbers(path, model, found->second);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3d move(moves[3 * i], moves[3 * i + 1], moves[3 * i + 2]);
      if (move.isZero(0.0)) continue;
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
