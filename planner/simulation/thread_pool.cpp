#include "planner/simulation/thread_pool.hpp"

namespace hecaton::planner {

ThreadPool::ThreadPool(int threads, int count) : count_(count), shares_(threads) {
  for (int k = 0; k < threads; ++k) shares_[k].next = shares_[k].end = count * (k + 1) / threads;
  for (int k = 1; k < threads; ++k) threads_.emplace_back([this, k] { run(k); });
}

ThreadPool::~ThreadPool() {
  over_ = true;
  ++round_;
  round_.notify_all();
}

// A late thread finds no item, or an item of the next round. It takes the item before it reads work_, so that the two
// belong to the same round.
void ThreadPool::for_each(const std::function<void(int)>& work) {
  work_ = &work;
  done_ = 0;
  for (std::size_t k = 0; k < shares_.size(); ++k) shares_[k].next = k == 0 ? 0 : shares_[k - 1].end;
  if (!threads_.empty()) {
    ++round_;
    round_.notify_all();
  }
  process(0);
  for (int done = done_; done < count_; done = done_) done_.wait(done);
}

void ThreadPool::run(int self) {
  for (unsigned round = 0; !over_; round = round_) {
    process(self);
    round_.wait(round);
  }
}

void ThreadPool::process(int self) {
  for (std::size_t k = 0; k < shares_.size(); ++k) {
    Share& share = shares_[(self + k) % shares_.size()];
    for (int i = share.next++; i < share.end; i = share.next++) {
      (*work_)(i);
      if (++done_ == count_) done_.notify_one();
    }
  }
}

}  // namespace hecaton::planner
