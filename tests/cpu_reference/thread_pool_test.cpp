// ThreadPool processes every item once with any number of threads, even if the system creates fewer than
// requested.
#include "cpu_reference/solver/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "tests/cpu_reference/solver_runs.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

namespace {

using cpu_reference::ThreadPool;

// Whether two successive jobs visit each item of [0, count) exactly once.
bool visits_each_once(ThreadPool& pool, std::uint32_t count) {
  std::vector<int> visits(count, 0);
  for (int round = 1; round <= 2; ++round) {
    pool.run(count, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t i = first; i < last; ++i) ++visits[i];
    });
    for (const int v : visits)
      if (v != round) return false;
  }
  return true;
}

TEST(ThreadPool, VisitsEachItemOnce) {
  for (const unsigned threads : {1u, 2u, 3u, 8u}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.size(), threads);
    for (const std::uint32_t count : {0u, 1u, 7u, 1000u})
      EXPECT_TRUE(visits_each_once(pool, count)) << threads << " threads, " << count << " items";
  }
}

// As when memory runs out. Whichever thread it happens in, the caller learns of it after the other chunks
// have been run, and the pool goes on.
TEST(ThreadPool, WhatAChunkThrowsReachesTheCaller) {
  constexpr std::uint32_t count = 1000;
  for (const unsigned threads : {1u, 2u, 8u})
    for (const std::uint32_t bad : {0u, 500u, count - 1}) {
      ThreadPool pool(threads);
      std::vector<int> visits(count, 0);
      EXPECT_THROW(pool.run(count,
                            [&](std::uint32_t first, std::uint32_t last) {
                              if (first <= bad && bad < last) throw std::bad_alloc();
                              for (std::uint32_t i = first; i < last; ++i) ++visits[i];
                            }),
                   std::bad_alloc)
          << threads << " threads, item " << bad;
      // No chunk runs twice, and the failed one counts for at most a whole run by one thread.
      for (const int v : visits) EXPECT_LE(v, 1);
      EXPECT_TRUE(threads == 1 || std::count(visits.begin(), visits.end(), 1) > count / 2);
      EXPECT_TRUE(visits_each_once(pool, count));
      // All chunks fail at once.
      EXPECT_THROW(pool.run(count, [](std::uint32_t, std::uint32_t) { throw std::runtime_error("all"); }),
                   std::runtime_error);
      EXPECT_TRUE(visits_each_once(pool, count));
    }
}

// A pool without workers, or with idle workers, fails this: each chunk waits, for at most ten seconds, until
// as many chunks have started as there are threads.
TEST(ThreadPool, EveryThreadTakesPart) {
  for (const unsigned threads : {2u, 3u, 8u}) {
    ThreadPool pool(threads);
    for (int round = 0; round < 3; ++round) {
      std::atomic<unsigned> begun{0}, late{0};
      pool.run(1000, [&](std::uint32_t, std::uint32_t) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        ++begun;
        while (begun < threads && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
        if (begun < threads) ++late;
      });
      EXPECT_EQ(late, 0u) << threads << " threads";
    }
  }
}

// Rounds so short that workers arrive late, and pauses in which they fall asleep.
TEST(ThreadPool, VisitsEachItemOnceInManyShortRounds) {
  ThreadPool pool(4);
  std::vector<std::atomic<int>> visits(64);
  for (int round = 1; round <= 20'000; ++round) {
    const auto count = static_cast<std::uint32_t>(round % 65);
    pool.run(count, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t i = first; i < last; ++i) ++visits[i];
    });
    for (std::uint32_t i = 0; i < visits.size(); ++i)
      ASSERT_EQ(visits[i].exchange(0), i < count ? 1 : 0) << "round " << round << ", item " << i;
    if (round % 1000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST(ThreadPool, HasOneThreadOrMoreByDefault) {
  EXPECT_GE(ThreadPool(0).size(), 1u);
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

TEST(ThreadPool, GoesOnWithTheThreadsThatCouldBeMade) {
  GTEST_SKIP() << "SKIPPED: under a sanitizer a process cannot run with a limit on its address space";
}

#else

std::size_t address_space_used() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * 4096;
}

// Runs in its own process, as the limit would affect all later tests. Exits with 0 on success.
[[noreturn]] void use_a_pool_under_a_limit() {
  // A thread's stack takes 2 MiB or more, so 200 MiB hold some threads but not 1,000.
  const rlim_t limit = address_space_used() + (200u << 20);
  const rlimit space{limit, limit};
  setrlimit(RLIMIT_AS, &space);
  int status = 0;
  {
    ThreadPool pool(1000);
    if (pool.size() < 2 || pool.size() >= 1000)
      status = 1;
    else if (!visits_each_once(pool, 5000))
      status = 2;
    std::fprintf(stderr, "%u threads\n", pool.size());
  }
  std::_Exit(status);
}

// A solver's arrays are allocated before its threads, which take what is left.
[[noreturn]] void make_a_solver_under_a_limit() {
  const rlim_t limit = address_space_used() + (200u << 20);
  const rlimit space{limit, limit};
  setrlimit(RLIMIT_AS, &space);
  try {
    const model::Model model = random_model(1);
    cpu_reference::make_cpu_solver(model, {}, 1000)->save();
  } catch (const std::bad_alloc&) {
    std::_Exit(1);
  }
  std::fprintf(stderr, "made\n");
  std::_Exit(0);
}

TEST(ThreadPoolDeathTest, ASolverGoesOnWithTheThreadsThatCouldBeMade) {
  EXPECT_EXIT(make_a_solver_under_a_limit(), testing::ExitedWithCode(0), "made");
}

TEST(ThreadPoolDeathTest, GoesOnWithTheThreadsThatCouldBeMade) {
  EXPECT_EXIT(use_a_pool_under_a_limit(), testing::ExitedWithCode(0), "threads");
}

#endif

}  // namespace

}  // namespace fascicle::tests
