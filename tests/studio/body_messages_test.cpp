// Messages that describe a body, of a model made for the purpose.
#include "host/studio/body_messages.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/gltf/gltf_builder.h"
#include "tests/studio/decoded.h"
#include "tests/support/bar_and_boxes.h"

namespace fascicle::tests {
namespace {

TEST(BodyMessages, BoundsAndCameraLeaveOutFloors) {
  const model::Model plain = bar_and_boxes({});
  const model::Model beside = bar_and_boxes({{{-4.0f, -0.02f, -4.0f}, {4.0f, 0.0f, 4.0f}}});
  const auto arrays = [](const model::Model& model) { return studio::array_messages({model}, {}, 1, {}); };
  const auto surroundings = [&](const model::Model& model) {
    std::vector<std::uint32_t> found;
    for (const studio::ArrayMessage& array : arrays(model))
      if (array.name == "surface.surroundings") found = decode_array(*array.bytes).numbers;
    return found;
  };
  EXPECT_EQ(surroundings(plain), std::vector<std::uint32_t>());
  EXPECT_EQ(surroundings(beside),
            (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1}));
  const auto bounds = [&](const model::Model& model) {
    return studio::body_json({model}, {}, 1, arrays(model))["bounds"];
  };
  EXPECT_EQ(bounds(beside), bounds(plain));
  EXPECT_EQ(bounds(plain), studio::Json::parse("[[0, 0, 0], [1, 0.5, 0.5]]"));
}

// The beginning of a PNG of 2^25 texels, which are 128 MiB once decoded, and as many bytes as these need at
// least.
std::vector<unsigned char> large_png() {
  std::vector<unsigned char> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const auto add = [&](std::uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) png.push_back(static_cast<unsigned char>(number >> shift));
  };
  const auto add_name = [&](const std::string& name) { png.insert(png.end(), name.begin(), name.end()); };
  add(13);
  add_name("IHDR");
  add(8192);
  add(4096);
  png.insert(png.end(), {8, 2, 0, 0, 0});
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t k = 12; k < png.size(); ++k) {
    crc ^= png[k];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  add(~crc);
  constexpr std::uint32_t data_bytes = 150'000;
  add(data_bytes);
  add_name("IDAT");
  png.resize(png.size() + data_bytes + 4);
  return png;
}

// One image in textures that differ in how they wrap: the browser decodes each. Eight of them fill 1 GiB.
TEST(BodyMessages, TexturesBeyondWhatABrowserCanHoldAreLeftOut) {
  GltfBuilder builder = column();
  builder.document["images"] = {{{"bufferView", builder.add_view(large_png())}, {"mimeType", "image/png"}}};
  for (const int across : {33071, 33648, 10497})
    for (const int down : {33071, 33648, 10497}) {
      const std::size_t number = builder.document["samplers"].size();
      builder.document["samplers"].push_back({{"wrapS", across}, {"wrapT", down}});
      builder.document["textures"].push_back({{"source", 0}, {"sampler", number}});
      builder.document["materials"].push_back(
          {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", number}}}}}});
    }
  builder.document["meshes"][0]["primitives"][0]["material"] = 0;
  model::Model model = bar_and_boxes({});
  model.surface_vertex.resize(4 * 12);  // the column's
  const TemporaryFolder folder;
  std::vector<std::string> warnings;
  const studio::BodyLooks looks =
      studio::read_body_looks(folder.write("large.glb", builder.glb()), model,
                              [&](pipeline::Severity, const std::string& text) { warnings.push_back(text); });
  EXPECT_EQ(looks.images.size(), 8u);
  ASSERT_EQ(looks.materials.size(), 10u);
  EXPECT_EQ(looks.materials[7]["texture"], 7);
  EXPECT_EQ(looks.materials[8]["texture"], -1);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("exceeds the studio's limit on textures"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace fascicle::tests
