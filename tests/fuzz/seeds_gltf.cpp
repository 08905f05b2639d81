#include <draco/compression/config/compression_shared.h>

#include "host/render/jpeg.h"
#include "host/render/looks.h"
#include "host/render/png.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/seeds.h"
#include "tests/gltf/compressed_builder.h"

namespace fascicle::fuzz {
namespace {

using tests::GltfBuilder;

std::string text_of(const std::vector<unsigned char>& bytes) {
  return {bytes.begin(), bytes.end()};
}

// A column with a painted attribute, a material and a texture.
GltfBuilder painted_column() {
  GltfBuilder b = tests::column_with_shapes();
  nlohmann::json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["attributes"]["_LAYER"] = b.add<float>("SCALAR", std::vector<float>(12, 1.0f));
  primitive["attributes"]["TEXCOORD_0"] = b.add<float>("VEC2", std::vector<float>(24, 0.5f));
  primitive["material"] = 0;
  b.document["materials"] = {{{"name", "skin"},
                              {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                              {"alphaMode", "MASK"}}};
  b.document["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 1}}};
  b.document["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
  primitive["attributes"]["NORMAL"] = b.add<float>("VEC3", std::vector<float>(36, 1.0f));
  const std::size_t image =
      b.add_view(std::vector<std::uint8_t>{0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a});
  b.document["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgo="}},
                          {{"bufferView", image}, {"mimeType", "image/png"}}};
  b.document["extensionsUsed"] = {"KHR_lights_punctual"};
  b.document["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  b.document["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  return b;
}

}  // namespace

void add_gltf_seeds(std::vector<Seed>& seeds) {
  seeds.push_back({"gltf", "column.glb", text_of(tests::column().glb())});
  seeds.push_back({"gltf", "column.gltf", tests::column().with_data_uri().dump()});
  seeds.push_back({"gltf", "shapes.glb", text_of(tests::column_with_shapes().glb())});
  seeds.push_back({"gltf", "painted.glb", text_of(painted_column().glb())});
  // Numbers in a text can be replaced by longer ones.
  seeds.push_back({"gltf", "shapes.gltf", tests::column_with_shapes().with_data_uri().dump()});
  seeds.push_back({"gltf", "painted.gltf", painted_column().with_data_uri().dump()});
  seeds.push_back({"gltf", "meshopt.gltf", tests::with_meshopt(tests::column()).dump()});
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
    seeds.push_back(
        {"gltf", "draco-" + std::to_string(method) + ".glb", text_of(tests::with_draco(method).glb())});
  // A character with a motion and looks is one for exports, too. A bake's own is neither compressed nor text.
  std::vector<Seed> characters, own;
  for (const Seed& seed : seeds) {
    if (seed.reader != "gltf") continue;
    characters.push_back(seed);
    if (seed.name == "column.glb" || seed.name == "shapes.glb" || seed.name == "painted.glb")
      own.push_back(seed);
  }
  for (unsigned way = 0; way < 3 * most_exports; ++way) {
    const std::vector<Seed>& of_way = way % 3 == 0 ? own : characters;
    const Seed& character = of_way[way / 3 % of_way.size()];
    seeds.push_back(
        {"exports", std::to_string(way) + "-" + character.name, static_cast<char>(way) + character.bytes});
  }
  render::Texels image{4, 3, {}};
  for (std::size_t k = 0; k < 48; ++k) image.values.push_back(static_cast<std::uint8_t>(17 * k));
  seeds.push_back({"picture", "png", render::encode_png(image)});
  seeds.push_back({"picture", "jpeg", render::encode_jpeg(image, 80)});
}

}  // namespace fascicle::fuzz
