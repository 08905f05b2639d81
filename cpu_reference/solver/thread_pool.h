// A fixed set of threads that run one job together. Simple on purpose: a substep takes tens of microseconds,
// so workers spin briefly between jobs and then sleep. A job is split into chunks that threads claim, so a
// worker that the system gives no core delays only the chunk that it has begun.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace fascicle::cpu_reference {

class ThreadPool {
 public:
  // `threads` includes the caller; 0 means one per core. If the system refuses to create that many (a limit
  // on memory or on processes), the pool is smaller; size() gives its size, and no result depends on it.
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned size() const { return static_cast<unsigned>(workers_.size()) + 1; }

  // Splits [0, count) into chunks, runs job(first, last) once on each, and returns when all are done. The
  // split depends only on count and size(). Which thread runs a chunk varies: each starts with its own
  // chunks, in order, then helps the next thread. If a chunk throws, the others are still run; then one of
  // the exceptions is thrown again.
  void run(std::uint32_t count, const std::function<void(std::uint32_t first, std::uint32_t last)>& job);

 private:
  // The last round in which a thread claimed the chunk. Data that different threads write is kept on separate
  // cache lines.
  static constexpr std::size_t line = 64;
  struct alignas(line) Claim {
    std::atomic<std::uint64_t> round{0};
  };

  void work(unsigned worker);
  void take_chunks(unsigned thread, std::uint64_t round);
  void run_chunk(std::size_t chunk);
  std::size_t chunk_count() const;

  std::vector<std::thread> workers_;
  std::unique_ptr<Claim[]> claims_;  // chunk_count of them, thread by thread
  const std::function<void(std::uint32_t, std::uint32_t)>* job_ = nullptr;
  std::uint32_t count_ = 0;
  alignas(line) std::atomic<std::uint64_t> round_{0};
  std::atomic<bool> stop_{false};
  alignas(line) std::atomic<std::size_t> unfinished_{0};  // chunks of this round

  // For threads that have spun without finding work.
  alignas(line) std::mutex sleep_;
  std::condition_variable called_, finished_;
  std::atomic<unsigned> sleeping_{0};
  std::atomic<bool> caller_sleeps_{false};

  // Of this round. Whoever sets the flag writes the exception; the caller reads it when no chunk is left.
  std::atomic<bool> failed_{false};
  std::exception_ptr failure_;
};

}  // namespace fascicle::cpu_reference
