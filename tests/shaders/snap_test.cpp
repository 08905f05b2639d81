#include <bit>
#include <limits>

#include <gtest/gtest.h>

#include "shaders/kernel/scalar.inc"
#include "tests/shaders/decay_under_flush.h"

namespace fascicle::tests {
namespace {

TEST(Snap, ValuesBelowTheThresholdBecomePositiveZero) {
  for (const float x : {0x1.fffffep-41f, -0x1.fffffep-41f, 1e-40f, -1e-45f, -0.0f, 0.0f})
    EXPECT_EQ(std::bit_cast<std::uint32_t>(kernel::snap<float>(x)), 0u) << x;
  for (const float x : {0x1p-40f, -0x1p-40f, 1.0f, -3e38f, std::numeric_limits<float>::infinity()})
    EXPECT_EQ(kernel::snap<float>(x), x);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(kernel::snap<float>(nan), kernel::snap<float>(nan));
}

// Results must not depend on a device's treatment of denormals, so they are the same whether or not this CPU
// flushes them.
TEST(Snap, HidesWhetherTheDeviceFlushesDenormals) {
  EXPECT_EQ(decay_with_snap(true), decay_with_snap(false));
}

// The control: without the snap, flushing changes them.
TEST(Snap, WithoutItFlushingIsSeen) {
  EXPECT_NE(decay_without_snap(true), decay_without_snap(false));
}

}  // namespace
}  // namespace fascicle::tests
