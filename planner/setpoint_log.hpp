#pragma once
/// The set-points that were sent to a drive of late, by number: what it is measured against, whatever time the messages
/// take. Against the newest set-point an arm whose state is old would seem to lag.

#include <array>
#include <cstdint>
#include <optional>

#include "planner/local/observation.hpp"

namespace hecaton::planner {

class SetpointLog {
 public:
  /// `period` [s]: from a set-point's arrival until the arm is to be there.
  SetpointLog(JointLimits limits, double period);

  /// Numbers grow, but not always by one. 0 is none.
  void sent(std::uint64_t number, const MeasuredState& setpoint);
  /// Where the drive's reference is when it has had this set-point for `age` [s]: on the way to it, or on the stop from
  /// it. Empty: not ours, or sent too long ago.
  [[nodiscard]] std::optional<MeasuredState> reference(std::uint64_t number, double age) const;

 private:
  struct Entry {
    std::uint64_t number = 0;
    MeasuredState setpoint;
  };
  JointLimits limits_;
  double period_;
  std::array<Entry, 64> ring_;  ///< by number
};

}  // namespace hecaton::planner
