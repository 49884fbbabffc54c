#include "planner/simulation/thread_pool.hpp"

#include <numeric>

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

TEST(ThreadPool, RunsEachItemOnceInEachRound) {
  for (const int threads : {1, 2, 3, 7}) {
    for (const int count : {0, 1, 5, 100}) {
      ThreadPool pool(threads, count);
      std::vector<int> done(count, 0);
      for (int round = 1; round <= 2000; ++round) {
        pool.for_each([&](int i) { done[i] += round; });
        // The results of all threads are visible after the round.
        ASSERT_EQ(std::accumulate(done.begin(), done.end(), 0L), static_cast<long>(count) * round * (round + 1) / 2);
      }
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
