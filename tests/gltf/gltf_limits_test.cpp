// Small files that would take gigabytes, because they name the same data again and again. The character and
// the rig must be refused alike: the rig of a bake's character.glb is read on its own.
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_document.h"
#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "tests/gltf/compressed_builder.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

template <class Read>
std::string refusal_by(const Read& read) {
  try {
    read();
  } catch (const base::SceneError& error) {
    return error.what();
  }
  return "was read";
}

// Expects the same refusal of both readers: more of `what`, at `place`.
void expect_too_many(const GltfBuilder& builder, const std::string& what, const std::string& place) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("many.glb", builder.glb());
  const std::string of_rig = refusal_by([&] { gltf::read_rig(path); });
  EXPECT_EQ(of_rig, refusal_by([&] { gltf::read_gltf(path); }));
  EXPECT_NE(of_rig.find(": " + place + ": more than "), std::string::npos) << of_rig;
  EXPECT_NE(of_rig.find(" " + what + " in all"), std::string::npos) << of_rig;
}

json& primitives_of(GltfBuilder& builder) {
  return builder.document["meshes"][0]["primitives"];
}

// Adds an accessor without bytes, which is read as zeros.
std::size_t add_zeros(GltfBuilder& builder, int component, const char* type, std::size_t count) {
  json& accessors = builder.document["accessors"];
  accessors.push_back({{"componentType", component}, {"type", type}, {"count", count}});
  return accessors.size() - 1;
}

TEST(GltfLimits, one_mesh_many_times) {
  const TemporaryFolder folder;
  GltfBuilder builder = column();
  const json one = primitives_of(builder)[0];
  primitives_of(builder) = json(std::size_t{8}, one);
  const std::filesystem::path path = folder.write("eight.glb", builder.glb());
  EXPECT_EQ(gltf::read_gltf(path).surface.vertices.size(), 8U * 12);
  EXPECT_EQ(gltf::read_rig(path).parts.size(), 8U);
  primitives_of(builder) = json(std::size_t{100'000}, one);
  // 2^20 vertices and one for two bytes, at 12 a primitive.
  const std::size_t most = (std::size_t{1} << 20) + builder.bytes.size() / 2;
  expect_too_many(builder, std::to_string(most) + " vertices",
                  "/meshes/0/primitives/" + std::to_string(most / 12) + "/attributes/POSITION");
}

// This one took 3 GB, and more.
TEST(GltfLimits, one_long_accessor_in_many_primitives) {
  GltfBuilder builder = column();
  const std::size_t count = 20'000;
  const std::size_t positions = builder.add("VEC3", std::vector<float>(3 * count, 0.5f));
  const std::size_t joints = builder.add("VEC4", std::vector<std::uint8_t>(4 * count, 0));
  const std::size_t weights = builder.add("VEC4", std::vector<float>(4 * count, 0.25f));
  const json attributes{{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}};
  primitives_of(builder) = json(std::size_t{4000}, json::object({{"attributes", attributes}}));
  const std::size_t most = (std::size_t{1} << 20) + builder.bytes.size() / 2;
  expect_too_many(builder, std::to_string(most) + " vertices",
                  "/meshes/0/primitives/" + std::to_string(most / count) + "/attributes/POSITION");
}

// Shows the mesh on as many more nodes.
void show_on(GltfBuilder& builder, int more) {
  json& nodes = builder.document["nodes"];
  for (int k = 0; k < more; ++k) {
    builder.document["scenes"][0]["nodes"].push_back(nodes.size());
    nodes.push_back({{"mesh", 0}, {"skin", 0}});
  }
}

TEST(GltfLimits, one_mesh_on_many_nodes) {
  GltfBuilder builder = column();
  const std::size_t position = add_zeros(builder, 5126, "VEC3", 3);
  primitives_of(builder) =
      json(std::size_t{400}, json::object({{"attributes", json::object({{"POSITION", position}})}}));
  show_on(builder, 400);
  const std::size_t most = ((std::size_t{1} << 20) + builder.bytes.size() / 2) / 8;
  expect_too_many(builder, std::to_string(most) + " parts",
                  "/meshes/0/primitives/" + std::to_string(most % 400));
}

// Degenerate triangles are left out, but their corners are read.
TEST(GltfLimits, strips_of_nothing) {
  GltfBuilder builder = column();
  json one = primitives_of(builder)[0];
  one["mode"] = 5;
  one["indices"] = builder.add("SCALAR", std::vector<std::uint8_t>(3000, 0));
  primitives_of(builder) = json(std::size_t{3000}, one);
  const std::size_t most = 6 * ((std::size_t{1} << 20) + builder.bytes.size() / 2);
  expect_too_many(builder, std::to_string(most) + " corners of triangles",
                  "/meshes/0/primitives/" + std::to_string(most / 3000));
}

TEST(GltfLimits, morph_targets_on_many_nodes) {
  GltfBuilder builder = column();
  primitives_of(builder)[0]["targets"] = json(std::size_t{3000}, json::object({{"POSITION", 0}}));
  show_on(builder, 400);
  expect_too_many(builder, "morph targets", "/meshes/0/primitives/0/targets");
}

constexpr std::size_t moved_vertices = 20'000;

// The column with as many vertices, all at one place, and as many targets that move them all.
GltfBuilder with_targets(std::size_t targets) {
  GltfBuilder builder = column();
  const std::size_t count = moved_vertices;
  const std::size_t positions = builder.add("VEC3", std::vector<float>(3 * count, 0.5f));
  json& one = primitives_of(builder)[0];
  one["attributes"]["POSITION"] = positions;
  one["attributes"]["JOINTS_0"] = builder.add("VEC4", std::vector<std::uint8_t>(4 * count, 0));
  one["attributes"]["WEIGHTS_0"] = builder.add("VEC4", std::vector<float>(4 * count, 0.25f));
  one["targets"] = json(targets, json::object({{"POSITION", positions}}));
  return builder;
}

// This one took 3.7 GB.
TEST(GltfLimits, one_morph_target_many_times) {
  // 2^20 positions and two for each byte.
  const std::size_t most = (std::size_t{1} << 20) + 2 * with_targets(1).bytes.size();
  {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder.write("few.glb", with_targets(most / moved_vertices).glb());
    EXPECT_EQ(gltf::read_rig(path).parts[0].shapes.size(), most / moved_vertices);
    EXPECT_EQ(gltf::read_gltf(path).surface.vertices.size(), moved_vertices);
  }
  expect_too_many(with_targets(most / moved_vertices + 1),
                  std::to_string(most) + " moved positions of morph targets",
                  "/meshes/0/primitives/0/targets/" + std::to_string(most / moved_vertices));
}

// Equal positions take next to nothing when compressed, so decoded bytes say little about the file's size.
TEST(GltfLimits, morph_targets_of_compressed_positions) {
  const GltfBuilder builder = with_targets(60);
  const TemporaryFolder folder;
  const std::filesystem::path plain = folder.write("plain.gltf", builder.with_data_uri().dump());
  EXPECT_EQ(gltf::read_rig(plain).parts[0].shapes.size(), 60U);
  const std::filesystem::path small = folder.write("small.gltf", with_meshopt(builder).dump());
  EXPECT_LT(std::filesystem::file_size(small), std::filesystem::file_size(plain) / 8);
  const std::string refusal = refusal_by([&] { gltf::read_rig(small); });
  EXPECT_NE(refusal.find(" moved positions of morph targets in all"), std::string::npos) << refusal;
}

TEST(GltfLimits, one_file_in_many_buffers) {
  const TemporaryFolder folder;
  GltfBuilder builder = column();
  folder.write("bytes.bin",
               std::string(builder.bytes.begin(), builder.bytes.end()) + std::string(1 << 20, 'x'));
  json document = builder.document;
  document["buffers"] = {{{"uri", "bytes.bin"}, {"byteLength", builder.bytes.size()}}};
  json again = document["buffers"][0];
  again["byteLength"] = 1;
  for (int k = 0; k < 15; ++k) document["buffers"].push_back(again);
  const std::filesystem::path path = folder.write("again.gltf", document.dump());
  EXPECT_EQ(gltf::read_gltf(path).surface.vertices.size(), 12U);
  document["buffers"].push_back(again);
  folder.write("again.gltf", document.dump());
  const std::string refusal = refusal_by([&] { gltf::read_gltf(path); });
  EXPECT_NE(refusal.find(": /buffers/16/uri: names the file of an earlier buffer"), std::string::npos)
      << refusal;
}

TEST(GltfLimits, sets_of_joints_and_weights) {
  GltfBuilder builder = column();
  const std::size_t count = std::size_t{1} << 19;
  json& attributes = primitives_of(builder)[0]["attributes"];
  attributes = json::object({{"POSITION", add_zeros(builder, 5126, "VEC3", count)}});
  const std::size_t joints = add_zeros(builder, 5121, "VEC4", count);
  const std::size_t weights = add_zeros(builder, 5126, "VEC4", count);
  for (int set = 0; set < 60; ++set) {
    attributes["JOINTS_" + std::to_string(set)] = joints;
    attributes["WEIGHTS_" + std::to_string(set)] = weights;
  }
  expect_too_many(builder, "sets of joints and weights", "/meshes/0/primitives/0/attributes/JOINTS_4");
}

TEST(GltfLimits, bind_matrices_of_a_skin_of_many_parts) {
  GltfBuilder builder = column();
  builder.document["skins"][0]["inverseBindMatrices"] =
      add_zeros(builder, 5126, "MAT4", std::size_t{1} << 16);
  const json one = primitives_of(builder)[0];
  primitives_of(builder) = json(std::size_t{400}, one);
  expect_too_many(builder, "inverse bind matrices", "/meshes/0/primitives/16");
}

// `materials` materials with a texture each, and the textures an image each, or all the same one.
GltfBuilder with_pictures(std::size_t materials, bool is_one_image) {
  GltfBuilder builder = column();
  const std::size_t picture = builder.add("SCALAR", std::vector<std::uint8_t>(10'000, 7));
  const json view = builder.document["accessors"][picture]["bufferView"];
  for (const char* list : {"materials", "textures", "images"}) builder.document[list] = json::array();
  for (std::size_t k = 0; k < materials; ++k) {
    const json use{{"baseColorTexture", {{"index", k}}}};
    builder.document["materials"].push_back({{"pbrMetallicRoughness", use}});
    builder.document["textures"].push_back({{"source", is_one_image ? 0 : k}});
    builder.document["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
  }
  return builder;
}

// A small file's channels may all name the same keys, each of which a clip holds for itself.
TEST(GltfLimits, keys_in_many_channels) {
  GltfBuilder builder = column();
  const std::size_t keys = 5000;
  std::vector<float> times(keys), turns;
  for (std::size_t k = 0; k < keys; ++k) {
    times[k] = static_cast<float>(k);
    turns.insert(turns.end(), {0, 0, 0, 1});
  }
  const std::size_t input = builder.add("SCALAR", times), output = builder.add("VEC4", turns);
  const json sampler{{"input", input}, {"output", output}};
  const auto with_clips = [&](std::size_t count) {
    GltfBuilder many = builder;
    many.document["animations"] =
        json(count, json{{"samplers", {sampler}},
                         {"channels",
                          {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}},
                           {{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}});
    return many;
  };
  // 2^20 numbers and 16 for a byte, at 25,000 a channel.
  const std::size_t most = (std::size_t{1} << 20) + 16 * builder.bytes.size();
  const std::size_t fit = most / (2 * 5 * keys);
  const TemporaryFolder folder;
  EXPECT_EQ(gltf::read_gltf(folder.write("fit.glb", with_clips(fit).glb())).clips.size(), fit);
  expect_too_many(with_clips(2 * fit), std::to_string(most) + " numbers of clips",
                  "/animations/" + std::to_string(fit));
}

// A baked surface.glb has as many shapes as keys, and every mesh follows the same weights.
TEST(GltfLimits, weights_of_many_meshes_are_held_once) {
  GltfBuilder builder = column_with_shapes();
  const std::size_t keys = 20'000;
  std::vector<float> times(keys);
  for (std::size_t k = 0; k < keys; ++k) times[k] = static_cast<float>(k);
  const std::size_t input = builder.add("SCALAR", times),
                    output = builder.add("SCALAR", std::vector<float>(2 * keys, 0.5f));
  json channels = json::array();
  for (std::size_t n = 0; n < 150; ++n) {
    const std::size_t node = builder.document["nodes"].size();
    builder.document["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
    builder.document["scenes"][0]["nodes"].push_back(node);
    channels.push_back({{"sampler", 0}, {"target", {{"node", node}, {"path", "weights"}}}});
  }
  builder.document["animations"] = json::array(
      {{{"samplers", json::array({{{"input", input}, {"output", output}}})}, {"channels", channels}}});
  const TemporaryFolder folder;
  const rig::Character character = gltf::read_gltf(folder.write("many.glb", builder.glb()));
  const std::vector<rig::WeightChannel>& weights = character.clips.at(0).weights;
  ASSERT_EQ(weights.size(), 150u);
  for (const rig::WeightChannel& channel : weights) EXPECT_EQ(channel.values, weights[0].values);
  EXPECT_EQ(weights[0].values->size(), 2 * keys);
}

TEST(GltfLimits, one_image_in_many_textures_is_read_once) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("pictures.glb", with_pictures(500, true).glb());
  const gltf::Looks looks = gltf::read_looks(path, gltf::read_rig(path));
  EXPECT_EQ(looks.textures.size(), 1U);
  ASSERT_EQ(looks.materials.size(), 501U);
  for (std::size_t k = 0; k < 500; ++k) EXPECT_EQ(looks.materials[k].texture, 0);
  EXPECT_TRUE(looks.notes.empty());
}

// 10,000 images of the same 500 KB would take 5 GB.
TEST(GltfLimits, images_of_the_same_bytes_share_them) {
  const TemporaryFolder folder;
  GltfBuilder builder = with_pictures(500, false);
  // Every other texture clamps.
  builder.document["samplers"] = {{{"wrapS", 33071}}};
  for (std::size_t k = 0; k < 500; k += 2) builder.document["textures"][k]["sampler"] = 0;
  const std::filesystem::path path = folder.write("pictures.glb", builder.glb());
  const gltf::Looks looks = gltf::read_looks(path, gltf::read_rig(path));
  ASSERT_EQ(looks.textures.size(), 500U);
  EXPECT_EQ(looks.textures[0].bytes->size(), 10'000U);
  for (const gltf::LookTexture& texture : looks.textures) EXPECT_EQ(texture.bytes, looks.textures[0].bytes);
  EXPECT_NE(looks.textures[0].across, looks.textures[1].across);
  EXPECT_TRUE(looks.notes.empty());
}

TEST(GltfLimits, images_whose_bytes_overlap) {
  const TemporaryFolder folder;
  GltfBuilder builder = with_pictures(500, false);
  json& views = builder.document["bufferViews"];
  json view = views[builder.document["images"][0]["bufferView"].get<std::size_t>()];
  for (std::size_t k = 1; k < 500; ++k) {
    view["byteLength"] = 10'000 - k;
    builder.document["images"][k]["bufferView"] = views.size();
    views.push_back(view);
  }
  const std::filesystem::path path = folder.write("pictures.glb", builder.glb());
  const gltf::Looks looks = gltf::read_looks(path, gltf::read_rig(path));
  std::size_t bytes = 0;
  for (const gltf::LookTexture& texture : looks.textures) bytes += texture.bytes->size();
  EXPECT_GE(bytes, 10'000U);
  EXPECT_LE(bytes, builder.bytes.size());
  ASSERT_EQ(looks.notes.size() + looks.textures.size(), 500U);
  EXPECT_EQ(
      looks.notes.back(),
      "image 499 is one of too many, which have more bytes than the file; its surface gets its plain colour");
}

// The same file under other names: once in memory, and once in character.glb.
TEST(GltfLimits, images_beside_the_file_are_read_once) {
  const TemporaryFolder folder;
  const std::string picture = "\x89PNG" + std::string(5000, 'x');
  folder.write("picture.png", picture);
  GltfBuilder builder = with_pictures(3, false);
  json document = builder.with_data_uri();
  document["images"] = {{{"uri", "picture.png"}}, {{"uri", "./picture.png"}}, {{"uri", "p%69cture.png"}}};
  const std::filesystem::path path = folder.write("beside.gltf", document.dump());
  const gltf::Looks looks = gltf::read_looks(path, gltf::read_rig(path));
  ASSERT_EQ(looks.textures.size(), 3U);
  for (const gltf::LookTexture& texture : looks.textures) EXPECT_EQ(texture.bytes, looks.textures[0].bytes);
  EXPECT_EQ(looks.textures[0].bytes->size(), picture.size());

  std::vector<std::string> missing;
  const gltf::GltfDocument packed = gltf::pack_gltf(path, missing);
  EXPECT_TRUE(missing.empty());
  std::size_t copies = 0;
  for (std::size_t at = packed.binary.find(picture); at != std::string::npos;
       at = packed.binary.find(picture, at + 1))
    ++copies;
  EXPECT_EQ(copies, 1U);
  for (const json& image : packed.json["images"]) {
    EXPECT_EQ(image["mimeType"], "image/png");
    EXPECT_EQ(image["bufferView"], packed.json["images"][0]["bufferView"]);
    EXPECT_FALSE(image.contains("uri"));
  }
}

TEST(GltfLimits, images_beside_the_file_have_a_limit_together) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "any.gltf";
  for (const char* name : {"a.png", "b.png", "c.png", "d.png"}) folder.write(name, std::string(1000, 'x'));
  gltf::ImagesBeside images(path, 2500);
  const gltf::ImageBytes first = images.read("/images/0/uri", "a.png");
  EXPECT_EQ(first->size(), 1000U);
  EXPECT_EQ(images.read("/images/1/uri", "./a.png"), first);
  EXPECT_EQ(images.read("/images/2/uri", "b.png")->size(), 1000U);
  for (const char* name : {"c.png", "d.png"}) {
    const std::string refusal = refusal_by([&] { images.read("/images/3/uri", name); });
    EXPECT_NE(refusal.find("/images/3/uri: the images beside the file have more than 2500 bytes in all"),
              std::string::npos)
        << refusal;
  }
  EXPECT_EQ(images.read("/images/4/uri", "a.png"), first);
}

}  // namespace
}  // namespace fascicle::tests
