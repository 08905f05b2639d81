#include "cpu_reference/solver/thread_pool.h"

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

namespace fascicle::cpu_reference {

namespace {

// Enough to even out cores lost to other programs, few enough that claims cost nothing.
constexpr std::size_t chunks_of_thread = 4;

// Long enough to bridge the gap between two stages, short enough not to burn a core that others need.
constexpr int spins_before_sleep = 1000;

// Not std::this_thread::yield: if other programs are busy, that gives the core away for milliseconds.
void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

template <class Ready>
bool spin_until(Ready ready) {
  for (int spin = 0; spin < spins_before_sleep; ++spin) {
    if (ready()) return true;
    relax();
  }
  return false;
}

}  // namespace

ThreadPool::ThreadPool(unsigned threads) {
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  claims_ = std::make_unique<Claim[]>(chunks_of_thread * threads);
  // A running thread must be joined whatever happens, so no exception may leave this loop. Workers touch no
  // claim before the first round.
  try {
    for (unsigned worker = 1; worker < threads; ++worker)
      workers_.emplace_back([this, worker] { work(worker); });
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(sleep_);
    stop_.store(true);
    round_.fetch_add(1);
  }
  called_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

std::size_t ThreadPool::chunk_count() const {
  return chunks_of_thread * size();
}

void ThreadPool::run_chunk(std::size_t chunk) {
  const std::uint64_t chunks = chunk_count();
  const auto first = static_cast<std::uint32_t>(count_ * std::uint64_t{chunk} / chunks);
  const auto last = static_cast<std::uint32_t>(count_ * (std::uint64_t{chunk} + 1) / chunks);
  if (first == last) return;
  try {
    (*job_)(first, last);
  } catch (...) {
    if (!failed_.exchange(true)) failure_ = std::current_exception();
  }
}

// Every chunk is claimed once per round, so a late thread, still with the number of a finished round, finds
// nothing to claim. While a claimed chunk runs, its round is not over, so job_ and count_ stay valid.
void ThreadPool::take_chunks(unsigned thread, std::uint64_t round) {
  const std::size_t chunks = chunk_count();
  for (std::size_t k = 0; k < chunks; ++k) {
    const std::size_t chunk = (thread * chunks_of_thread + k) % chunks;
    std::atomic<std::uint64_t>& claim = claims_[chunk].round;
    std::uint64_t before = round - 1;
    // A failed exchange takes the cache line away from the working thread; a load does not.
    if (claim.load(std::memory_order_relaxed) != before || !claim.compare_exchange_strong(before, round))
      continue;
    run_chunk(chunk);
    if (unfinished_.fetch_sub(1) == 1 && caller_sleeps_.load()) {
      const std::lock_guard lock(sleep_);
      finished_.notify_one();
    }
  }
}

void ThreadPool::run(std::uint32_t count, const std::function<void(std::uint32_t, std::uint32_t)>& job) {
  if (workers_.empty() || count < 2) {
    if (count != 0) job(0, count);
    return;
  }
  job_ = &job;
  count_ = count;
  unfinished_.store(chunk_count());
  const std::uint64_t round = round_.fetch_add(1) + 1;
  if (sleeping_.load() != 0) {
    // Locks and unlocks, so that no worker is between its last check and its sleep.
    { const std::lock_guard lock(sleep_); }
    called_.notify_all();
  }
  take_chunks(0, round);
  const auto done = [this] { return unfinished_.load() == 0; };
  if (!spin_until(done)) {
    std::unique_lock lock(sleep_);
    caller_sleeps_.store(true);
    finished_.wait(lock, done);
    caller_sleeps_.store(false);
  }
  if (failed_.exchange(false)) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void ThreadPool::work(unsigned worker) {
  std::uint64_t seen = 0;
  for (;;) {
    const auto called = [&] { return round_.load() != seen; };
    if (!spin_until(called)) {
      std::unique_lock lock(sleep_);
      sleeping_.fetch_add(1);
      called_.wait(lock, called);
      sleeping_.fetch_sub(1);
    }
    seen = round_.load();
    if (stop_.load()) return;
    take_chunks(worker, seen);
  }
}

}  // namespace fascicle::cpu_reference
