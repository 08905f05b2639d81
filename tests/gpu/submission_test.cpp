// How work is split into submissions and dispatches, and how many frames are in flight: counted, and checked
// to have no effect on bits. With the limits of a real device, the tests' small bodies would never be split.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "gpu/experiments.h"
#include "gpu/sliced_rings.h"
#include "host/model/validate.h"
#include "tests/gpu/vulkan_device.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

constexpr model::Read all_but_skinned{.positions = true, .velocities = true, .surface = true};

struct Counts {
  std::vector<std::uint64_t> slices;  // per submission
  std::vector<std::uint32_t> groups;  // per dispatch
  std::size_t slots = 0;

  gpu::Experiments watching(gpu::SubmissionLimits limits = {}) {
    return {.limits = limits,
            .on_submission = [this](std::uint64_t n) { slices.push_back(n); },
            .on_dispatch = [this](std::uint32_t n) { groups.push_back(n); },
            .on_new_slot = [this] { ++slots; }};
  }
};

class Submissions : public VulkanTest {
 protected:
  // 385 vertices: 13 slices a stage, the last one incomplete.
  const model::Model model =
      make_bar({.x = 11, .y = 7, .z = 5, .skeleton = true, .muscle = true, .forces = true, .ties = true});
  static constexpr std::uint64_t slices_of_stage = 13;

  void expect_bits_of_cpu(const gpu::Experiments& experiments) {
    gpu::Device device(*index);
    const auto cpu = cpu_reference::make_cpu_solver(model, {}, 1);
    {
      const auto vulkan = gpu::make_experimental_solver(device, model, {}, experiments);
      BarMotion motion(model, 3);
      for (std::uint64_t k = 1; k <= 4; ++k) {
        const model::Drive drive = motion.drive(k);
        vulkan->submit(drive, all_but_skinned);
        cpu->submit(drive, all_but_skinned);
        const model::Frame ours = vulkan->collect(), reference = cpu->collect();
        ASSERT_EQ(ours.positions, reference.positions) << "frame " << k;
        ASSERT_EQ(ours.velocities, reference.velocities) << "frame " << k;
        ASSERT_EQ(ours.surface, reference.surface) << "frame " << k;
      }
    }
    // The same stage by stage, where stages are split too.
    const auto vulkan = gpu::make_experimental_solver(device, model, {}, experiments);
    const auto fresh = cpu_reference::make_cpu_solver(model, {}, 1);
    BarMotion motion(model, 2);
    EXPECT_FALSE(first_difference(
        *fresh, *vulkan, [&](std::uint64_t k) { return motion.drive(k); }, 3));
  }
};

TEST_F(Submissions, WithoutLimitsAFrameOfASmallBodyIsOne) {
  Counts counts;
  gpu::Device device(*index);
  const auto vulkan = gpu::make_experimental_solver(device, model, {}, counts.watching());
  BarMotion motion(model, 3);
  vulkan->submit(motion.drive(1), all_but_skinned);
  EXPECT_EQ(counts.slices.size(), 1u);
  // skin, tie, region and update of each substep; embed has 37 render vertices, two slices.
  EXPECT_EQ(counts.slices[0], 3 * 4 * slices_of_stage + 2);
  EXPECT_EQ(counts.groups.size(), 13u);
}

TEST_F(Submissions, HoldNoMoreSlicesThanAllowedAndKeepTheBits) {
  Counts counts;
  expect_bits_of_cpu(counts.watching({.slices_per_submission = 7}));
  EXPECT_EQ(*std::max_element(counts.slices.begin(), counts.slices.end()), 7u);
  // Four frames of 3 substeps with just 3 stages have 468 slices.
  EXPECT_GE(counts.slices.size(), 468u / 7u);
}

TEST_F(Submissions, DispatchesHoldNoMoreGroupsThanAllowedAndKeepTheBits) {
  Counts counts;
  expect_bits_of_cpu(counts.watching({.groups_per_dispatch = 3}));
  EXPECT_EQ(*std::max_element(counts.groups.begin(), counts.groups.end()), 3u);
  EXPECT_GE(counts.groups.size(), 468u / 3u);
}

TEST_F(Submissions, OfOneSliceEachKeepTheBits) {
  Counts counts;
  expect_bits_of_cpu(counts.watching({.slices_per_submission = 1, .groups_per_dispatch = 1}));
  EXPECT_EQ(*std::max_element(counts.slices.begin(), counts.slices.end()), 1u);
}

// Workgroups of several slices, reading several neighbours at a time, and neighbours that do not fit into 16
// bits do not change the result, even where a stage is split.
TEST_F(Submissions, OfAnyTuningKeepTheBits) {
  for (const gpu::Tuning tuning : {gpu::Tuning{64, 2}, gpu::Tuning{128, 4}, gpu::Tuning{96, 7}}) {
    Counts counts;
    gpu::Experiments experiments = counts.watching({.slices_per_submission = 7, .groups_per_dispatch = 3});
    experiments.tuning = tuning;
    expect_bits_of_cpu(experiments);
    EXPECT_GT(counts.groups.size(), 468u * shader::slice_width / tuning.group_size / 3);
  }
  // Also iterate, which only the implicit integrator has, in dispatches without a probe.
  const model::Model implicit = make_bar({.x = 11, .y = 7, .z = 5, .implicit = true});
  const model::SolverOptions options{.integrator = model::Integrator::implicit_step, .iterations = 4};
  gpu::Device device(*index);
  const auto cpu = cpu_reference::make_cpu_solver(implicit, options, 1);
  const auto vulkan =
      gpu::make_experimental_solver(device, implicit, options, {.tuning = gpu::Tuning{64, 4}});
  BarMotion motion(implicit, 3);
  for (std::uint64_t k = 1; k <= 3; ++k) {
    const model::Drive drive = motion.drive(k);
    cpu->submit(drive, {.positions = true});
    vulkan->submit(drive, {.positions = true});
    ASSERT_EQ(cpu->collect().positions, vulkan->collect().positions) << "frame " << k;
  }
}

TEST_F(Submissions, OfNeighboursThatAreNotNearKeepTheBits) {
  ASSERT_TRUE(gpu::is_near(model));
  model::Model far = model;
  // A region takes all of a vertex and gives nothing back: a share of 1 does not fit into 16 bits.
  far.share_given[0] = 1.0f;
  ASSERT_FALSE(gpu::is_near(far));
  gpu::Device device(*index);
  for (const gpu::Tuning tuning : {gpu::Tuning{}, gpu::Tuning{64, 4}}) {
    const auto cpu = cpu_reference::make_cpu_solver(far, {}, 1);
    const auto vulkan = gpu::make_experimental_solver(device, far, {}, {.tuning = tuning});
    BarMotion motion(far, 2);
    EXPECT_FALSE(first_difference(
        *cpu, *vulkan, [&](std::uint64_t k) { return motion.drive(k); }, 3));
  }
}

// Uncollected frames do not pile up on the device; they are kept in order.
TEST_F(Submissions, OnlySoManyFramesAreUnderWayAndTheOrderStays) {
  Counts counts;
  gpu::Device device(*index);
  const auto vulkan = gpu::make_experimental_solver(device, model, {}, counts.watching());
  const auto cpu = cpu_reference::make_cpu_solver(model, {}, 1);
  BarMotion motion(model, 2);
  constexpr std::uint64_t frames = 3 * gpu::most_frames_in_flight;
  for (std::uint64_t k = 1; k <= frames; ++k) {
    const model::Drive drive = motion.drive(k);
    vulkan->submit(drive, all_but_skinned);
    cpu->submit(drive, all_but_skinned);
  }
  EXPECT_EQ(counts.slots, gpu::most_frames_in_flight);
  for (std::uint64_t k = 1; k <= frames; ++k) {
    const model::Frame ours = vulkan->collect(), reference = cpu->collect();
    ASSERT_EQ(ours.index, k);
    ASSERT_EQ(ours.origin, reference.origin);
    ASSERT_EQ(ours.positions, reference.positions) << "frame " << k;
  }
  EXPECT_THROW(vulkan->collect(), std::logic_error);
}

TEST(BufferPlan, CountsFramesInFlightAgainstTheMemory) {
  const model::Model m = make_bar({});
  const std::vector<gpu::PlannedBuffer> plan = gpu::plan_buffers(m);
  gpu::DeviceInfo info;
  info.name = "a device";
  info.max_storage_buffer_range = 1 << 27;
  for (const gpu::PlannedBuffer& buffer : plan) info.memory += buffer.bytes;
  EXPECT_NO_THROW(gpu::check_plan(plan, 0, info));
  try {
    gpu::check_plan(plan, 1000, info);
    FAIL() << "accepted 1,000 bytes more than available";
  } catch (const gpu::DeviceError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find(std::to_string(info.memory + 1000) + " bytes (1000 of them for frames in flight)"),
              std::string::npos)
        << what;
  }
}

// Experiments cannot be used by accident: in shipped code, only the file that defines them includes the
// header.
TEST(Experiments, AreKnownToTheSolverAndToTestsOnly) {
  const std::filesystem::path root = FASCICLE_SOURCE_DIR;
  std::vector<std::string> including;
  for (const char* room : {"host", "cpu_reference", "gpu", "shaders"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path());
      const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
      if (text.find("\"gpu/experiments.h\"") != std::string::npos)
        including.push_back(std::filesystem::relative(entry.path(), root).string());
    }
  EXPECT_EQ(including, std::vector<std::string>{"gpu/vulkan_solver.cpp"});
}

}  // namespace
}  // namespace fascicle::tests
