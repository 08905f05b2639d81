// Writes frames in order on a separate thread while the next ones are simulated.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "host/model/solver.h"

namespace fascicle::bake {

class FrameWriter {
 public:
  // `write` is called on the writer's thread, one frame at a time, and may change the frame. If the system
  // refuses to create a thread, put() calls it.
  explicit FrameWriter(std::function<void(model::Frame&)> write);
  // Drops frames whose writing has not begun.
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  // Blocks while another frame is waiting. `then`, if given, is called after this frame is written and before
  // the next. Rethrows what an earlier frame's writing threw; nothing is written after that.
  void put(model::Frame frame, std::function<void()> then = {});
  // Blocks until all frames are written. Throws as put does.
  void finish();

 private:
  struct Job {
    model::Frame frame;
    std::function<void()> then;
  };

  void work();
  void do_job(Job& job) const;
  void rethrow();

  std::function<void(model::Frame&)> write_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> waiting_;  // at most one
  bool is_writing_ = false, stops_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // last, because it uses the others
};

}  // namespace fascicle::bake
