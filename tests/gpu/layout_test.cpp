// Host-side computations of the GPU room: the sliced one-rings and the pace of submissions.
#include <bit>

#include <gtest/gtest.h>

#include "gpu/sliced_rings.h"
#include "gpu/submission_pace.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

// Every vertex's entries, in order, as the shaders read them.
void expect_rings_of(const model::Model& m) {
  const gpu::SlicedRings rings = gpu::slice_rings(m);
  const bool near = gpu::is_near(m);
  EXPECT_EQ(rings.share_taken.size(), gpu::sliced_entry_count(m));
  EXPECT_EQ(rings.ring.size(), near ? 0 : gpu::sliced_entry_count(m));
  EXPECT_EQ(rings.slice.size(), (m.vertex_count + shader::slice_width - 1) / shader::slice_width);
  const auto neighbour = [&](std::uint32_t i, std::size_t at, std::uint32_t word) {
    const auto difference = static_cast<std::int16_t>(word & 0xffffu);
    return near ? i / shader::slice_width * shader::slice_width + static_cast<std::uint32_t>(difference)
                : rings.ring[at];
  };
  const auto share = [&](std::uint32_t word) {
    return near ? static_cast<float>(word >> 16) * 0x1p-16f : std::bit_cast<float>(word);
  };
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    std::size_t at = rings.slice[i / shader::slice_width] + i % shader::slice_width;
    for (std::uint32_t e = m.ring_offset[i]; e < m.ring_offset[i + 1]; ++e, at += shader::slice_width) {
      ASSERT_LT(at, rings.share_given.size());
      ASSERT_EQ(neighbour(i, at, rings.share_taken[at]), m.ring[e]);
      ASSERT_EQ(neighbour(i, at, rings.share_given[at]), m.ring[e]);
      ASSERT_EQ(share(rings.share_taken[at]), m.share_taken[e]);
      ASSERT_EQ(share(rings.share_given[at]), m.share_given[e]);
    }
  }
}

TEST(SlicedRings, HoldEachOneRingInOrder) {
  const model::Model m = make_bar({.x = 7, .y = 3, .z = 5, .odd_vertices = true});
  ASSERT_NE(m.vertex_count % shader::slice_width, 0u) << "the last slice should be incomplete";
  EXPECT_TRUE(gpu::is_near(m));
  expect_rings_of(m);
}

TEST(SlicedRings, HoldNeighboursFarAwayAndWholeShares) {
  model::Model far = make_bar({.x = 7, .y = 3, .z = 5});
  far.share_given[3] = 1.0f;
  EXPECT_FALSE(gpu::is_near(far));
  expect_rings_of(far);
  // A bar with sides so wide that neighbours are 33,489 vertices apart.
  const model::Model wide = make_bar({.x = 3, .y = 183, .z = 183});
  EXPECT_FALSE(gpu::is_near(wide));
  expect_rings_of(wide);
}

TEST(SubmissionPace, KeepsSubmissionsUnder100Milliseconds) {
  gpu::SubmissionPace pace(true);
  // A device that takes 1 ms a slice, then one that takes 1 us.
  pace.learn(1000, 1000 * 1e6);
  EXPECT_LE(static_cast<double>(pace.slices_per_submission()) * 1e6, 100e6);
  for (int k = 0; k < 100; ++k) pace.learn(1000, 1000 * 1e3);
  EXPECT_LE(static_cast<double>(pace.slices_per_submission()) * 1e3, 100e6);
  EXPECT_GT(pace.slices_per_submission(), 10'000u) << "the pace did not adapt to a faster device";
  pace.learn(1000, 1000 * 1e9);
  EXPECT_EQ(pace.slices_per_submission(), 1u) << "a slice that takes a second must be submitted alone";
}

// A device stalls for a moment: another program uses it, or the machine sleeps.
TEST(SubmissionPace, RecoversFromAStall) {
  for (const bool software : {false, true})
    for (const double stall : {80e6, 2e9, 600e9}) {
      gpu::SubmissionPace pace(software);
      pace.learn(100, stall);
      EXPECT_LT(pace.slices_per_submission(), 64u);
      // A microsecond a slice; each submission is as large as allowed.
      for (int k = 0; k < 100; ++k) {
        const std::uint64_t slices = pace.slices_per_submission();
        pace.learn(slices, static_cast<double>(slices) * 1e3);
      }
      EXPECT_GT(pace.slices_per_submission(), 40'000u) << stall;
    }
}

TEST(SubmissionPace, DoesNotLearnFromSmallSubmissions) {
  gpu::SubmissionPace pace(false);
  const std::uint64_t before = pace.slices_per_submission();
  pace.learn(1, 1e9);
  EXPECT_EQ(pace.slices_per_submission(), before);
}

}  // namespace
}  // namespace fascicle::tests
