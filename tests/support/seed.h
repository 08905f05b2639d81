// Seeds of tests that draw random cases.
#pragma once

#include <cstdint>

#include <gtest/gtest.h>

namespace fascicle::tests {

// `own` in every run, so that CI is repeatable. With --gtest_shuffle, another one for each --gtest_repeat.
inline std::uint64_t seed_of_run(std::uint64_t own) {
  return own + static_cast<std::uint64_t>(testing::UnitTest::GetInstance()->random_seed());
}

}  // namespace fascicle::tests
