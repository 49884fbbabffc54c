#pragma once
/// Samples between the middleware's thread and the service's loop. Not locked: its owner does that.

#include <algorithm>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/endpoint.hpp"

namespace hecaton::bus {

template <class T>
class SampleQueue {
 public:
  /// `conflate`: only the newest of each key.
  SampleQueue(bool conflate, std::size_t capacity)
      : conflate_(conflate), capacity_(std::max<std::size_t>(capacity, 1)) {}

  /// Number of samples dropped to make room.
  std::size_t push(Sample<T> sample) {
    if (conflate_) {
      newest_.insert_or_assign(sample.key, std::move(sample));
      return 0;
    }
    std::size_t dropped = 0;
    for (; queue_.size() >= capacity_; ++dropped) queue_.pop_front();
    queue_.push_back(std::move(sample));
    return dropped;
  }

  /// Everything, in order of arrival.
  std::vector<Sample<T>> take() {
    std::vector<Sample<T>> samples;
    samples.reserve(queue_.size() + newest_.size());
    for (auto& sample : queue_) samples.push_back(std::move(sample));
    for (auto& [key, sample] : newest_) samples.push_back(std::move(sample));
    queue_.clear();
    newest_.clear();
    if (conflate_) {
      std::sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.received < b.received; });
    }
    return samples;
  }

 private:
  bool conflate_;
  std::size_t capacity_;
  std::deque<Sample<T>> queue_;
  std::map<std::string, Sample<T>> newest_;
};

}  // namespace hecaton::bus
