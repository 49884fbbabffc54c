#pragma once
/// When a process that died is started again. Standard library only: time is an argument.

#include <algorithm>
#include <chrono>
#include <optional>

namespace hecaton::services {

struct RestartLimits {
  std::chrono::nanoseconds first = std::chrono::milliseconds(100);  ///< after the first death, doubled with each
  std::chrono::nanoseconds longest = std::chrono::seconds(5);
  std::chrono::nanoseconds steady = std::chrono::seconds(10);  ///< who lived this long starts again from `first`
  int attempts = 10;                                           ///< in a row; 0: never restarts
  /// Who was given up is tried again after this: what it lacked may be there by then. 0: never.
  std::chrono::nanoseconds retry = std::chrono::seconds(60);
};

class RestartPolicy {
 public:
  explicit RestartPolicy(const RestartLimits& limits) : limits_(limits) {}

  /// It died after having lived `lived`: how long to wait before it is started again; empty: it is given up.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> died(std::chrono::nanoseconds lived) {
    if (lived >= limits_.steady) attempts_ = 0;
    if (attempts_ >= limits_.attempts) return std::nullopt;
    auto delay = limits_.first;
    for (int i = 0; i < attempts_ && delay < limits_.longest; ++i) delay *= 2;
    ++attempts_;
    return std::min(delay, limits_.longest);
  }

  [[nodiscard]] int attempts() const { return attempts_; }  ///< in a row

 private:
  RestartLimits limits_;
  int attempts_ = 0;
};

}  // namespace hecaton::services
