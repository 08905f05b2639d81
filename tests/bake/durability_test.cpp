// A power cut at any moment: no published file is torn, and the resumed bake gives the same bytes. Checked
// from outside, through the system calls of a bake.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/checkpoint_pace.h"
#include "host/bake/outputs.h"
#include "tests/bake/fake_bakes.h"
#include "tests/bake/traced_disk.h"

#define NEEDS_STRACE()                                                        \
  do {                                                                        \
    const std::string without = fascicle::tests::why_no_strace();             \
    if (!without.empty()) GTEST_SKIP() << "SKIPPED, NOT TESTED: " << without; \
  } while (false)

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* folder_variable = "FASCICLE_TRACED_BAKE";
constexpr std::uint64_t traced_frames = 9;

bake::BakeOptions traced_options(const fs::path& folder) {
  bake::BakeOptions options = options_for(folder);
  options.checkpoint_frames = 3;
  options.checkpoint_seconds = 1e9;
  return options;
}

// Not a test by itself: the process that the others trace.
TEST(Durability, DISABLED_TracedBake) {
  const char* folder = std::getenv(folder_variable);
  ASSERT_NE(folder, nullptr);
  fake_bake_into(traced_options(folder), short_scene(traced_frames));
}

std::vector<DiskCall> traced_bake(const fs::path& folder) {
  return traced(std::string(folder_variable) + "=" + folder.string() + " " +
                    fs::read_symlink("/proc/self/exe").string() +
                    " --gtest_also_run_disabled_tests --gtest_filter=Durability.DISABLED_TracedBake",
                folder);
}

// A resumed bake restarts these files, so nothing depends on them before the end.
bool counts(const std::string& name, bool at_end) {
  const bool begins_anew =
      name.starts_with("surface.glb") || name.starts_with("surface.usda") || name.starts_with("surface.abc");
  return at_end || !begins_anew;
}

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

bool is_published(const std::string& name) {
  for (const char* other : {".part", ".tmp", "frames.fascicle", "checkpoint", "manifest.json"})
    if (name.ends_with(other)) return false;
  return true;
}

// What may be left after a power cut: lists torn files, and checks that a resumed bake gives the same bytes.
class Cut {
 public:
  explicit Cut(const fs::path& whole) : content_(content_of(whole)) {}

  std::vector<std::string> torn(const Disk::Files& files) const {
    std::vector<std::string> names;
    for (const auto& [name, bytes] : files)
      if (is_published(name) &&
          std::find(content_.begin(), content_.end(), std::pair(name, bytes)) == content_.end())
        names.push_back(name);
    return names;
  }

  bool goes_on_to_the_same_bytes(const Disk::Files& files) const {
    const TemporaryFolder folder;
    for (const auto& [name, bytes] : files) {
      fs::create_directories((folder / ("out/" + name)).parent_path());
      write_text(folder / ("out/" + name), bytes);
    }
    bake::BakeOptions options = traced_options(folder / "out");
    options.resume = true;
    fake_bake_into(options, short_scene(traced_frames));
    return content_of(folder / "out") == content_;
  }

 private:
  std::vector<std::pair<std::string, std::string>> content_;
};

TEST(Durability, NothingIsPublishedOrCountedOnBeforeItIsSafe) {
  NEEDS_STRACE();
  const TemporaryFolder folder;
  const std::vector<DiskCall> calls = traced_bake(folder / "out");
  EXPECT_EQ(joined_lines(wrong_orders(calls, folder / "out", counts)), "");
  // The traced calls account for every file.
  Disk disk(folder / "out");
  for (const DiskCall& call : calls) disk.apply(call);
  std::size_t compared = 0;
  for (const auto& item : fs::recursive_directory_iterator(folder / "out"))
    if (item.is_regular_file()) {
      EXPECT_EQ(disk.content(item.path().string()), read_text(item.path())) << item.path();
      ++compared;
    }
  EXPECT_GT(compared, 40u);
}

// The controls: each of these errors is detected.
TEST(Durability, AWrongOrderIsSeen) {
  NEEDS_STRACE();
  const TemporaryFolder folder;
  const std::vector<DiskCall> calls = traced_bake(folder / "out");
  const auto without_syncs_of = [&](const std::string& name) {
    std::vector<DiskCall> left = calls;
    const std::size_t count = std::erase_if(left, [&](const DiskCall& call) {
      return call.kind == DiskCall::Kind::sync && call.path == (folder / ("out" + name)).string();
    });
    EXPECT_GT(count, 0u) << name;
    return left;
  };
  for (const char* name : {"", "/frames.fascicle", "/metrics.csv.part", "/surface.pc2.part",
                           "/surface.glb.part", "/obj/frame_000004.obj.tmp", "/obj", "/vtu",
                           "/checkpoint.tmp", "/manifest.json.tmp", "/model.fascicle.tmp"})
    EXPECT_FALSE(wrong_orders(without_syncs_of(name), folder / "out", counts).empty()) << name;
  // A rename before the bytes are synced.
  std::vector<DiskCall> swapped = calls;
  const auto sync = std::find_if(swapped.begin(), swapped.end(), [&](const DiskCall& call) {
    return call.kind == DiskCall::Kind::sync && call.path.ends_with("frame_000004.obj.tmp");
  });
  const auto rename = std::find_if(swapped.begin(), swapped.end(), [&](const DiskCall& call) {
    return call.kind == DiskCall::Kind::rename && call.path.ends_with("frame_000004.obj.tmp");
  });
  ASSERT_LT(sync - swapped.begin(), rename - swapped.begin());
  ASSERT_NE(rename, swapped.end());
  sync->path = rename->to;
  std::rotate(sync, sync + 1, rename + 1);
  EXPECT_TRUE(
      contains(joined_lines(wrong_orders(swapped, folder / "out", counts)), "frame_000004.obj has its"));
  // A checkpoint before the frames it depends on.
  std::vector<DiskCall> early = calls;
  const auto last_sync = std::find_if(early.rbegin(), early.rend(), [&](const DiskCall& call) {
    return call.kind == DiskCall::Kind::rename && call.path.ends_with("checkpoint.tmp");
  });
  const auto frame = std::find_if(early.begin(), early.end(), [&](const DiskCall& call) {
    return call.kind == DiskCall::Kind::sync && call.path.ends_with("frames.fascicle");
  });
  ASSERT_NE(last_sync, early.rend());
  const DiskCall moved = *frame;
  early.erase(frame);
  const auto checkpoint = std::find_if(early.begin(), early.end(), [&](const DiskCall& call) {
    return call.kind == DiskCall::Kind::rename && call.path.ends_with("checkpoint.tmp");
  });
  early.insert(checkpoint + 1, moved);
  EXPECT_TRUE(
      contains(joined_lines(wrong_orders(early, folder / "out", counts)), "counts on frames.fascicle"));
}

TEST(Durability, APowerCutAtAnyMomentLosesNoPublishedFile) {
  NEEDS_STRACE();
  const TemporaryFolder folder;
  const std::vector<DiskCall> calls = traced_bake(folder / "out");
  const Cut cut(folder / "out");
  Disk disk(folder / "out");
  std::set<Disk::Files> seen;
  std::size_t resumed = 0, with_checkpoint = 0;
  for (std::size_t k = 0; k < calls.size(); ++k) {
    disk.apply(calls[k]);
    for (const Disk::Names names : {Disk::Names::safe, Disk::Names::latest}) {
      const Disk::Files files = disk.after_power_cut(names);
      EXPECT_EQ(joined_lines(cut.torn(files)), "") << "after call " << k;
      // Syncing makes resumed bakes slow; every fourth is enough.
      if (!seen.insert(files).second || seen.size() % 4 != 1) continue;
      EXPECT_TRUE(cut.goes_on_to_the_same_bytes(files)) << "after call " << k;
      ++resumed;
      if (files.contains("checkpoint")) ++with_checkpoint;
    }
  }
  EXPECT_GT(resumed, 40u);
  EXPECT_GT(with_checkpoint, 20u);
}

// The control: a file renamed before its bytes are synced is found torn.
TEST(Durability, ATornFileIsSeen) {
  NEEDS_STRACE();
  const TemporaryFolder folder;
  std::vector<DiskCall> calls = traced_bake(folder / "out");
  const Cut cut(folder / "out");
  std::erase_if(calls, [](const DiskCall& call) {
    return call.kind == DiskCall::Kind::sync && call.path.ends_with("frame_000004.obj.tmp");
  });
  Disk disk(folder / "out");
  std::size_t torn = 0;
  for (const DiskCall& call : calls) {
    disk.apply(call);
    torn += cut.torn(disk.after_power_cut(Disk::Names::latest)).size();
  }
  EXPECT_GT(torn, 0u);
}

// The most work lost to a power cut, in seconds, if a frame takes `frame` seconds and the disk `sync`
// seconds.
double most_lost(double frame, double sync, std::uint64_t frames, std::uint64_t* checkpoints = nullptr) {
  bake::CheckpointPace pace(frames, ~std::uint64_t{0}, 0.5, 0.0);
  double taken = 0.0, most = 0.0;
  for (std::uint64_t k = 1; k <= frames; ++k) {
    const double ends = static_cast<double>(k) * frame;
    if (pace.is_due(k, ends - frame, sync)) {
      most = std::max(most, ends + sync - taken);
      taken = ends;
      pace.is_taken(ends);
      if (checkpoints != nullptr) ++*checkpoints;
    }
    pace.frame_has_ended(ends);
  }
  return most;
}

TEST(CheckpointPace, LosesHalfASecondAtMostOrOneFrame) {
  for (const double frame : {0.0005, 0.004, 0.05, 0.1, 0.2})
    EXPECT_LE(most_lost(frame, 0.02, 10000), 0.5 + 1e-9) << frame;
  for (const double frame : {0.3, 0.6, 5.0, 100.0}) {
    std::uint64_t checkpoints = 0;
    EXPECT_NEAR(most_lost(frame, 0.02, 100, &checkpoints), frame + 0.02, 1e-9);
    EXPECT_GE(checkpoints, 99u) << "each long frame has its own checkpoint";
  }
}

// Fast frames share a checkpoint, and a disk slower than the simulation holds it up for at most half of the
// time.
TEST(CheckpointPace, GroupsFastFrames) {
  std::uint64_t checkpoints = 0;
  most_lost(0.001, 0.01, 10000, &checkpoints);
  EXPECT_GE(checkpoints, 20u);
  EXPECT_LE(checkpoints, 23u);
  checkpoints = 0;
  most_lost(0.001, 2.0, 10000, &checkpoints);
  EXPECT_LE(checkpoints, 6u);
}

}  // namespace
}  // namespace fascicle::tests
