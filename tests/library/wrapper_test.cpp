// fascicle.hpp: what it adds to the C API: ownership and exceptions.
#include <cmath>
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

// By a function, because linters refuse what two tests do.
template <class Handle>
Handle taken_from(Handle& handle) {
  return std::move(handle);
}

TEST(Wrapper, HandlesMove) {
  fascicle::scene scene = fascicle::scene::parse(small_bar);
  fascicle::scene moved = taken_from(scene);
  EXPECT_EQ(moved.frame_count(), 6u);
  EXPECT_EQ(scene.get(), nullptr);
  fascicle::model model(moved);
  fascicle::solver solver(model, fascicle::device("cpu"));
  fascicle::solver other = std::move(solver);
  other.start_clip();
  other.step_clip();
  EXPECT_EQ(other.positions().size(), 3u * model.vertex_count());
}

template <class Work>
void expect_bad_argument(const char* part, const Work& work) {
  try {
    work();
    ADD_FAILURE() << "accepted: " << part;
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_BAD_ARGUMENT) << part;
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(Wrapper, HandlesThatWereMovedFromAreRefused) {
  const Folder folder;
  fascicle::scene scene = fascicle::scene::parse(small_bar);
  fascicle::model model(scene, {.cache = ""});
  fascicle::device device("cpu");
  fascicle::solver solver(model, device);
  fascicle::bake_result bake = fascicle::bake(scene, {.folder = folder / "a", .device = "cpu", .cache = ""});
  const fascicle::device other = taken_from(device);
  // It would open "auto".
  expect_bad_argument("device was moved", [&] { fascicle::solver(model, device); });
  expect_bad_argument("device was moved", [&] { (void)device.text(); });
  const fascicle::solver moved = taken_from(solver);
  expect_bad_argument("solver was moved", [&] { (void)solver.device_text(); });
  expect_bad_argument("solver is null", [&] { solver.step_clip(); });
  const fascicle::bake_result kept = taken_from(bake);
  expect_bad_argument("bake_result was moved", [&] { (void)bake.position_hash(); });
  EXPECT_TRUE(bake.files().empty());
  const fascicle::scene last = taken_from(scene);
  expect_bad_argument("scene was moved", [&] { (void)scene.name(); });
  EXPECT_THROW((void)scene.joint_name(0), std::out_of_range);
  expect_bad_argument("scene is null", [&] { fascicle::model{scene}; });
  EXPECT_EQ(last.name(), "scene");
}

// C would read such a text up to its NUL, and NaN as "not given".
TEST(Wrapper, TextsWithNulAndNumbersThatAreNaNAreRefused) {
  using namespace std::string_literals;
  const Folder folder;
  const fascicle::scene scene = fascicle::scene::parse(small_bar);
  const fascicle::model model(scene, {.cache = ""});
  const std::string cut = "cpu\0junk"s;
  expect_bad_argument("name holds a NUL", [&] { fascicle::scene("arm\0junk"s); });
  expect_bad_argument("text holds a NUL", [&] { (void)fascicle::scene::parse(small_bar + "\0junk"s); });
  expect_bad_argument("folder holds a NUL", [&] { (void)fascicle::scene::parse(small_bar, cut); });
  expect_bad_argument("set holds a NUL",
                      [&] { (void)fascicle::scene::parse(small_bar, "", {.set = {"scene.fps=30\0"s}}); });
  expect_bad_argument("clip holds a NUL", [&] { fascicle::scene("arm", {.clip = "0\0"s}); });
  expect_bad_argument("device holds a NUL",
                      [&] { (void)fascicle::bake(scene, {.folder = folder / "a", .device = cut}); });
  expect_bad_argument("folder holds a NUL",
                      [&] { (void)fascicle::bake(scene, {.folder = folder / "a" + cut}); });
  expect_bad_argument("name holds a NUL", [&] { (void)fascicle::device(cut); });
  expect_bad_argument("cache holds a NUL", [&] { fascicle::model(scene, {.cache = cut}); });
  expect_bad_argument("name holds a NUL", [&] { (void)model.array("rest\0"s); });
  const double none = std::nan("");
  expect_bad_argument("fps is NaN", [&] { (void)fascicle::scene::parse(small_bar, "", {.fps = none}); });
  expect_bad_argument("glb_error is NaN", [&] {
    (void)fascicle::bake(scene, {.folder = folder / "a", .device = "cpu", .glb_error = none});
  });
  expect_bad_argument("viscosity is NaN",
                      [&] { fascicle::solver(model, fascicle::device("cpu"), {.viscosity = none}); });
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

TEST(Wrapper, ABuildIsCancelledByItsCallbacks) {
  const fascicle::scene scene = fascicle::scene::parse(small_bar);
  try {
    const fascicle::model model(scene, {.cache = "", .progress = [](auto...) { return false; }});
    FAIL() << "it was built";
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_CANCELLED) << error.what();
  }
  const auto fail = [](fascicle_phase, std::uint64_t, std::uint64_t) -> bool {
    throw std::domain_error("mine");
  };
  EXPECT_THROW(fascicle::model(scene, {.cache = "", .progress = fail}), std::domain_error);
  std::size_t asked = 0;
  const fascicle::model model(scene, {.cache = "", .progress = [&](auto...) { return ++asked > 0; }});
  EXPECT_GT(asked, 1u);
  EXPECT_EQ(model.vertex_count(), 45u);
}

// Solver options override those of the scene, with the same bits as a scene that sets them.
TEST(Wrapper, SolverOptionsAreTaken) {
  const fascicle::device cpu("cpu");
  const auto hash = [&](const std::vector<std::string>& set, const fascicle::solver_options& options) {
    const fascicle::model model(fascicle::scene::parse(small_bar, "", {.set = set}), {.cache = ""});
    fascicle::solver solver(model, cpu, options);
    solver.start_clip();
    for (int frame = 0; frame < 3; ++frame) solver.step_clip();
    return solver.position_hash();
  };
  EXPECT_EQ(hash({}, {.rotation = "mueller2016"}), hash({"solver.rotation=mueller2016"}, {}));
  EXPECT_NE(hash({}, {.rotation = "mueller2016"}), hash({}, {}));
  const std::vector<std::string> soft{"layers.flesh={youngs_modulus=3e4}"};
  std::vector<std::string> few = soft;
  few.push_back("solver.iterations=3");
  EXPECT_EQ(hash(soft, {.iterations = 3}), hash(few, {}));
  EXPECT_NE(hash(soft, {.iterations = 3}), hash(soft, {}));
  std::vector<std::string> viscous = soft;
  viscous.push_back("solver.viscosity=0.003");
  EXPECT_EQ(hash(soft, {.viscosity = 0.003}), hash(viscous, {}));
  EXPECT_NE(hash(soft, {.viscosity = 0.003}), hash(soft, {}));
  EXPECT_THROW(hash({}, {.rotation = "polar"}), fascicle::error);
  EXPECT_THROW(hash({}, {.iterations = 0}), fascicle::error);
}

}  // namespace
}  // namespace fascicle_tests
