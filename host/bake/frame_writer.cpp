#include "host/bake/frame_writer.h"

#include <system_error>
#include <utility>

namespace fascicle::bake {

FrameWriter::FrameWriter(std::function<void(model::Frame&)> write) : write_(std::move(write)) {
  try {
    thread_ = std::thread([this] { work(); });
  } catch (const std::system_error&) {
    // Process limit reached: frames are then written without overlap.
  }
}

FrameWriter::~FrameWriter() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FrameWriter::do_job(Job& job) const {
  write_(job.frame);
  if (job.then) job.then();
}

void FrameWriter::put(model::Frame frame, std::function<void()> then) {
  Job job{std::move(frame), std::move(then)};
  if (!thread_.joinable()) {
    do_job(job);
    return;
  }
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.empty() || failure_; });
  rethrow();
  waiting_.push_back(std::move(job));
  changed_.notify_all();
}

void FrameWriter::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return (waiting_.empty() && !is_writing_) || failure_; });
  rethrow();
}

void FrameWriter::rethrow() {
  if (failure_) std::rethrow_exception(failure_);
}

void FrameWriter::work() {
  for (;;) {
    Job job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return !waiting_.empty() || stops_; });
      if (stops_) return;
      job = std::move(waiting_.front());
      waiting_.pop_front();
      is_writing_ = true;
    }
    changed_.notify_all();
    std::exception_ptr failure;
    try {
      do_job(job);
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      is_writing_ = false;
      failure_ = failure;
    }
    changed_.notify_all();
    if (failure) return;
  }
}

}  // namespace fascicle::bake
