// Which devices the jobs of a batch may still use.
#include "host/cli/device_failures.h"

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using cli::DeviceFailures;
using Clock = DeviceFailures::Clock;

TEST(DeviceFailures, NoJobHasADeviceTwiceThatFailedIt) {
  DeviceFailures failures({"vulkan:0", "cpu"});
  failures.add(0, "vulkan:0", Clock::now(), false);
  EXPECT_FALSE(failures.may_have(0, "vulkan:0"));
  EXPECT_TRUE(failures.may_have(0, "cpu"));
  EXPECT_TRUE(failures.may_have(1, "vulkan:0"));
  failures.add(0, "cpu", Clock::now(), false);
  EXPECT_FALSE(failures.has_a_device(0));
}

TEST(DeviceFailures, TwoInARowAreTheEndOfADeviceButForTheLast) {
  DeviceFailures failures({"vulkan:0", "cpu"});
  failures.add(0, "vulkan:0", Clock::now(), false);
  failures.clear("vulkan:0");
  failures.add(1, "vulkan:0", Clock::now(), false);
  EXPECT_FALSE(failures.is_off("vulkan:0")) << "a success between the failures resets the count";
  failures.add(2, "vulkan:0", Clock::now(), false);
  EXPECT_TRUE(failures.is_off("vulkan:0"));
  EXPECT_FALSE(failures.may_have(9, "vulkan:0"));
  failures.add(3, "cpu", Clock::now(), false);
  failures.add(4, "cpu", Clock::now(), false);
  EXPECT_FALSE(failures.is_off("vulkan:0")) << "no better device is left";
  EXPECT_TRUE(failures.has_a_device(9));
}

TEST(DeviceFailures, WhatEndsSeveralBakesAtOnceIsOneFailure) {
  DeviceFailures failures({"vulkan:0", "cpu"});
  const Clock::time_point start = Clock::now();
  for (std::size_t job = 0; job < 8; ++job) failures.add(job, "vulkan:0", start, false);
  EXPECT_FALSE(failures.is_off("vulkan:0"));
  for (std::size_t job = 8; job < 16; ++job) failures.add(job, "vulkan:0", Clock::now(), true);
  EXPECT_FALSE(failures.is_off("vulkan:0")) << "models too large for it say nothing about others";
}

TEST(DeviceFailures, AutoHasTheCpuBehindIt) {
  DeviceFailures failures({"auto"});
  EXPECT_EQ(failures.device_of(0, "auto"), "auto");
  failures.add(0, "auto", Clock::now(), false);
  EXPECT_TRUE(failures.may_have(0, "auto"));
  EXPECT_EQ(failures.device_of(0, "auto"), "cpu");
  EXPECT_EQ(failures.device_of(1, "auto"), "auto");
  failures.add(0, "auto", Clock::now(), false);
  EXPECT_FALSE(failures.has_a_device(0));
}

}  // namespace
}  // namespace fascicle::tests
