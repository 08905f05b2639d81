// Hints for mistyped names: a slip is told from another word.
#include "host/base/nearest_name.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

const std::vector<std::string> keys{"file", "made", "paint", "clip", "resolution", "at"};

TEST(NearestName, KnowsSlips) {
  EXPECT_EQ(base::nearest_name("piant", keys), "paint");
  EXPECT_EQ(base::nearest_name("pain", keys), "paint");
  EXPECT_EQ(base::nearest_name("ta", keys), "at") << "one slip is near however short the name is";
  EXPECT_EQ(base::nearest_name("att", keys), "at");
  EXPECT_EQ(base::nearest_name("resulition", keys), "resolution");
}

// Two letters of five are another word: "joint" means no "paint".
TEST(NearestName, LeavesOtherWordsAlone) {
  EXPECT_EQ(base::nearest_name("joint", keys), "");
  EXPECT_EQ(base::nearest_name("tile_b", keys), "");
  EXPECT_EQ(base::nearest_name("resolved", keys), "");
  EXPECT_EQ(base::nearest_name("", keys), "");
  EXPECT_EQ(base::nearest_name("paint", {}), "");
}

TEST(NearestName, FindsWhatAnOwnerHas) {
  EXPECT_EQ(base::nearest_name("hand", {"land", "left/hand"}), "left/hand");
}

}  // namespace
}  // namespace fascicle::tests
