#pragma once
/// Threads that share the same work again and again: that of a cell's arms, period after period.

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace hecaton::planner {

class ThreadPool {
 public:
  /// `threads` ≥ 1, the caller's included, for rounds of `count` pieces of work.
  ThreadPool(int threads, int count);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// One round: calls work(i) once for every i in [0, count), in any order, on any of the threads; returns when all are
  /// done. The calls must not depend on each other, nor throw.
  void for_each(const std::function<void(int)>& work);

 private:
  /// What one thread begins with, the same in every round, so that its data stays in that core's cache. Who has
  /// finished his helps the others: nobody waits for a thread that does not get a processor.
  struct alignas(64) Share {
    std::atomic<int> next{0};
    int end = 0;
  };

  void serve(int self);
  void work_off(int self);

  int count_;
  std::vector<Share> shares_;
  const std::function<void(int)>* work_ = nullptr;
  std::atomic<int> done_{0};
  std::atomic<unsigned> round_{0};
  std::atomic<bool> over_{false};
  std::vector<std::jthread> threads_;
};

}  // namespace hecaton::planner
