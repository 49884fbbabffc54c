#pragma once
/// How long another thread that has something to do has finished nothing, as the loop sees it that waits for it.
/// Standard library only: time is an argument.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>

namespace hecaton::services {

class TurnWatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// Of the time between two looks no more counts: the loop was stopped for longer, and the other thread with it.
  static constexpr std::chrono::milliseconds kLongestLook{100};

  /// Every turn of the loop. `busy`: the thread has something to do; `finished`: how much it has, a number that grows.
  void look(Clock::time_point now, bool busy, std::uint64_t finished) {
    const bool waits = busy && busy_ && finished == finished_;
    silence_ = waits ? silence_ + std::min<Clock::duration>(now - looked_, kLongestLook) : Clock::duration::zero();
    looked_ = now;
    busy_ = busy;
    finished_ = finished;
  }

  [[nodiscard]] Clock::duration silence() const { return silence_; }

 private:
  Clock::time_point looked_{};
  bool busy_ = false;
  std::uint64_t finished_ = 0;
  Clock::duration silence_{};
};

/// "the thread that resolves goals has not answered for 7 s"; empty when it has, within `limit`.
[[nodiscard]] inline std::string complaint_about(const std::string& thread, TurnWatch::Clock::duration silence,
                                                 TurnWatch::Clock::duration limit) {
  if (silence <= limit) return {};
  const auto seconds = std::chrono::floor<std::chrono::seconds>(silence).count();
  return thread + " has not answered for " + std::to_string(seconds) + " s";
}

}  // namespace hecaton::services
