#include "cpu_reference/thread_pool.h"

#include <algorithm>
#include <new>
#include <system_error>

namespace fascicle::cpu_reference {

namespace {

// Long enough to bridge the gap between two stages, short enough not to burn a core others need.
constexpr int spins_before_sleep = 200;

template <class Ready>
bool spin_until(Ready ready) {
  for (int spin = 0; spin < spins_before_sleep; ++spin) {
    if (ready()) return true;
    std::this_thread::yield();
  }
  return false;
}

}  // namespace

ThreadPool::ThreadPool(unsigned threads) {
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  // A thread that is underway must be joined whatever happens, so nothing may leave this loop by an
  // exception.
  try {
    for (unsigned worker = 1; worker < threads; ++worker)
      workers_.emplace_back([this, worker] { work(worker); });
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
}

ThreadPool::~ThreadPool() {
  stop_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::run_part(unsigned part) const {
  const std::uint64_t parts = size();
  const auto first = static_cast<std::uint32_t>(std::uint64_t{count_} * part / parts);
  const auto last = static_cast<std::uint32_t>(std::uint64_t{count_} * (part + 1) / parts);
  if (first < last) (*job_)(first, last);
}

void ThreadPool::run(std::uint32_t count, const std::function<void(std::uint32_t, std::uint32_t)>& job) {
  job_ = &job;
  count_ = count;
  running_.store(static_cast<unsigned>(workers_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  if (!workers_.empty()) round_.notify_all();
  run_part(0);
  const auto done = [this] { return running_.load(std::memory_order_acquire) == 0; };
  while (!spin_until(done)) {
    const unsigned left = running_.load(std::memory_order_acquire);
    if (left != 0) running_.wait(left, std::memory_order_acquire);
  }
}

void ThreadPool::work(unsigned worker) {
  std::uint64_t seen = 0;
  for (;;) {
    const auto called = [&] { return round_.load(std::memory_order_acquire) != seen; };
    while (!spin_until(called)) round_.wait(seen, std::memory_order_acquire);
    seen = round_.load(std::memory_order_acquire);
    if (stop_.load(std::memory_order_relaxed)) return;
    run_part(worker);
    if (running_.fetch_sub(1, std::memory_order_acq_rel) == 1) running_.notify_all();
  }
}

}  // namespace fascicle::cpu_reference
