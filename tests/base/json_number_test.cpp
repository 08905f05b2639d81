#include "host/base/json_number.h"

#include <cstdint>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace fascicle::tests {
namespace {

template <class Integer>
std::optional<Integer> number_of(const char* text) {
  return base::whole_number<Integer>(nlohmann::json::parse(text));
}

TEST(JsonNumber, IsWholeAndInRange) {
  EXPECT_EQ(number_of<std::uint32_t>("4294967295"), 4294967295U);
  EXPECT_EQ(number_of<std::uint32_t>("0"), 0U);
  EXPECT_EQ(number_of<int>("-2147483648"), -2147483647 - 1);
  EXPECT_EQ(number_of<std::int64_t>("9223372036854775807"), INT64_MAX);
  EXPECT_EQ(number_of<std::uint64_t>("18446744073709551615"), UINT64_MAX);
}

TEST(JsonNumber, IsNothingElse) {
  for (const char* text : {"4294967296", "-1", "1e300", "-1e300", "1.0", "0.5", "18446744073709551616",
                           "null", "true", "\"1\"", "[1]", "{}"})
    EXPECT_FALSE(number_of<std::uint32_t>(text)) << text;
  EXPECT_FALSE(number_of<int>("2147483648"));
  EXPECT_FALSE(number_of<int>("-2147483649"));
  EXPECT_FALSE(number_of<std::int64_t>("9223372036854775808"));
}

}  // namespace
}  // namespace fascicle::tests
