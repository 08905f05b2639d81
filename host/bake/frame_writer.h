// Frames written on a thread of their own, in order, while the next ones are simulated.
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
  // `write` is called on the writer's thread, one frame at a time, which it may change; where the system
  // refuses to make a thread, by put().
  explicit FrameWriter(std::function<void(model::Frame&)> write);
  // Frames whose writing has not begun are dropped.
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  // Waits while another frame waits. `then`, where it is given, is called once this frame is written and
  // before the next is. Throws what an earlier frame's writing threw; nothing is written after that.
  void put(model::Frame frame, std::function<void()> then = {});
  // Waits until all frames are written. Throws as put does.
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
  std::thread thread_;  // last: it uses the others
};

}  // namespace fascicle::bake
