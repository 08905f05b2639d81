// Materials, and where their textures lie.
#include "host/gltf/gltf_material.h"

#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/gltf/gltf_images.h"
#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests::gltf_material_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;

// A few operations on numbers near 1.
constexpr double rounding = 1e-14;

const json with_a_texture = json::parse(R"({"textures": [{"source": 0}]})");

// As a file would have it: its indices are unsigned.
gltf::Material read_text_of(const json& material) {
  return gltf::read_material(with_a_texture, json::parse(material.dump()));
}

// A material with this use of texture 0 of 1.
gltf::Material textured(const json& use) {
  return read_text_of({{"pbrMetallicRoughness", {{"baseColorTexture", use}}}});
}

Vector2d placed(const json& transform, const Vector2d& uv) {
  const gltf::Material material =
      textured({{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}});
  return material.texture.value().transform * Vector3d(uv[0], uv[1], 1.0);
}

TEST(GltfMaterial, HasGltfsDefaults) {
  const gltf::Material material = gltf::read_material(json::object(), json::object());
  EXPECT_EQ(material.name, "");
  EXPECT_EQ(material.base_colour, Eigen::Vector4d::Ones());
  EXPECT_EQ(material.metallic, 1.0);
  EXPECT_EQ(material.roughness, 1.0);
  EXPECT_EQ(material.emission, Vector3d::Zero());
  EXPECT_EQ(material.alpha_mode, gltf::AlphaMode::opaque);
  EXPECT_FALSE(material.double_sided || material.specular || material.texture);
  EXPECT_EQ(textured({{"index", 0}}).texture.value().transform, gltf::TextureUse().transform);
}

// The extension's own examples: the lower left quarter of the image, turned a quarter clockwise; and v upside
// down.
TEST(GltfMaterial, MovesTextureCoordinates) {
  const json quarter{{"offset", {0, 1}}, {"rotation", std::numbers::pi / 2}, {"scale", {0.5, 0.5}}};
  // v points down: the quarter has u from 0 to 0.5 and v from 0.5 to 1.
  EXPECT_LT((placed(quarter, {0, 0}) - Vector2d(0, 1)).norm(), rounding);
  EXPECT_LT((placed(quarter, {1, 0}) - Vector2d(0, 0.5)).norm(), rounding);
  EXPECT_LT((placed(quarter, {0, 1}) - Vector2d(0.5, 1)).norm(), rounding);
  const json flipped{{"offset", {0, 1}}, {"scale", {1, -1}}};
  EXPECT_LT((placed(flipped, {0.25, 0.125}) - Vector2d(0.25, 0.875)).norm(), rounding);
  // The scale comes before the rotation.
  const json uneven{{"rotation", std::numbers::pi / 2}, {"scale", {2, 3}}};
  EXPECT_LT((placed(uneven, {1, 0}) - Vector2d(0, -2)).norm(), rounding);
  EXPECT_LT((placed(uneven, {0, 1}) - Vector2d(3, 0)).norm(), rounding);
}

TEST(GltfMaterial, TakesTheSetOfTheTransform) {
  EXPECT_EQ(textured({{"index", 0}, {"texCoord", 2}}).texture.value().uv_set, 2u);
  const json transform{{"KHR_texture_transform", {{"texCoord", 1}}}};
  EXPECT_EQ(textured({{"index", 0}, {"texCoord", 2}, {"extensions", transform}}).texture.value().uv_set, 1u);
}

TEST(GltfMaterial, ReadsSpecularGlossiness) {
  const json of{{"diffuseFactor", {0.5, 0.25, 0.125, 0.75}},
                {"glossinessFactor", 0.25},
                {"specularFactor", {0.5, 0.5, 0}},
                {"diffuseTexture", {{"index", 0}}}};
  const gltf::Material material =
      read_text_of({{"extensions", {{"KHR_materials_pbrSpecularGlossiness", of}}},
                    {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 1}}}});
  EXPECT_EQ(material.base_colour, Eigen::Vector4d(0.5, 0.25, 0.125, 0.75));
  EXPECT_EQ(material.metallic, 0.0);
  EXPECT_EQ(material.roughness, 0.75);
  EXPECT_EQ(material.specular.value(), Vector3d(0.5, 0.5, 0));
  EXPECT_TRUE(material.texture);
}

TEST(GltfMaterial, FaultsCountAsAbsent) {
  const json wrong =
      json::parse(R"({"name": 3, "alphaMode": 7, "alphaCutoff": "x", "emissiveFactor": [1, "a", {}],
      "doubleSided": "yes", "extensions": [], "pbrMetallicRoughness": {"baseColorFactor": [null, 9, -1],
      "metallicFactor": [], "roughnessFactor": 7, "baseColorTexture": {"index": -1, "texCoord": -2}}})");
  const gltf::Material material = gltf::read_material(json::object(), wrong);
  EXPECT_EQ(material.base_colour, Eigen::Vector4d(1, 1, 0, 1));
  EXPECT_EQ(material.emission, Vector3d(1, 0, 0));
  EXPECT_EQ(material.metallic, 1.0);
  EXPECT_EQ(material.roughness, 1.0);
  EXPECT_EQ(material.alpha_cutoff, 0.5);
  EXPECT_FALSE(material.double_sided || material.texture);
  EXPECT_FALSE(textured({{"index", 1}}).texture) << "there is only texture 0";
}

// Both are read from the file; between the two reads it may be replaced.
TEST(GltfMaterial, LooksOfAFileThatChangedAreRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("column.glb", column().glb());
  const gltf::Rig rig = gltf::read_rig(path);
  EXPECT_NO_THROW(gltf::read_looks(path, rig));
  gltf::Rig other = rig;
  other.parts[0].primitive = 1;
  EXPECT_THROW(gltf::read_looks(path, other), base::SceneError);
  other = rig;
  other.parts[0].mesh = 7;
  EXPECT_THROW(gltf::read_looks(path, other), base::SceneError);
}

// The rig's coordinates are those of the texture: its own set, moved.
TEST(GltfMaterial, TheRigHasTheTexturesCoordinates) {
  GltfBuilder b = column();
  std::vector<float> first, second;
  for (int i = 0; i < 12; ++i) {
    first.insert(first.end(), {0.25f, 0.5f});
    second.insert(second.end(), {static_cast<float>(i) / 16.0f, 0.125f});
  }
  json& primitive = b.document["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] = b.add("VEC2", first);
  primitive["attributes"]["TEXCOORD_1"] = b.add("VEC2", second);
  primitive["material"] = 0;
  const std::vector<unsigned char> picture{0x89, 'P', 'N', 'G', 1, 2, 3};
  b.document["images"] = {{{"bufferView", b.add_view(picture)}, {"mimeType", "image/png"}}};
  b.document["textures"] = {{{"source", 0}}};
  json use{{"index", 0}};
  const auto read = [&] {
    b.document["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", use}}}}};
    const TemporaryFolder folder;
    const std::filesystem::path path = folder.write("textured.glb", b.glb());
    const gltf::Rig rig = gltf::read_rig(path);
    EXPECT_EQ(gltf::read_looks(path, rig).parts.at(0).uvs, rig.parts.at(0).uvs);
    return rig.parts.at(0).uvs;
  };
  EXPECT_EQ(read().at(4), Vector2d(0.25, 0.5));
  use["texCoord"] = 1;
  EXPECT_EQ(read().at(4), Vector2d(0.25, 0.125));
  use["extensions"] = {{"KHR_texture_transform", {{"offset", {0.5, 0}}, {"scale", {2, 4}}}}};
  EXPECT_EQ(read().at(4), Vector2d(1.0, 0.5));
  use["texCoord"] = 2;
  EXPECT_TRUE(read().empty()) << "the mesh has no such set";
}

TEST(GltfImages, AreKnownByTheirFirstBytes) {
  const auto type = [](const std::string& bytes) {
    return gltf::media_type_of(std::vector<unsigned char>(bytes.begin(), bytes.end()));
  };
  EXPECT_EQ(type("\x89PNG\r\n"), "image/png");
  EXPECT_EQ(type("\xff\xd8\xff\xe0"), "image/jpeg");
  EXPECT_EQ(type(std::string("RIFF\x10\0\0\0WEBPVP8 ", 16)), "image/webp");
  EXPECT_EQ(type("\xabKTX 20\xbb\r\n"), "image/ktx2");
  for (const char* other : {"", "RIFF", "RIFFxxxxWAVE", "GIF89a", "\xff\xd8"})
    EXPECT_EQ(type(other), "") << other;
}

// Pictures in data: URIs and beside the file come into the packed file, each with its own type.
TEST(GltfImages, ArePackedWithTheirType) {
  const TemporaryFolder folder;
  const std::string webp = std::string("RIFF\x10\0\0\0WEBPVP8 ", 16);
  folder.write("hat.webp", webp);
  GltfBuilder b = column();
  json document = b.with_data_uri();
  const std::string png = "\x89PNG1234";
  document["images"] = {
      {{"uri", "data:image/png;base64," + base64(std::vector<unsigned char>(png.begin(), png.end()))}},
      {{"uri", "hat.webp"}},
      {{"uri", "data:image/png,not base64"}}};
  std::vector<std::string> missing;
  const gltf::GltfDocument packed = gltf::pack_gltf(folder.write("a.gltf", document.dump()), missing);
  EXPECT_TRUE(missing.empty());
  const auto bytes_of = [&](const json& image) {
    const json& view = packed.json["bufferViews"][image["bufferView"].get<std::size_t>()];
    return packed.binary.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
  };
  const json& images = packed.json["images"];
  EXPECT_EQ(images[0]["mimeType"], "image/png");
  EXPECT_EQ(bytes_of(images[0]), png);
  EXPECT_FALSE(images[0].contains("uri"));
  EXPECT_EQ(images[1]["mimeType"], "image/webp");
  EXPECT_EQ(bytes_of(images[1]), webp);
  EXPECT_FALSE(images[2].contains("bufferView")) << "what cannot be decoded stays as it is";
}

}  // namespace
}  // namespace fascicle::tests::gltf_material_test
