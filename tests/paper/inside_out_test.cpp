// A character without a scene file: hardly more tetrahedra are inverted than by skinning alone, and none stay
// so. Needs ../shared/assets.
#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "tests/paper/character_run.h"
#include "tests/support/assets.h"

namespace fascicle::tests {

namespace {

std::uint64_t inside_out(const model::Model& model, const std::vector<float>& positions) {
  const auto at = [&](std::size_t t, std::size_t k, std::size_t axis) {
    return double{positions[3 * std::size_t{model.tetrahedron[t + k]} + axis]};
  };
  std::uint64_t count = 0;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    double e[3][3];
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis) e[k][axis] = at(t, k + 1, axis) - at(t, 0, axis);
    const double volume = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                          e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    count += volume > 0.0 ? 0 : 1;
  }
  return count;
}

struct Count {
  std::uint64_t frames = 0;       // with over 1.2 times as many inverted as by skinning alone
  std::uint64_t by_skinning = 0;  // summed over all frames
  std::uint64_t at_the_end = 0;
};

// Stops early once more than `enough` frames are as bad.
Count count(const char* file, const char* clip, const std::vector<std::string>& set,
            std::uint64_t enough = std::numeric_limits<std::uint64_t>::max()) {
  Count result;
  run_character(file, {.set = set, .clip = clip},
                [&](const model::Model& model, const rig::Character&, const model::Frame& frame) {
                  result.at_the_end = inside_out(model, frame.positions);
                  const std::uint64_t skinned = inside_out(model, frame.skinned);
                  result.frames += 5 * result.at_the_end > 6 * skinned ? 1 : 0;
                  result.by_skinning += skinned;
                  return result.frames <= enough;
                });
  return result;
}

Count expect_no_more_than_skinning(const char* file, const char* clip) {
  const Count found = count(file, clip, {});
  EXPECT_GT(found.by_skinning, 0u);
  EXPECT_EQ(found.frames, 0u);
  return found;
}

// A heavy man's jump ends in the bind pose, more than a second after the landing.
TEST(InsideOut, AHeavyMansJumpTurnsNoMoreTetrahedraThanSkinning) {
  FASCICLE_NEEDS_ASSET(asset("mh_fat.glb"));
  EXPECT_EQ(expect_no_more_than_skinning("mh_fat.glb", "jump").at_the_end, 0u);
}

// Flesh with the stiffness of real tissue, which is crushed when he crouches and lands. The control: without
// a least volume it inverts.
TEST(InsideOutSoak, TissuesBearAHeavyMansJump) {
  FASCICLE_NEEDS_ASSET(asset("mh_fat.glb"));
  std::vector<std::string> tissues{"layers.fat.material=fat", "layers.muscle.material=relaxed-muscle"};
  EXPECT_EQ(count("mh_fat.glb", "jump", tissues).frames, 0u);
  tissues.insert(tissues.end(), {"layers.fat.least_volume=0", "layers.muscle.least_volume=0"});
  EXPECT_GT(count("mh_fat.glb", "jump", tissues, 20).frames, 20u);
}

// The same for the explicit integrator.
TEST(InsideOutSoak, AnExplicitHeavyMansJumpTurnsNoMoreTetrahedraThanSkinning) {
  FASCICLE_NEEDS_ASSET(asset("mh_fat.glb"));
  EXPECT_EQ(count("mh_fat.glb", "jump", {"solver.integrator=explicit"}).frames, 0u);
  // The control: flesh without a volume term, which swings for longer, inverts.
  EXPECT_GT(count("mh_fat.glb", "jump",
                  {"solver.integrator=explicit", "layers.fat.volume=0", "layers.muscle.volume=0",
                   "layers.fat.damping=6", "layers.muscle.damping=6", "solver.substeps=8"},
                  5)
                .frames,
            5u);
}

TEST(InsideOutSoak, AMuscularMansJumpTurnsNoMoreTetrahedraThanSkinning) {
  FASCICLE_NEEDS_ASSET(asset("mh_muscle.glb"));
  EXPECT_EQ(expect_no_more_than_skinning("mh_muscle.glb", "jump").at_the_end, 0u);
}

// A loop cut from a run: its first and last frames are in full motion.
TEST(InsideOutSoak, AFoxsGallopTurnsNoMoreTetrahedraThanSkinning) {
  FASCICLE_NEEDS_ASSET(asset("animals_pack_Fox.glb"));
  expect_no_more_than_skinning("animals_pack_Fox.glb", "AnimalArmature|Gallop");
}

}  // namespace

}  // namespace fascicle::tests
