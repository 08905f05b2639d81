// Level 3: models as arrays, and solvers of them.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "include/fascicle/fascicle.h"
#include "tests/library/shell.h"

namespace fascicle_tests {
namespace {

fascicle_model* built_bar() {
  fascicle_scene* scene = nullptr;
  fascicle_model* model = nullptr;
  EXPECT_EQ(fascicle_scene_parse(small_bar, nullptr, nullptr, &scene), FASCICLE_OK);
  EXPECT_EQ(fascicle_model_build(scene, nullptr, &model), FASCICLE_OK) << fascicle_last_message();
  fascicle_scene_destroy(scene);
  return model;
}

std::vector<fascicle_array> arrays_of(const fascicle_model* model) {
  std::vector<fascicle_array> arrays;
  for (fascicle_array array; fascicle_model_array_at(model, arrays.size(), &array) == FASCICLE_OK;)
    arrays.push_back(array);
  return arrays;
}

fascicle_array& named(std::vector<fascicle_array>& arrays, const std::string& name) {
  const auto found =
      std::find_if(arrays.begin(), arrays.end(), [&](const auto& a) { return a.name == name; });
  EXPECT_NE(found, arrays.end()) << name;
  return *found;
}

// The position hash after six frames: these drives give the same as the scene's own stepping.
std::string hash_after(fascicle_solver* solver, bool by_drives) {
  fascicle_frame frame{};
  EXPECT_EQ(fascicle_solver_frame(solver, &frame), FASCICLE_OK);
  fascicle_drive drive = fascicle_drive_default();
  // exp(-damping h) for 1/s at 60 fps, as in the scene's drive.
  const float decay = 0.983471453f;
  drive.h = 1.0 / 60.0;
  drive.decay = &decay;
  drive.decay_count = 1;
  std::copy(frame.origin, frame.origin + 3, drive.origin);
  drive.gravity[1] = static_cast<float>(-9.81 / frame.unit);
  if (!by_drives) {
    EXPECT_EQ(fascicle_solver_start_clip(solver, nullptr, nullptr), FASCICLE_OK);
  }
  for (int k = 0; k < 6; ++k)
    EXPECT_EQ(by_drives ? fascicle_solver_step_drive(solver, &drive) : fascicle_solver_step_clip(solver),
              FASCICLE_OK)
        << fascicle_last_message();
  char text[17];
  EXPECT_EQ(fascicle_solver_position_hash(solver, text), FASCICLE_OK);
  return text;
}

TEST(Arrays, AModelOfArraysMovesAsTheOneTheyWereTakenFrom) {
  fascicle_model* built = built_bar();
  ASSERT_EQ(fascicle_model_substeps(built), 1u) << "the drives below have one";
  const std::vector<fascicle_array> arrays = arrays_of(built);
  fascicle_model* copy = nullptr;
  ASSERT_EQ(fascicle_model_create(arrays.data(), arrays.size(), &copy), FASCICLE_OK)
      << fascicle_last_message();
  EXPECT_EQ(fascicle_model_vertex_count(copy), 45u);
  EXPECT_EQ(fascicle_model_substeps(copy), 0u);
  fascicle_device* device = nullptr;
  ASSERT_EQ(fascicle_device_open("cpu", nullptr, &device), FASCICLE_OK);
  fascicle_solver *of_scene = nullptr, *of_arrays = nullptr;
  ASSERT_EQ(fascicle_solver_create(built, device, nullptr, &of_scene), FASCICLE_OK);
  ASSERT_EQ(fascicle_solver_create(copy, device, nullptr, &of_arrays), FASCICLE_OK);
  // In any order of destruction: a solver keeps what it needs.
  fascicle_model_destroy(built);
  fascicle_model_destroy(copy);
  fascicle_device_destroy(device);
  const std::string moved = hash_after(of_scene, false);
  EXPECT_EQ(hash_after(of_arrays, true), moved);
  EXPECT_EQ(fascicle_solver_start_clip(of_arrays, nullptr, nullptr), FASCICLE_BAD_ARGUMENT);
  EXPECT_NE(std::string(fascicle_last_message()).find("fascicle_solver_step_drive"), std::string::npos);
  fascicle_solver_destroy(of_scene);
  fascicle_solver_destroy(of_arrays);
}

TEST(Arrays, WrongOnesAreNamed) {
  fascicle_model* built = built_bar();
  const std::vector<fascicle_array> good = arrays_of(built);
  const auto refused = [&](const char* part, auto change) {
    std::vector<fascicle_array> arrays = good;
    change(arrays);
    fascicle_model* model = nullptr;
    EXPECT_EQ(fascicle_model_create(arrays.data(), arrays.size(), &model), FASCICLE_BAD_ARGUMENT) << part;
    EXPECT_NE(std::string(fascicle_last_message()).find(part), std::string::npos) << fascicle_last_message();
    EXPECT_EQ(model, nullptr);
  };
  using Arrays = std::vector<fascicle_array>;
  refused("share_taken", [](Arrays& a) { --named(a, "ring").count; });  // must match the ring
  refused("rest", [](Arrays& a) {
    a.erase(std::find_if(a.begin(), a.end(), [](auto& x) { return !std::strcmp(x.name, "rest"); }));
  });
  refused("\"rest\" has another type", [](Arrays& a) { named(a, "rest").type = FASCICLE_FLOAT64; });
  refused("\"rest\" is null", [](Arrays& a) { named(a, "rest").data = nullptr; });
  refused("no array \"flesh\"", [](Arrays& a) { named(a, "rest").name = "flesh"; });
  refused("given twice", [](Arrays& a) { a.push_back(a.front()); });
  refused("vertex_count", [](Arrays& a) { a.clear(); });
  const std::uint8_t two = 2;
  refused("must be 0 or 1", [&](Arrays& a) { named(a, "momentum_scaled").data = &two; });
  std::vector<std::uint32_t> ring(named(const_cast<Arrays&>(good), "ring").count, 999999);
  refused("ring", [&](Arrays& a) { named(a, "ring").data = ring.data(); });
  const double none = std::nan("");
  refused("layer.damping", [&](Arrays& a) { named(a, "layer.damping").data = &none; });
  refused("ends before its last text", [](Arrays& a) { --named(a, "layer.name").count; });
  // A list of as many layers as items would be many times as large as the array.
  const std::vector<double> damping(1000, 1.0);
  refused("at most 256 layers", [&](Arrays& a) {
    named(a, "layer.damping").data = damping.data(), named(a, "layer.damping").count = 1000;
  });
  refused("a count is larger", [](Arrays& a) { named(a, "rest").count = ~std::size_t{0} / 4; });
  // Solvers would allocate for these.
  const std::uint32_t many = 4000000000;
  for (const char* count : {"joint_count", "muscle_count", "force_count"})
    refused(count, [&](Arrays& a) { named(a, count).data = &many; });
  fascicle_array array{};
  EXPECT_EQ(fascicle_model_array(built, "flesh", &array), FASCICLE_BAD_ARGUMENT);
  EXPECT_EQ(fascicle_model_array(built, "rest", &array), FASCICLE_OK);
  EXPECT_EQ(array.count, 3u * 45u);
  fascicle_model_destroy(built);
}

TEST(Arrays, WrongDrivesAreRefused) {
  fascicle_model* built = built_bar();
  fascicle_solver* solver = nullptr;
  ASSERT_EQ(fascicle_solver_create(built, nullptr, nullptr, &solver), FASCICLE_OK) << fascicle_last_message();
  fascicle_drive drive = fascicle_drive_default();
  EXPECT_EQ(fascicle_solver_step_drive(solver, &drive), FASCICLE_BAD_ARGUMENT) << "h is 0";
  drive.h = 1.0 / 60.0;
  EXPECT_EQ(fascicle_solver_step_drive(solver, &drive), FASCICLE_BAD_ARGUMENT) << "no decay";
  drive.decay_count = 1;
  EXPECT_EQ(fascicle_solver_step_drive(solver, &drive), FASCICLE_BAD_ARGUMENT) << "decay is null";
  EXPECT_NE(std::string(fascicle_last_message()).find("drive.decay"), std::string::npos);
  EXPECT_EQ(fascicle_solver_step_drive(solver, nullptr), FASCICLE_BAD_ARGUMENT);
  const float still = 1.0F;
  drive.decay = &still;
  // Nothing interrupts a frame, and each frame of these would take a while.
  for (const std::uint32_t wrong : {0u, 1001u, 1000000u}) {
    drive.substeps = wrong;
    EXPECT_EQ(fascicle_solver_step_drive(solver, &drive), FASCICLE_BAD_ARGUMENT);
    EXPECT_NE(std::string(fascicle_last_message()).find("drive.substeps is " + std::to_string(wrong)),
              std::string::npos);
  }
  drive.substeps = 1000;
  EXPECT_EQ(fascicle_solver_step_drive(solver, &drive), FASCICLE_OK) << fascicle_last_message();
  drive.substeps = 1;
  // Counts are checked before they are used to allocate or read.
  const float one = 1.0F;
  drive.decay = drive.bones = drive.muscles = drive.forces = &one;
  std::size_t fascicle_drive::*const counts[] = {&fascicle_drive::bone_count, &fascicle_drive::muscle_count,
                                                 &fascicle_drive::force_count, &fascicle_drive::decay_count};
  for (const auto count : counts) {
    fascicle_drive wrong = drive;
    wrong.*count = ~std::size_t{0} / 64;
    EXPECT_EQ(fascicle_solver_step_drive(solver, &wrong), FASCICLE_BAD_ARGUMENT);
    EXPECT_NE(std::string(fascicle_last_message()).find("_count is "), std::string::npos)
        << fascicle_last_message();
  }
  EXPECT_EQ(fascicle_solver_step_drive(solver, &drive), FASCICLE_OK) << fascicle_last_message();
  fascicle_solver_options options = fascicle_solver_options_default();
  options.rotation = "euler";
  fascicle_solver* other = nullptr;
  EXPECT_EQ(fascicle_solver_create(built, nullptr, &options, &other), FASCICLE_BAD_ARGUMENT);
  options.rotation = nullptr;
  options.iterations = 1001;
  EXPECT_EQ(fascicle_solver_create(built, nullptr, &options, &other), FASCICLE_BAD_ARGUMENT);
  EXPECT_NE(std::string(fascicle_last_message()).find("options.iterations is 1001"), std::string::npos);
  options.iterations = 0;
  options.viscosity = -1.0;
  EXPECT_EQ(fascicle_solver_create(built, nullptr, &options, &other), FASCICLE_BAD_ARGUMENT);
  EXPECT_NE(std::string(fascicle_last_message()).find("options.viscosity is -1"), std::string::npos);
  fascicle_solver_destroy(other);
  fascicle_solver_destroy(solver);
  fascicle_model_destroy(built);
}

}  // namespace
}  // namespace fascicle_tests
