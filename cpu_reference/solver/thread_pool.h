// A fixed set of threads that run one job together. Small on purpose: a substep is tens of microseconds, so
// workers spin briefly between jobs and then sleep. A job is cut into chunks that threads claim, so that a
// worker to whom the system gives no core holds up one chunk at most, that which it has begun.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
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

  // Runs job(first, last) on the chunks of a split of [0, count), each once, and returns when all are done.
  // The split depends on count and size() alone; which thread takes a chunk does not: each begins with its
  // own, in order, then helps the next thread. The job must not throw.
  void run(std::uint32_t count, const std::function<void(std::uint32_t first, std::uint32_t last)>& job);

 private:
  // The last round in which somebody took the chunk. What different threads write lies apart, so that they do
  // not share cache lines.
  static constexpr std::size_t line = 64;
  struct alignas(line) Claim {
    std::atomic<std::uint64_t> round{0};
  };

  void work(unsigned worker);
  void take_chunks(unsigned thread, std::uint64_t round);
  void run_chunk(std::size_t chunk) const;
  std::size_t chunk_count() const;

  std::vector<std::thread> workers_;
  std::unique_ptr<Claim[]> claims_;  // chunk_count of them, thread by thread
  const std::function<void(std::uint32_t, std::uint32_t)>* job_ = nullptr;
  std::uint32_t count_ = 0;
  alignas(line) std::atomic<std::uint64_t> round_{0};
  std::atomic<bool> stop_{false};
  alignas(line) std::atomic<std::size_t> unfinished_{0};  // chunks of this round

  // For threads that have spun in vain.
  alignas(line) std::mutex sleep_;
  std::condition_variable called_, finished_;
  std::atomic<unsigned> sleeping_{0};
  std::atomic<bool> caller_sleeps_{false};
};

}  // namespace fascicle::cpu_reference
