#pragma once
/// Tells of messages that cannot be read.

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

 private:
  std::string name_;
  std::string type_;
  std::optional<bus::Clock::time_point> told_;
  int ignored_ = 0;  ///< since then
};

}  // namespace hecaton::ros2
