#include "tests/formats/baked_character.h"

#include <string>
#include <variant>
#include <vector>

#include "host/formats/character_file.h"
#include "host/gltf/gltf.h"

namespace fascicle::tests {

Baked::Baked(const GltfBuilder& file, double scale) {
  const std::filesystem::path path = folder.write("source.glb", file.glb());
  scene.geometry = gltf::read_gltf(path);
  scene.input_hashes.emplace_back(path.string(), "");
  scene.scale = scale;
  scene.fps = baked_fps;
  scene.start = 0.25;
  scene.end = 1.0;
  const auto& of = std::get<rig::Character>(scene.geometry);
  model.unit = 4.0;
  model.joint_count = static_cast<std::uint32_t>(of.skeleton.size());
  model.surface_vertex.assign(4 * of.surface.vertices.size(), 0);
  std::vector<std::string> missing;
  character = folder.write("character.glb",
                           formats::character_glb(
                               scene, model, [this](std::uint64_t frame) { return time(frame); }, missing));
}

double Baked::time(std::uint64_t frame) const {
  return scene.start + static_cast<double>(frame) / scene.fps;
}

}  // namespace fascicle::tests
