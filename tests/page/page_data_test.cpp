// Page data other than motion: text and curves.
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/base/errors.h"
#include "host/page/base64.h"
#include "host/page/curves.h"

namespace fascicle::page {
namespace {

namespace fs = std::filesystem;

// The test vectors of RFC 4648, section 10.
TEST(Base64, IsTheRfcs) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

class Curves : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  std::vector<Curve> of(const std::string& csv, std::uint64_t frames) const {
    std::ofstream(folder_ / "metrics.csv") << csv;
    return read_curves(folder_, frames);
  }
  const fs::path folder_ = fs::temp_directory_path() / ("fascicle-curves-" + std::to_string(getpid()));
};

TEST_F(Curves, AreTheColumnsInTheirUnits) {
  const auto curves =
      of("frame,time,kinetic_energy,volume_ratio,lag_fat,\"lag_a,b\",look\n"
         "0,0,1.5,0.99,0.002,0.5,0.3\n1,1,2,1,0.004,0,2\n",
         2);
  ASSERT_EQ(curves.size(), 5u);
  EXPECT_EQ(curves[0].name, "Lag of fat");
  EXPECT_EQ(curves[0].unit, "mm");
  EXPECT_DOUBLE_EQ(curves[0].values[1].value(), 4.0);
  EXPECT_EQ(curves[1].name, "Lag of a,b");
  EXPECT_EQ(curves[2].name, "Energy");
  EXPECT_DOUBLE_EQ(curves[3].values[0].value(), 99.0);
  EXPECT_EQ(curves[4].limit, 1.0);
}

TEST_F(Curves, WhatIsNoNumberOrNoFrameIsMissing) {
  const auto curves = of("frame,kinetic_energy\n0,1\n1,nan\n2,inf\n3\nx,5\n-1,5\n9e99,5\n4,7", 5);
  ASSERT_EQ(curves.size(), 1u);
  EXPECT_EQ(curves[0].values[0], 1.0);
  for (const std::size_t k : {1, 2, 3}) EXPECT_FALSE(curves[0].values[k].has_value()) << k;
  EXPECT_EQ(curves[0].values[4], 7.0);
}

TEST_F(Curves, ThatAreZeroOrNotThereAreNone) {
  EXPECT_TRUE(of("frame,kinetic_energy,inverted\n0,0,0\n", 1).empty());
  EXPECT_TRUE(of("", 3).empty());
  fs::remove(folder_ / "metrics.csv");
  EXPECT_TRUE(read_curves(folder_, 3).empty());
}

TEST_F(Curves, OfTooManyColumnsAreRefused) {
  const auto refusal_of = [&](const std::string& csv, std::uint64_t frames) -> std::string {
    try {
      of(csv, frames);
    } catch (const base::BakeError& error) {
      return error.what();
    }
    return "read";
  };
  std::string header = "frame";
  for (int k = 1; k < 4096; ++k) header += ",lag_" + std::to_string(k);
  EXPECT_EQ(refusal_of(header + "\n0,1\n", 2), "read");
  EXPECT_EQ(refusal_of(header + ",one_more\n0,1\n", 2),
            (folder_ / "metrics.csv").string() + ": has 4097 columns, the most is 4,096; bake again");
  // Not too many for 2 frames, but 655 GB of memory for ten million.
  EXPECT_EQ(
      refusal_of(header + "\n0,1\n", 10'000'001),
      (folder_ / "metrics.csv").string() +
          ": its columns of 10000001 frames are too many for a page; bake a shorter range (--start, --end)");
}

}  // namespace
}  // namespace fascicle::page
