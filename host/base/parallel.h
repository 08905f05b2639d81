// Runs independent pieces of work on all cores.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

namespace fascicle::base {

// Calls work(piece, worker) once for every piece below `count`, on up to `most` threads, or fewer if the
// system refuses to create that many. `worker` is below the number of threads, and a worker does one piece at
// a time, so each may own scratch memory. What a piece writes must depend only on its number: then results do
// not depend on the number of threads. The first exception stops the work and is rethrown.
template <class Work>
void for_each_in_parallel(std::size_t count, std::size_t most, Work work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failing;
  const auto run = [&](std::size_t worker) {
    try {
      for (std::size_t piece = next++; piece < count; piece = next++) work(piece, worker);
    } catch (...) {
      next = count;
      const std::lock_guard<std::mutex> lock(failing);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    try {
      for (std::size_t worker = 1; worker < std::min(count, most); ++worker)
        threads.emplace_back(run, worker);
    } catch (const std::system_error&) {  // a limit on processes or memory: the existing threads do the work
    } catch (const std::bad_alloc&) {
    }
    run(0);
  }
  if (failure) std::rethrow_exception(failure);
}

// The number of threads wanted; 0: one per core, at least one.
inline std::size_t thread_count(std::size_t wanted = 0) {
  return wanted > 0 ? wanted : std::max<std::size_t>(1, std::thread::hardware_concurrency());
}

}  // namespace fascicle::base
