// Frames written in parallel with the simulation: all of them, in order, and an error reaches the next put().
#include "host/bake/frame_writer.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

model::Frame numbered(std::uint64_t index) {
  model::Frame frame;
  frame.index = index;
  return frame;
}

TEST(FrameWriter, WritesAllInOrderOnAnotherThread) {
  std::vector<std::uint64_t> written;
  std::thread::id by;
  bake::FrameWriter writer([&](const model::Frame& frame) {
    by = std::this_thread::get_id();
    written.push_back(frame.index);
  });
  std::vector<std::uint64_t> expected;
  for (std::uint64_t k = 0; k < 200; ++k) {
    writer.put(numbered(k));
    expected.push_back(k);
    if (k % 50 != 49) continue;
    writer.finish();
    EXPECT_EQ(written, expected) << "finish() returned too early";
  }
  EXPECT_NE(by, std::this_thread::get_id());
}

// One frame is being written and one is waiting. Without this limit the queue would grow if writing is slower
// than simulating.
TEST(FrameWriter, KeepsNoMoreThanTwo) {
  std::atomic<bool> may_write = false;
  std::atomic<std::uint64_t> put = 0;
  bake::FrameWriter writer([&](const model::Frame&) { may_write.wait(false); });
  std::thread simulation([&] {
    for (std::uint64_t k = 0; k < 5; ++k) {
      writer.put(numbered(k));
      ++put;
    }
  });
  // Two are accepted at once. That no third is can only be tested by waiting.
  while (put < 2) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LE(put, 2u);
  may_write = true;
  may_write.notify_all();
  simulation.join();
  writer.finish();
  EXPECT_EQ(put, 5u);
}

TEST(FrameWriter, HandsOnWhatAWriteThrowsAndWritesNoMore) {
  std::vector<std::uint64_t> written;
  bake::FrameWriter writer([&](const model::Frame& frame) {
    if (frame.index == 2) throw std::runtime_error("disk full");
    written.push_back(frame.index);
  });
  const auto put_many = [&] {
    for (std::uint64_t k = 0; k < 10; ++k) writer.put(numbered(k));
  };
  try {
    put_many();
    FAIL() << "put() did not throw";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "disk full");
  }
  EXPECT_THROW(writer.finish(), std::runtime_error);
  EXPECT_EQ(written, (std::vector<std::uint64_t>{0, 1}));
}

TEST(FrameWriter, DropsWhatWaitsWhenItGoes) {
  std::atomic<bool> has_begun = false, may_write = false;
  std::atomic<int> written = 0;
  auto writer = std::make_unique<bake::FrameWriter>([&](const model::Frame&) {
    ++written;
    has_begun = true;
    may_write.wait(false);
  });
  writer->put(numbered(0));
  while (!has_begun) std::this_thread::yield();
  writer->put(numbered(1));
  std::thread end([&] { writer.reset(); });
  // Long enough for the destructor to tell the thread to stop; otherwise frame 1 would be written too.
  std::this_thread::sleep_for(std::chrono::seconds(1));
  may_write = true;
  may_write.notify_all();
  end.join();
  EXPECT_EQ(written, 1);
}

}  // namespace
}  // namespace fascicle::tests
