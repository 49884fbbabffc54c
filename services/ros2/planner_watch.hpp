#pragma once
/// Which arms have a planner, as discovery tells.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::ros2 {

/// For one thread. Its memory is bounded by kMost.
class PlannerWatch {
 public:
  /// More participants with the name of a planner do not count.
  static constexpr std::size_t kMost = 1024;

  /// Takes what discovery tells of participants; other events change nothing.
  void note(const bus::Event& event);
  /// A planner of the arm, in charge or standby, is there. A process that was killed counts until its lease ends.
  [[nodiscard]] bool knows(std::string_view arm) const;

 private:
  struct Planner {
    bus::EndpointId participant;
    std::string arm;
  };
  std::vector<Planner> planners_;
};

}  // namespace hecaton::ros2
