// Work on several threads: every item is processed once, the first exception propagates, and fewer threads do
// if the system refuses more.
#include "host/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace fascicle::tests {
namespace {

// Whether each item is processed exactly once, by workers with numbers below `most`.
bool takes_each_once(std::size_t count, std::size_t most) {
  std::vector<std::atomic<int>> taken(count);
  std::atomic<bool> is_below = true;
  base::for_each_in_parallel(count, most, [&](std::size_t piece, std::size_t worker) {
    ++taken[piece];
    if (worker >= most) is_below = false;
  });
  return is_below && std::all_of(taken.begin(), taken.end(), [](const auto& times) { return times == 1; });
}

TEST(ForEachInParallel, TakesEachPieceOnce) {
  for (const std::size_t count : {0u, 1u, 7u, 5000u})
    for (const std::size_t most : {1u, 2u, 9u})
      EXPECT_TRUE(takes_each_once(count, most)) << count << ' ' << most;
}

TEST(ForEachInParallel, ThrowsWhatAPieceThrew) {
  EXPECT_THROW(base::for_each_in_parallel(1000, 4,
                                          [](std::size_t piece, std::size_t) {
                                            if (piece == 17) throw std::runtime_error("17");
                                          }),
               std::runtime_error);
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

TEST(ForEachInParallel, GoesOnWithTheThreadsThatWereGranted) {
  GTEST_SKIP() << "SKIPPED: under a sanitizer a process cannot run with a limit on its address space";
}

#else

// Runs in its own process, as the limit would affect all later tests. It limits memory because root is exempt
// from limits on processes. Exits with 0 on success.
[[noreturn]] void work_under_a_limit() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  // A thread's stack takes 2 MiB or more, so 200 MiB hold some threads but not 1,000.
  const rlim_t limit = pages * 4096 + (rlim_t{200} << 20);
  const rlimit space{limit, limit};
  setrlimit(RLIMIT_AS, &space);
  bool is_refused = false;
  {
    std::atomic<bool> ends = false;
    std::vector<std::jthread> threads;
    try {
      while (threads.size() < 1000) threads.emplace_back([&] { ends.wait(false); });
    } catch (const std::system_error&) {
      is_refused = true;
    } catch (const std::bad_alloc&) {
      is_refused = true;
    }
    ends = true;
    ends.notify_all();
  }
  if (!is_refused) std::_Exit(2);
  // Items sleep, so that the first threads are still running when the last are requested.
  std::atomic<int> taken = 0;
  base::for_each_in_parallel(1000, 1000, [&](std::size_t, std::size_t) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ++taken;
  });
  std::fprintf(stderr, "worked\n");
  std::_Exit(taken == 1000 ? 0 : 1);
}

TEST(ForEachInParallelDeathTest, GoesOnWithTheThreadsThatWereGranted) {
  EXPECT_EXIT(work_under_a_limit(), testing::ExitedWithCode(0), "worked");
}

#endif

}  // namespace
}  // namespace fascicle::tests
