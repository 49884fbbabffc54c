#pragma once
/// Supervises the progress of another thread of the same process. Standard library only: time is an argument.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>

namespace hecaton::services {

/// Measures for how long a busy worker thread has finished nothing, as seen by a loop that waits for its results. For
/// the loop's thread only.
class ProgressWatchdog {
 public:
  using Clock = std::chrono::steady_clock;

  /// One interval between two updates counts at most this: a longer one means that the whole process was stopped, the
  /// worker included.
  static constexpr std::chrono::milliseconds kLongestStep{100};

  /// Call it once in each turn of the loop. `busy`: the worker has something to do; `finished`: a counter that grows
  /// with each piece of work that it has done.
  void update(Clock::time_point now, bool busy, std::uint64_t finished) {
    const bool waits = busy && busy_ && finished == finished_;
    silence_ = waits ? silence_ + std::min<Clock::duration>(now - updated_, kLongestStep) : Clock::duration::zero();
    updated_ = now;
    busy_ = busy;
    finished_ = finished;
  }

  /// Zero while the worker is idle or has just finished something.
  [[nodiscard]] Clock::duration silence() const { return silence_; }

 private:
  Clock::time_point updated_{};
  bool busy_ = false;
  std::uint64_t finished_ = 0;
  Clock::duration silence_{};
};

/// "the thread that resolves goals has not answered for 7 s"; empty while `silence` is within `limit`.
[[nodiscard]] inline std::string stall_text(const std::string& thread, ProgressWatchdog::Clock::duration silence,
                                            ProgressWatchdog::Clock::duration limit) {
  if (silence <= limit) return {};
  const auto seconds = std::chrono::floor<std::chrono::seconds>(silence).count();
  return thread + " has not answered for " + std::to_string(seconds) + " s";
}

}  // namespace hecaton::services
