// A fixed set of threads that run one job together. Small on purpose: a substep is tens of microseconds, so
// workers spin briefly between jobs and then sleep.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace fascicle::cpu_reference {

class ThreadPool {
 public:
  // `threads` counts the caller; 0 means one for each core. Where the system refuses to make that many (a
  // limit on memory or on processes) the pool is smaller: size() tells, and no result depends on it.
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned size() const { return static_cast<unsigned>(workers_.size()) + 1; }

  // Runs job(first, last) once on each thread over a split of [0, count) and returns when all are done. The
  // split depends on count and size() alone. The job must not throw.
  void run(std::uint32_t count, const std::function<void(std::uint32_t first, std::uint32_t last)>& job);

 private:
  void work(unsigned worker);
  void run_part(unsigned part) const;

  std::vector<std::thread> workers_;
  const std::function<void(std::uint32_t, std::uint32_t)>* job_ = nullptr;
  std::uint32_t count_ = 0;
  std::atomic<std::uint64_t> round_{0};
  std::atomic<unsigned> running_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace fascicle::cpu_reference
