#pragma once
/// Progress and faults on their way from the thread of the connection to a thread of Python. No Python in here.

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>

#include <hecaton/types.hpp>

namespace hecaton::python {

using Event = std::variant<Progress, Fault>;

/// Thread-safe.
class EventQueue {
 public:
  /// A full queue drops its oldest progress that is not the last of its goal. Ends of goals and faults are never lost.
  void push(Event event) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    if (events_.size() >= kMostEvents) {
      const auto old = std::find_if(events_.begin(), events_.end(), [](const Event& queued) {
        const auto* progress = std::get_if<Progress>(&queued);
        return progress != nullptr && !is_final(progress->state);
      });
      if (old != events_.end()) events_.erase(old);
    }
    events_.push_back(std::move(event));
    arrived_.notify_one();
  }
  /// Waits for the next event. Empty: the queue is closed.
  [[nodiscard]] std::optional<Event> pop() {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, [this] { return closed_ || !events_.empty(); });
    if (closed_) return std::nullopt;
    std::optional<Event> event(std::move(events_.front()));
    events_.pop_front();
    return event;
  }
  /// Ends every wait and drops all events.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    events_.clear();
    arrived_.notify_all();
  }

 private:
  static constexpr std::size_t kMostEvents = 4096;

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Event> events_;
  bool closed_ = false;
};

}  // namespace hecaton::python
