#pragma once
/// Tells of messages that cannot be read.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "services/bus/mailbox.hpp"

namespace hecaton::ros2 {

/// Of one topic or service. For one thread.
class UnreadableLog {
 public:
  UnreadableLog(std::string name, std::string_view type) : name_(std::move(name)), type_(type) {}

  /// A message was ignored. Logs it, but at most once a minute. True: it has logged.
  bool note(bus::Clock::time_point now);
  /// Messages that were ignored since the start.
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::string name_;
  std::string type_;
  std::optional<bus::Clock::time_point> told_;
  std::uint64_t ignored_ = 0;  ///< since then
  std::uint64_t count_ = 0;
};

}  // namespace hecaton::ros2
