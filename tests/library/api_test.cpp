// The C API: scenes, options and devices, and the handling of bad arguments by every function.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "include/fascicle/fascicle.h"
#include "tests/library/c_api.h"
#include "tests/library/shell.h"

extern "C" std::size_t fascicle_test_sizes(void);

namespace fascicle_tests {
namespace {

TEST(CApi, VersionsAgree) {
  EXPECT_STREQ(fascicle_version(), FASCICLE_VERSION_STRING);
  EXPECT_EQ(std::to_string(FASCICLE_VERSION_MAJOR) + "." + std::to_string(FASCICLE_VERSION_MINOR) + "." +
                std::to_string(FASCICLE_VERSION_PATCH),
            FASCICLE_VERSION_STRING);
  EXPECT_GE(fascicle_solver_version(), 7u);
  EXPECT_EQ(fascicle_test_sizes(), sizeof(fascicle_scene_options) + sizeof(fascicle_bake_options) +
                                       sizeof(fascicle_device_options) + sizeof(fascicle_build_options) +
                                       sizeof(fascicle_solver_options) + sizeof(fascicle_pose) +
                                       sizeof(fascicle_drive));
}

TEST(CApi, EveryStatusHasAText) {
  for (const int status : {0, 1, 2, 3, 4, 5, 75})
    EXPECT_STRNE(fascicle_status_text(static_cast<fascicle_status>(status)), "unknown status") << status;
}

TEST(CApi, NullIsRefusedAndDestroyed) {
  fascicle_scene* scene = nullptr;
  EXPECT_FAILS(fascicle_scene_load(nullptr, nullptr, &scene), FASCICLE_BAD_ARGUMENT, "name is null");
  EXPECT_FAILS(fascicle_scene_load("arm", nullptr, nullptr), FASCICLE_BAD_ARGUMENT, "null");
  EXPECT_FAILS(fascicle_scene_parse(nullptr, nullptr, nullptr, &scene), FASCICLE_BAD_ARGUMENT,
               "text is null");
  fascicle_model* model = nullptr;
  EXPECT_FAILS(fascicle_model_build(nullptr, nullptr, &model), FASCICLE_BAD_ARGUMENT, "scene is null");
  EXPECT_FAILS(fascicle_bake_run(nullptr, nullptr, nullptr), FASCICLE_BAD_ARGUMENT, "scene is null");
  fascicle_solver* solver = nullptr;
  EXPECT_FAILS(fascicle_solver_create(nullptr, nullptr, nullptr, &solver), FASCICLE_BAD_ARGUMENT,
               "model is null");
  fascicle_array array{};
  EXPECT_FAILS(fascicle_model_array(nullptr, "rest", &array), FASCICLE_BAD_ARGUMENT, "model is null");
  EXPECT_FAILS(fascicle_model_array_at(nullptr, 0, &array), FASCICLE_BAD_ARGUMENT, "model is null");
  EXPECT_FAILS(fascicle_model_create(nullptr, 3, &model), FASCICLE_BAD_ARGUMENT, "arrays is null");
  fascicle_frame frame{};
  char text[17];
  std::size_t size = 0;
  const auto refused = [](fascicle_status status) {
    EXPECT_FAILS(status, FASCICLE_BAD_ARGUMENT, "solver is null");
  };
  refused(fascicle_solver_start_clip(nullptr, nullptr, nullptr));
  refused(fascicle_solver_step_clip(nullptr));
  refused(fascicle_solver_start_pose(nullptr, nullptr, 0));
  refused(fascicle_solver_step_pose(nullptr, nullptr));
  refused(fascicle_solver_clip_pose(nullptr, 0, nullptr, 0));
  refused(fascicle_solver_step_drive(nullptr, nullptr));
  refused(fascicle_solver_frame(nullptr, &frame));
  refused(fascicle_solver_positions(nullptr, nullptr, 0));
  refused(fascicle_solver_surface(nullptr, nullptr, 0));
  refused(fascicle_solver_position_hash(nullptr, text));
  refused(fascicle_solver_save(nullptr, nullptr, 0, &size));
  refused(fascicle_solver_load(nullptr, nullptr, 0));
  fascicle_scene_destroy(nullptr);
  fascicle_model_destroy(nullptr);
  fascicle_device_destroy(nullptr);
  fascicle_solver_destroy(nullptr);
  fascicle_bake_destroy(nullptr);
  EXPECT_EQ(fascicle_scene_name(nullptr), nullptr);
  EXPECT_EQ(fascicle_scene_frame_count(nullptr), 0u);
  EXPECT_EQ(fascicle_scene_joint_name(nullptr, 0), nullptr);
  EXPECT_EQ(fascicle_scene_joint_parent(nullptr, 0), -1);
  EXPECT_EQ(fascicle_scene_clip_name(nullptr, 0), nullptr);
  EXPECT_EQ(fascicle_model_vertex_count(nullptr), 0u);
  EXPECT_EQ(fascicle_model_substeps(nullptr), 0u);
  EXPECT_EQ(fascicle_device_text(nullptr), nullptr);
  EXPECT_EQ(fascicle_solver_device_text(nullptr), nullptr);
  EXPECT_EQ(fascicle_device_is_exact(nullptr), 0);
  EXPECT_EQ(fascicle_bake_file(nullptr, 0), nullptr);
  EXPECT_TRUE(std::isnan(fascicle_bake_look(nullptr)));
}

TEST(CApi, BadTextIsNamedByLineAndKey) {
  fascicle_scene* scene = reinterpret_cast<fascicle_scene*>(1);
  EXPECT_FAILS(fascicle_scene_parse("[bar]\nsiez = [1, 1, 1]\n", nullptr, nullptr, &scene),
               FASCICLE_BAD_INPUT, "text:2");
  EXPECT_EQ(scene, nullptr) << "a failed call leaves no handle";
  EXPECT_FAILS(fascicle_scene_parse("[bar", nullptr, nullptr, &scene), FASCICLE_BAD_INPUT, "text:1");
  EXPECT_FAILS(fascicle_scene_load("no-such-scene", nullptr, &scene), FASCICLE_BAD_INPUT, "no such scene");
}

TEST(CApi, OptionsChangeTheSceneAndBadOnesAreRefused) {
  fascicle_scene_options options = fascicle_scene_options_default();
  const char* set[] = {"layers.flesh.alpha=0.25"};
  options.set = set;
  options.set_count = 1;
  options.fps = 30.0;
  options.end = 0.2;
  fascicle_scene* scene = nullptr;
  ASSERT_EQ(fascicle_scene_parse(small_bar, nullptr, &options, &scene), FASCICLE_OK) << message();
  EXPECT_EQ(fascicle_scene_fps(scene), 30.0);
  EXPECT_EQ(fascicle_scene_frame_count(scene), 6u);
  fascicle_scene_destroy(scene);
  set[0] = "layers.flesh.alpha";
  EXPECT_FAILS(fascicle_scene_parse(small_bar, nullptr, &options, &scene), FASCICLE_BAD_ARGUMENT,
               "KEY=VALUE");
  set[0] = nullptr;
  EXPECT_FAILS(fascicle_scene_parse(small_bar, nullptr, &options, &scene), FASCICLE_BAD_ARGUMENT,
               "options.set[0]");
  options.set_count = 0;
  options.struct_size = 0;  // not from _default()
  EXPECT_FAILS(fascicle_scene_parse(small_bar, nullptr, &options, &scene), FASCICLE_BAD_ARGUMENT,
               "struct_size");
  options.struct_size = sizeof options + 8;
  EXPECT_FAILS(fascicle_scene_parse(small_bar, nullptr, &options, &scene), FASCICLE_BAD_ARGUMENT,
               "struct_size");
}

// No headers have a struct that ends within a pointer: half of one must not be followed.
TEST(CApi, OptionsThatEndWithinAFieldAreRefused) {
  for (std::size_t size = 0; size < sizeof(fascicle_scene_options); ++size) {
    fascicle_scene_options options = fascicle_scene_options_default();
    options.clip = "0";
    options.converter = "no-such-converter";
    options.struct_size = size;
    fascicle_scene* scene = nullptr;
    const fascicle_status status = fascicle_scene_parse(small_bar, nullptr, &options, &scene);
    if (size == 0 || size % alignof(fascicle_scene_options) != 0) {
      EXPECT_EQ(status, FASCICLE_BAD_ARGUMENT) << size;
      EXPECT_NE(message().find("struct_size"), std::string::npos) << size << ": " << message();
    }
    fascicle_scene_destroy(scene);
  }
}

// As from a program compiled with headers that end after `fps`.
TEST(CApi, ShorterOptionsOfOlderHeadersAreEnough) {
  fascicle_scene_options options;
  const std::size_t older = offsetof(fascicle_scene_options, start);
  fascicle_scene_options_init(&options, older);
  options.fps = 30.0;
  std::fill(reinterpret_cast<char*>(&options) + older, reinterpret_cast<char*>(&options + 1), char(0x11));
  fascicle_scene* scene = nullptr;
  ASSERT_EQ(fascicle_scene_parse(small_bar, nullptr, &options, &scene), FASCICLE_OK) << message();
  EXPECT_EQ(fascicle_scene_fps(scene), 30.0);
  EXPECT_EQ(fascicle_scene_frame_count(scene), 3u);
  fascicle_scene_destroy(scene);
}

TEST(CApi, MessagesAreOfTheirThread) {
  fascicle_scene* scene = nullptr;
  EXPECT_FAILS(fascicle_scene_load("no-such-scene", nullptr, &scene), FASCICLE_BAD_INPUT, "no such scene");
  std::string other = "unset";
  std::thread([&] { other = fascicle_last_message(); }).join();
  EXPECT_EQ(other, "");
}

TEST(CApi, BuiltinScenesAndFormatsAreListed) {
  std::size_t scenes = 0, formats = 0;
  while (fascicle_builtin_scene_name(scenes) != nullptr) ++scenes;
  while (fascicle_format_name(formats) != nullptr) ++formats;
  EXPECT_GE(scenes, 10u);
  EXPECT_GE(formats, 8u);
}

TEST(CApi, ACharacterTellsItsJointsAndClips) {
  fascicle_scene* scene = nullptr;
  ASSERT_EQ(fascicle_scene_load("arm", nullptr, &scene), FASCICLE_OK) << message();
  ASSERT_GE(fascicle_scene_joint_count(scene), 2u);
  EXPECT_EQ(fascicle_scene_joint_parent(scene, 0), -1);
  bool has_forearm = false;
  for (std::size_t j = 0; j < fascicle_scene_joint_count(scene); ++j) {
    EXPECT_LT(fascicle_scene_joint_parent(scene, j), static_cast<std::int32_t>(j));
    has_forearm = has_forearm || std::string(fascicle_scene_joint_name(scene, j)) == "forearm";
  }
  EXPECT_TRUE(has_forearm);
  EXPECT_STREQ(fascicle_scene_clip_name(scene, 0), "curl");
  EXPECT_EQ(fascicle_scene_clip_name(scene, 99), nullptr);
  fascicle_scene_destroy(scene);
}

TEST(CApi, DevicesAreOpenedByName) {
  fascicle_device* device = nullptr;
  EXPECT_FAILS(fascicle_device_open("gpu", nullptr, &device), FASCICLE_BAD_ARGUMENT, "\"gpu\"");
  EXPECT_FAILS(fascicle_device_open("vulkan:77", nullptr, &device), FASCICLE_NO_SUCH_DEVICE, "");
  fascicle_device_options options = fascicle_device_options_default();
  options.threads = 1025;
  EXPECT_FAILS(fascicle_device_open("cpu", &options, &device), FASCICLE_BAD_ARGUMENT,
               "options.threads is 1025");
  ASSERT_EQ(fascicle_device_open("cpu:scalar", nullptr, &device), FASCICLE_OK) << message();
  EXPECT_EQ(fascicle_device_is_exact(device), 1);
  EXPECT_NE(std::string(fascicle_device_text(device)).find("cpu:scalar"), std::string::npos);
  fascicle_device_destroy(device);
}

}  // namespace
}  // namespace fascicle_tests
