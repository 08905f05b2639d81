// Hints for mistyped names: a typo is told apart from a different word.
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
  EXPECT_EQ(base::nearest_name("ta", keys), "at") << "one typo is near, however short the name";
  EXPECT_EQ(base::nearest_name("att", keys), "at");
  EXPECT_EQ(base::nearest_name("resulition", keys), "resolution");
}

// Two changed letters of five make a different word: "joint" is not a typo of "paint".
TEST(NearestName, LeavesOtherWordsAlone) {
  EXPECT_EQ(base::nearest_name("joint", keys), "");
  EXPECT_EQ(base::nearest_name("tile_b", keys), "");
  EXPECT_EQ(base::nearest_name("resolved", keys), "");
  EXPECT_EQ(base::nearest_name("", keys), "");
  EXPECT_EQ(base::nearest_name("paint", {}), "");
}

// Five letters are added to the first, a third of the whole; four of ten differ in the second, which is more.
TEST(NearestName, TakesTheNearestOfThoseThatAreNear) {
  EXPECT_EQ(base::nearest_name("collisions", {"collisions_only", "cxllxsxxns"}), "collisions_only");
}

TEST(NearestName, TakesTheFirstInATie) {
  EXPECT_EQ(base::nearest_name("paxnt", {"painting", "point", "paint", "pant"}), "paint");
  EXPECT_EQ(base::nearest_name("paxnt", {"pant", "paint"}), "pant");
}

TEST(NearestName, FindsWhatAnOwnerHas) {
  EXPECT_EQ(base::nearest_name("hand", {"land", "left/hand"}), "left/hand");
}

}  // namespace
}  // namespace fascicle::tests
