#pragma once
/// A pool of threads for repeated rounds of equal work: one item per arm, one round per control period.

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace hecaton::planner {

class ThreadPool {
 public:
  /// `threads` ≥ 1 includes the calling thread. Each round has `count` items.
  ThreadPool(int threads, int count);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Runs one round: calls work(i) once for each i in [0, count), in any order, on any thread, and returns when all
  /// calls have returned. The calls must be independent and must not throw.
  void for_each(const std::function<void(int)>& work);

 private:
  /// Items with which one thread begins, the same in each round, so that their data stay in its core's cache. A thread
  /// that has finished its share continues with other shares, so that a thread without a processor delays no round.
  struct alignas(64) Share {
    std::atomic<int> next{0};
    int end = 0;
  };

  void run(int self);
  void process(int self);

  int count_;
  std::vector<Share> shares_;
  const std::function<void(int)>* work_ = nullptr;
  std::atomic<int> done_{0};
  std::atomic<unsigned> round_{0};
  std::atomic<bool> over_{false};
  std::vector<std::jthread> threads_;
};

}  // namespace hecaton::planner
