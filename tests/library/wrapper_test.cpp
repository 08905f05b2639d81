// fascicle.hpp: what it adds to the C API, which is ownership and exceptions.
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "include/fascicle/fascicle.hpp"
#include "tests/library/shell.h"

namespace fascicle_tests {
namespace {

TEST(Wrapper, ErrorsCarryStatusAndMessage) {
  try {
    const fascicle::scene scene("no-such-scene");
    FAIL();
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_BAD_INPUT);
    EXPECT_NE(std::string(error.what()).find("no such scene"), std::string::npos);
  }
  EXPECT_THROW(fascicle::device("gpu"), fascicle::error);
}

TEST(Wrapper, HandlesMove) {
  fascicle::scene scene = fascicle::scene::parse(small_bar);
  fascicle::scene moved = std::move(scene);
  EXPECT_EQ(moved.frame_count(), 6u);
  EXPECT_EQ(scene.get(), nullptr);
  fascicle::model model(moved);
  fascicle::solver solver(model, fascicle::device("cpu"));
  fascicle::solver other = std::move(solver);
  other.start_clip();
  other.step_clip();
  EXPECT_EQ(other.positions().size(), 3u * model.vertex_count());
}

TEST(Wrapper, ABakeTellsAndIsCancelled) {
  const Folder folder;
  const fascicle::scene scene = fascicle::scene::parse(small_bar);
  std::vector<std::string> said;
  std::uint64_t frames = 0;
  fascicle::bake_options options{.folder = folder / "a", .formats = {"pc2"}, .device = "cpu", .cache = ""};
  options.log = [&](fascicle_severity, const std::string& text) { said.push_back(text); };
  options.progress = [&](fascicle_phase phase, std::uint64_t, std::uint64_t) {
    frames += phase == FASCICLE_PHASE_FRAMES ? 1 : 0;
    return true;
  };
  const fascicle::bake_result bake = fascicle::bake(scene, options);
  EXPECT_EQ(frames, 6u);
  EXPECT_EQ(bake.frames(), 6u);
  EXPECT_FALSE(said.empty());
  EXPECT_FALSE(bake.files().empty());
  options.folder = folder / "b";
  options.progress = [](fascicle_phase phase, std::uint64_t, std::uint64_t) {
    return phase != FASCICLE_PHASE_FRAMES;
  };
  try {
    (void)fascicle::bake(scene, options);
    FAIL();
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_CANCELLED);
  }
}

TEST(Wrapper, WhatACallbackThrowsComesOut) {
  const Folder folder;
  const fascicle::scene scene = fascicle::scene::parse(small_bar);
  fascicle::bake_options options{.folder = folder / "a", .device = "cpu", .cache = ""};
  options.progress = [](fascicle_phase phase, std::uint64_t done, std::uint64_t) {
    if (phase == FASCICLE_PHASE_FRAMES && done == 2) throw std::domain_error("mine");
    return true;
  };
  EXPECT_THROW((void)fascicle::bake(scene, options), std::domain_error);
  options = {.folder = folder / "b", .device = "cpu", .cache = ""};
  options.log = [](fascicle_severity, const std::string&) { throw std::domain_error("mine"); };
  EXPECT_THROW((void)fascicle::bake(scene, options), std::domain_error);
}

TEST(Wrapper, AModelGoesThroughItsArrays) {
  const fascicle::model model(fascicle::scene::parse(small_bar));
  const fascicle::model copy(model.arrays());
  EXPECT_EQ(copy.vertex_count(), model.vertex_count());
  EXPECT_EQ(copy.array("mass").count, 45u);
  EXPECT_THROW((void)copy.array("flesh"), fascicle::error);
}

}  // namespace
}  // namespace fascicle_tests
