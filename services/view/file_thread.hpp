#pragma once
/// A thread that reads files for a web server, so that a slow disk delays none of its clients.

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace hecaton::services {

/// Runs jobs one after the other, until its end. The job under way is awaited then, and those that wait are dropped.
class FileThread {
 public:
  static constexpr std::size_t kMostWaiting = 64;  ///< jobs

  /// False: kMostWaiting jobs wait. Thread-safe. The job must not throw.
  [[nodiscard]] bool run(std::function<void()> job) {
    {
      const std::scoped_lock lock(mutex_);
      if (jobs_.size() >= kMostWaiting) return false;
      jobs_.push_back(std::move(job));
    }
    arrived_.notify_one();
    return true;
  }

 private:
  void work(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (arrived_.wait(lock, stop, [&] { return !jobs_.empty(); }) && !stop.stop_requested()) {
      std::function<void()> job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      job();
      job = nullptr;
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::deque<std::function<void()>> jobs_;
  std::jthread thread_{[this](const std::stop_token& stop) { work(stop); }};  // last: it uses all of them
};

}  // namespace hecaton::services
