// What the GPU room computes on the host: the sliced one-rings and the pace of submissions.
#include <gtest/gtest.h>

#include "gpu/sliced_rings.h"
#include "gpu/submission_pace.h"
#include "tests/gpu/bar_model.h"

namespace fascicle::tests {
namespace {

TEST(SlicedRings, HoldEachOneRingInOrder) {
  const model::Model m = make_bar({.x = 7, .y = 3, .z = 5, .odd_vertices = true});
  ASSERT_NE(m.vertex_count % shader::slice_width, 0u) << "the last slice should be a short one";
  const gpu::SlicedRings rings = gpu::slice_rings(m);
  EXPECT_EQ(rings.ring.size(), gpu::sliced_entry_count(m));
  EXPECT_EQ(rings.slice.size(), (m.vertex_count + shader::slice_width - 1) / shader::slice_width);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    std::size_t at = rings.slice[i / shader::slice_width] + i % shader::slice_width;
    for (std::uint32_t e = m.ring_offset[i]; e < m.ring_offset[i + 1]; ++e, at += shader::slice_width) {
      ASSERT_LT(at, rings.ring.size());
      EXPECT_EQ(rings.ring[at], m.ring[e]);
      EXPECT_EQ(rings.share_taken[at], m.share_taken[e]);
      EXPECT_EQ(rings.share_given[at], m.share_given[e]);
    }
  }
}

TEST(SubmissionPace, KeepsSubmissionsUnder100Milliseconds) {
  gpu::SubmissionPace pace(true);
  // A device that takes 1 ms a slice, then one that takes 1 us.
  pace.learn(1000, 1000 * 1e6);
  EXPECT_LE(static_cast<double>(pace.slices_per_submission()) * 1e6, 100e6);
  for (int k = 0; k < 100; ++k) pace.learn(1000, 1000 * 1e3);
  EXPECT_LE(static_cast<double>(pace.slices_per_submission()) * 1e3, 100e6);
  EXPECT_GT(pace.slices_per_submission(), 10'000u) << "a faster device was never believed";
  pace.learn(1000, 1000 * 1e9);
  EXPECT_EQ(pace.slices_per_submission(), 1u) << "a slice of a second must go alone, but go";
}

TEST(SubmissionPace, DoesNotLearnFromSmallSubmissions) {
  gpu::SubmissionPace pace(false);
  const std::uint64_t before = pace.slices_per_submission();
  pace.learn(1, 1e9);
  EXPECT_EQ(pace.slices_per_submission(), before);
}

}  // namespace
}  // namespace fascicle::tests
