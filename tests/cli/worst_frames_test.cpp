// Which frames of a made-up metrics.csv are the worst.
#include "host/cli/worst_frames.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/bake.h"
#include "host/cli/metrics_table.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using Frames = std::vector<std::uint64_t>;

class WorstFrames : public testing::Test {
 protected:
  cli::FrameScores scores(const std::string& text) const {
    write_text(folder_ / "metrics.csv", text);
    return cli::read_frame_scores(folder_.path());
  }
  TemporaryFolder folder_;
};

TEST_F(WorstFrames, LookDecidesAndNeighboursAreLeftOut) {
  std::string text = "frame,time,inverted,inverted_skinned,look,worst_joint,look_stretch,look_jump\n";
  const std::vector<std::string> look{"0.1", "0.2", "3", "3.5", "3.2", "0.3", "0.9", "2", "0.4", "2"};
  for (std::size_t k = 0; k < look.size(); ++k)
    text += std::to_string(k) + ",0,900,0," + look[k] + ",\"shin, \"\"left\"\"\",0.1," + look[k] + "\n";
  const cli::FrameScores read = scores(text);
  EXPECT_TRUE(read.has_look);
  ASSERT_EQ(read.frames.size(), 10u);
  EXPECT_EQ(read.frames[3].look, 3.5);
  EXPECT_EQ(read.frames[3].cause, "jump");
  EXPECT_EQ(read.frames[3].joint, "shin, \"left\"");
  EXPECT_EQ(read.frames[0].cause, "stretch");  // a tie: the first column
  EXPECT_EQ(cli::worst_frames(read, 10, 3, 2), (Frames{3, 7, 0}));
  EXPECT_EQ(cli::worst_frames(read, 10, 3, 0), (Frames{3, 4, 2}));  // the control: neighbours are worse
  EXPECT_EQ(cli::worst_frames(read, 10, 9, 2), (Frames{3, 7, 0}));  // no more frames fit in between
  EXPECT_EQ(cli::worst_frames(read, 3, 9, 1), (Frames{2, 0}));      // frames that do not exist
}

TEST_F(WorstFrames, WithoutLookInvertedBeyondSkinningsAndThenLagDecide) {
  const cli::FrameScores read = scores(
      "frame,inverted,inverted_skinned,lag_fat,lag_muscle\n"
      "0,5,5,0.1,0.9\n"
      "1,50,60,0.2,0.1\n"
      "2,8,1,0,0\n"
      "3,9,1,0,0\n"
      "4,0,0,0.95,0\n"
      "5,nan,0,0,0\n"
      "6,9");  // truncated
  EXPECT_FALSE(read.has_look);
  ASSERT_EQ(read.frames.size(), 6u);
  EXPECT_EQ(cli::worst_frames(read, 6, 6, 0), (Frames{5, 3, 2, 4, 0, 1}));
  EXPECT_FALSE(read.frames[0].look.has_value());
}

TEST_F(WorstFrames, DistanceGrowsWithTheClipAndIsNeverBelowAFew) {
  EXPECT_EQ(cli::frames_apart(10, 6), 3u);
  EXPECT_EQ(cli::frames_apart(240, 6), 10u);
  EXPECT_EQ(cli::frames_apart(10, 0), 3u);
}

TEST_F(WorstFrames, WhatIsNoMetricsIsToldSo) {
  EXPECT_THROW(cli::read_frame_scores(folder_.path()), bake::BakeError);
  EXPECT_FALSE(cli::has_metrics(folder_.path()));
  EXPECT_THROW(scores(""), bake::BakeError);
  EXPECT_THROW(scores("a,b\n1,2\n"), bake::BakeError);
  EXPECT_TRUE(scores("frame,look\n").frames.empty());
}

// A report searches the columns for each of them.
TEST_F(WorstFrames, TooManyColumnsAreNoMetrics) {
  const auto refusal_by = [](const auto& read) -> std::string {
    try {
      read();
    } catch (const bake::BakeError& error) {
      return error.what();
    }
    return "read";
  };
  const auto refusal_of_scores = [&] {
    return refusal_by([&] { (void)cli::read_frame_scores(folder_.path()); });
  };
  const auto refusal_of_table = [&] {
    return refusal_by([&] { (void)cli::read_metrics_table(folder_.path()); });
  };
  const std::string most = "frame" + std::string(4095, ',');
  write_text(folder_ / "metrics.csv", most + "\n");
  EXPECT_EQ(refusal_of_scores(), "read");
  EXPECT_EQ(refusal_of_table(), "read");
  write_text(folder_ / "metrics.csv", most + ",\n");
  const std::string wanted = folder_ / "metrics.csv" + ": has 4097 columns, the most is 4,096; bake again";
  EXPECT_EQ(refusal_of_scores(), wanted);
  EXPECT_EQ(refusal_of_table(), wanted);
}

}  // namespace
}  // namespace fascicle::tests
