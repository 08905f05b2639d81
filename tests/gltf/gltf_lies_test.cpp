// Documents with one false number, name or index each. Each must be refused with a message that names the
// place, by every reader that needs it.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/gltf/gltf_rig.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/refused_files.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

struct Lie {
  const char* name;
  const char* place;
  std::function<void(GltfBuilder&)> tell;
};

void replace(GltfBuilder& b, const char* attribute, std::size_t accessor) {
  primitive(b)["attributes"][attribute] = accessor;
}

std::vector<float> column_weights() {
  std::vector<float> weights;
  for (int i = 0; i < 12; ++i) weights.insert(weights.end(), {1, 0, 0, 0});
  return weights;
}

// Accessors of column(): 0 positions, 1 joints, 2 weights, 3 indices, 4 matrices, 5 times, 6 rotations, 7
// translations.
const std::vector<Lie>& lies() {
  static const std::vector<Lie> all{
      {"count_of_four_thousand_million", "/accessors/0/count",
       [](GltfBuilder& b) { b.document["accessors"][0]["count"] = 4000000000u; }},
      {"count_beyond_the_last_byte", "/accessors/0/count",
       [](GltfBuilder& b) { b.document["accessors"][0]["count"] = 13; }},
      {"count_that_overflows", "/accessors/0/count",
       [](GltfBuilder& b) {
         b.document["accessors"][0]["count"] = std::numeric_limits<std::uint64_t>::max() / 12 + 2;
       }},
      {"count_negative", "/accessors/0/count",
       [](GltfBuilder& b) { b.document["accessors"][0]["count"] = -1; }},
      {"count_zero", "/accessors/0/count", [](GltfBuilder& b) { b.document["accessors"][0]["count"] = 0; }},
      {"count_text", "/accessors/0/count",
       [](GltfBuilder& b) { b.document["accessors"][0]["count"] = "12"; }},
      {"count_without_data", "/accessors/0/count",
       [](GltfBuilder& b) {
         b.document["accessors"][0].erase("bufferView");
         b.document["accessors"][0]["count"] = 4000000000u;
       }},
      {"offset_beyond_the_view", "/accessors/0/count",
       [](GltfBuilder& b) { b.document["accessors"][0]["byteOffset"] = 4; }},
      {"offset_that_overflows", "/accessors/0/byteOffset",
       [](GltfBuilder& b) {
         b.document["accessors"][0]["byteOffset"] = std::numeric_limits<std::uint64_t>::max() - 3;
       }},
      {"stride_beyond_the_view", "/accessors/0/count",
       [](GltfBuilder& b) { b.document["bufferViews"][0]["byteStride"] = 252; }},
      {"stride_below_an_element", "/accessors/0/bufferView",
       [](GltfBuilder& b) { b.document["bufferViews"][0]["byteStride"] = 8; }},
      {"stride_odd", "/bufferViews/0/byteStride",
       [](GltfBuilder& b) { b.document["bufferViews"][0]["byteStride"] = 13; }},
      {"stride_that_overflows", "/bufferViews/0/byteStride",
       [](GltfBuilder& b) { b.document["bufferViews"][0]["byteStride"] = 1099511627776u; }},
      {"view_beyond_the_buffer", "/bufferViews/0/byteLength",
       [](GltfBuilder& b) { b.document["bufferViews"][0]["byteLength"] = 1000000; }},
      {"view_offset_that_overflows", "/bufferViews/0/byteOffset",
       [](GltfBuilder& b) {
         b.document["bufferViews"][0]["byteOffset"] = std::numeric_limits<std::uint64_t>::max();
       }},
      {"view_of_no_buffer", "/bufferViews/0/buffer",
       [](GltfBuilder& b) { b.document["bufferViews"][0]["buffer"] = 1; }},
      {"accessor_of_no_view", "/accessors/0/bufferView",
       [](GltfBuilder& b) { b.document["accessors"][0]["bufferView"] = 99; }},
      {"component_type_unknown", "/accessors/0/componentType",
       [](GltfBuilder& b) { b.document["accessors"][0]["componentType"] = 5124; }},
      {"type_unknown", "/accessors/0/type",
       [](GltfBuilder& b) { b.document["accessors"][0]["type"] = "VEC9"; }},
      {"positions_of_the_wrong_type", "/meshes/0/primitives/0/attributes/POSITION",
       [](GltfBuilder& b) { replace(b, "POSITION", 2); }},
      {"attribute_of_no_accessor", "/meshes/0/primitives/0/attributes/POSITION",
       [](GltfBuilder& b) { replace(b, "POSITION", 4000000); }},
      {"attributes_of_different_counts", "/meshes/0/primitives/0/attributes/WEIGHTS_0",
       [](GltfBuilder& b) { b.document["accessors"][2]["count"] = 11; }},
      {"weights_missing", "/meshes/0/primitives/0/attributes/WEIGHTS_0",
       [](GltfBuilder& b) { primitive(b)["attributes"].erase("WEIGHTS_0"); }},
      {"second_joints_without_weights", "/meshes/0/primitives/0/attributes/WEIGHTS_1",
       [](GltfBuilder& b) { replace(b, "JOINTS_1", 1); }},
      {"weight_not_a_number", "/accessors/8",
       [](GltfBuilder& b) {
         std::vector<float> w = column_weights();
         w[17] = std::numeric_limits<float>::quiet_NaN();
         replace(b, "WEIGHTS_0", b.add("VEC4", w));
       }},
      {"weight_negative", "/meshes/0/primitives/0/attributes/WEIGHTS_0",
       [](GltfBuilder& b) {
         std::vector<float> w = column_weights();
         w[5] = -0.1f;
         replace(b, "WEIGHTS_0", b.add("VEC4", w));
       }},
      {"weights_all_zero", "/meshes/0/primitives/0/attributes/WEIGHTS_0",
       [](GltfBuilder& b) { replace(b, "WEIGHTS_0", b.add("VEC4", std::vector<float>(48, 0.0f))); }},
      {"position_infinite", "/accessors/8",
       [](GltfBuilder& b) {
         std::vector<float> p(36, 0.0f);
         p[35] = std::numeric_limits<float>::infinity();
         replace(b, "POSITION", b.add("VEC3", p));
       }},
      {"joint_beyond_the_skin", "/meshes/0/primitives/0/attributes/JOINTS_0",
       [](GltfBuilder& b) { replace(b, "JOINTS_0", b.add("VEC4", std::vector<std::uint8_t>(48, 2))); }},
      {"index_beyond_the_vertices", "/meshes/0/primitives/0/indices",
       [](GltfBuilder& b) {
         primitive(b)["indices"] = b.add("SCALAR", std::vector<std::uint16_t>{0, 1, 12});
       }},
      {"indices_not_in_threes", "/meshes/0/primitives/0/indices",
       [](GltfBuilder& b) {
         primitive(b)["indices"] = b.add("SCALAR", std::vector<std::uint16_t>{0, 1, 2, 3});
       }},
      {"indices_of_floats", "/meshes/0/primitives/0/indices",
       [](GltfBuilder& b) {
         primitive(b)["indices"] = b.add("SCALAR", std::vector<float>{0, 1, 2});
       }},
      {"indices_without_data", "/meshes/0/primitives/0/indices",
       [](GltfBuilder& b) {
         b.document["accessors"].push_back({{"componentType", 5123}, {"type", "SCALAR"}, {"count", 3}});
         primitive(b)["indices"] = 8;
       }},
      {"lines", "/meshes/0/primitives/0/mode", [](GltfBuilder& b) { primitive(b)["mode"] = 1; }},
      {"mode_unknown", "/meshes/0/primitives/0/mode", [](GltfBuilder& b) { primitive(b)["mode"] = 77; }},
      {"mesh_without_primitives", "/meshes/0/primitives",
       [](GltfBuilder& b) { b.document["meshes"][0]["primitives"] = json::array(); }},
      {"sparse_index_beyond_the_end", "/accessors/0/sparse/indices",
       [](GltfBuilder& b) {
         const std::size_t i = b.add_view(std::vector<std::uint8_t>{200}),
                           v = b.add_view(std::vector<float>{1, 2, 3});
         b.document["accessors"][0]["sparse"] = {{"count", 1},
                                                 {"indices", {{"bufferView", i}, {"componentType", 5121}}},
                                                 {"values", {{"bufferView", v}}}};
       }},
      {"sparse_values_beyond_the_view", "/accessors/0/sparse/values",
       [](GltfBuilder& b) {
         const std::size_t i = b.add_view(std::vector<std::uint8_t>{1, 2}),
                           v = b.add_view(std::vector<float>{1, 2, 3});
         b.document["accessors"][0]["sparse"] = {{"count", 2},
                                                 {"indices", {{"bufferView", i}, {"componentType", 5121}}},
                                                 {"values", {{"bufferView", v}}}};
       }},
      {"skin_without_joints", "/skins/0/joints",
       [](GltfBuilder& b) { b.document["skins"][0]["joints"] = json::array(); }},
      {"skin_with_a_joint_twice", "/skins/0/joints/1",
       [](GltfBuilder& b) {
         b.document["skins"][0]["joints"] = {1, 1};
       }},
      {"skin_with_a_joint_that_is_not", "/skins/0/joints/1",
       [](GltfBuilder& b) {
         b.document["skins"][0]["joints"] = {1, 4};
       }},
      {"skin_with_too_few_matrices", "/skins/0/inverseBindMatrices",
       [](GltfBuilder& b) { b.document["accessors"][4]["count"] = 1; }},
      {"skin_with_a_projection", "/accessors/8",
       [](GltfBuilder& b) {
         b.document["skins"][0]["inverseBindMatrices"] = b.add("MAT4", std::vector<float>(32, 1.0f));
       }},
      {"no_skinned_mesh", "/nodes", [](GltfBuilder& b) { b.document["nodes"][3].erase("skin"); }},
      {"joint_scaled_to_nothing", "/nodes/2",
       [](GltfBuilder& b) {
         b.document["nodes"][2]["scale"] = {1, 0, 1};
       }},
      {"rotation_of_zeros", "/nodes/2/rotation",
       [](GltfBuilder& b) {
         b.document["nodes"][2]["rotation"] = {0, 0, 0, 0};
       }},
      {"matrix_of_fifteen", "/nodes/2/matrix",
       [](GltfBuilder& b) { b.document["nodes"][2]["matrix"] = std::vector<int>(15, 1); }},
      {"translation_out_of_range", "/nodes/1",
       [](GltfBuilder& b) {
         b.document["nodes"][0]["scale"] = {1e200, 1e200, 1e200};
         b.document["nodes"][1]["scale"] = {1e200, 1e200, 1e200};
       }},
      {"nodes_in_a_circle", "/nodes/0/children",
       [](GltfBuilder& b) { b.document["nodes"][2]["children"] = {0}; }},
      {"node_below_itself", "/nodes/2/children/0",
       [](GltfBuilder& b) { b.document["nodes"][2]["children"] = {2}; }},
      {"node_with_two_parents", "/nodes/3/children/0",
       [](GltfBuilder& b) { b.document["nodes"][3]["children"] = {2}; }},
      {"child_that_is_not", "/nodes/2/children/0",
       [](GltfBuilder& b) { b.document["nodes"][2]["children"] = {-1}; }},
      {"nodes_too_deep", "/nodes/1025",
       [](GltfBuilder& b) {
         for (int i = 4; i < 200000; ++i) b.document["nodes"].push_back({{"children", {i + 1}}});
         b.document["nodes"].push_back(json::object());
         b.document["nodes"][2]["children"] = {4};
       }},
      {"json_too_deep", "/",
       [](GltfBuilder& b) {
         json deep = 1;
         for (int i = 0; i < 1000; ++i) deep = json::array({std::move(deep)});
         b.document["extras"] = std::move(deep);
       }},
      {"keys_out_of_order", "/accessors/8",
       [](GltfBuilder& b) {
         b.document["animations"][0]["samplers"][0]["input"] = b.add("SCALAR", std::vector<float>{1, 1});
       }},
      {"keys_without_values", "/animations/0/samplers/0/output",
       [](GltfBuilder& b) { b.document["accessors"][6]["count"] = 1; }},
      {"key_that_is_no_rotation", "/accessors/8",
       [](GltfBuilder& b) {
         b.document["animations"][0]["samplers"][0]["output"] = b.add("VEC4", std::vector<float>(8, 0.0f));
       }},
      {"channel_of_no_sampler", "/animations/0/channels/0/sampler",
       [](GltfBuilder& b) { b.document["animations"][0]["channels"][0]["sampler"] = 1; }},
      {"channel_twice", "/animations/0/channels/1/target",
       [](GltfBuilder& b) {
         json& channels = b.document["animations"][0]["channels"];
         channels.push_back(channels[0]);
       }},
      {"channel_of_a_matrix", "/animations/0/channels/0/target/node",
       [](GltfBuilder& b) {
         b.document["nodes"][2]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
       }},
      {"path_of_two_lines", "/animations/0/channels/0/target/path",
       [](GltfBuilder& b) {
         b.document["animations"][0]["channels"][0]["target"]["path"] = "rota\n\x1b[31mtion";
       }},
      {"attribute_of_two_lines", "/meshes/0/primitives/0/attributes/_A\\nB",
       [](GltfBuilder& b) { primitive(b)["attributes"]["_A\nB"] = 999; }},
      {"interpolation_unknown", "/animations/0/samplers/0/interpolation",
       [](GltfBuilder& b) { b.document["animations"][0]["samplers"][0]["interpolation"] = "QUINTIC"; }},
      {"extension_that_is_needed", "/extensionsRequired/0",
       [](GltfBuilder& b) { b.document["extensionsRequired"] = {"EXT_mesh_gpu_instancing"}; }},
      {"target_of_no_accessor", "/meshes/0/primitives/0/targets/0/POSITION",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", 4000000}}};
       }},
      {"target_of_another_count", "/meshes/0/primitives/0/targets/0/POSITION",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", b.add("VEC3", std::vector<float>(33, 0.0f))}}};
       }},
      {"target_of_the_wrong_type", "/meshes/0/primitives/0/targets/0/POSITION",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", 2}}};
       }},
      {"target_not_a_number", "/accessors/8",
       [](GltfBuilder& b) {
         std::vector<float> p(36, 0.0f);
         p[35] = std::numeric_limits<float>::quiet_NaN();
         primitive(b)["targets"] = {{{"POSITION", b.add("VEC3", p)}}};
       }},
      {"target_weights_too_few", "/meshes/0/weights",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", 0}}, {{"POSITION", 0}}};
         b.document["meshes"][0]["weights"] = {0.5};
       }},
      {"target_weights_of_the_node_too_many", "/nodes/3/weights",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", 0}}};
         b.document["nodes"][3]["weights"] = {0.5, 0.5};
       }},
      {"target_weights_text", "/meshes/0/weights/0",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", 0}}};
         b.document["meshes"][0]["weights"] = {"half"};
       }},
      {"target_keys_too_few", "/animations/0/samplers/0/output",
       [](GltfBuilder& b) {
         primitive(b)["targets"] = {{{"POSITION", 0}}, {{"POSITION", 0}}};
         json& animation = b.document["animations"][0];
         animation["samplers"][0]["output"] = b.add("SCALAR", std::vector<float>{0, 1, 0});
         animation["channels"][0]["target"] = {{"node", 3}, {"path", "weights"}};
       }},
      {"version_one", "/asset/version", [](GltfBuilder& b) { b.document["asset"]["version"] = "1.0"; }},
      {"asset_missing", "/asset", [](GltfBuilder& b) { b.document.erase("asset"); }},
      {"scene_that_is_not", "/scene", [](GltfBuilder& b) { b.document["scene"] = 1; }},
      {"array_that_is_an_object", "/accessors",
       [](GltfBuilder& b) { b.document["accessors"] = json::object(); }},
      {"object_that_is_a_number", "/nodes/2", [](GltfBuilder& b) { b.document["nodes"][2] = 5; }},
  };
  return all;
}

class LyingGltf : public testing::TestWithParam<Lie> {};

TEST_P(LyingGltf, is_refused_as_text_and_as_binary) {
  GltfBuilder b = column();
  GetParam().tell(b);
  const TemporaryFolder folder;
  {
    SCOPED_TRACE("gltf");
    expect_file_refused(folder.write("lie.gltf", b.with_data_uri().dump()), GetParam().place);
  }
  SCOPED_TRACE("glb");
  expect_file_refused(folder.write("lie.glb", b.glb()), GetParam().place);
}

INSTANTIATE_TEST_SUITE_P(All, LyingGltf, testing::ValuesIn(lies()),
                         [](const auto& lie) { return std::string(lie.param.name); });

// Every reader checks joints and weights: the rig of a bake's character.glb is read on its own.
TEST(LyingRig, joints_and_weights) {
  const TemporaryFolder folder;
  std::size_t told = 0;
  for (const Lie& lie : lies()) {
    const std::string place = lie.place;
    const bool is_of_skin = place.find("/JOINTS_") != std::string::npos ||
                            place.find("/WEIGHTS_") != std::string::npos ||
                            place.find("/attributes/POSITION") != std::string::npos;
    // Viewers may place a vertex without weights anywhere.
    if (!is_of_skin || std::string(lie.name) == "weights_all_zero") continue;
    SCOPED_TRACE(lie.name);
    GltfBuilder b = column();
    lie.tell(b);
    const std::filesystem::path path = folder.write("lie.glb", b.glb());
    ++told;
    try {
      gltf::read_rig(path);
      ADD_FAILURE() << "was read";
    } catch (const base::SceneError& error) {
      EXPECT_NE(std::string(error.what()).find(": " + place + ": "), std::string::npos) << error.what();
    }
  }
  EXPECT_GE(told, 7u);
}

}  // namespace
}  // namespace fascicle::tests
