#include "planner/setpoint_log.hpp"

#include <utility>

#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

SetpointLog::SetpointLog(JointLimits limits, double period) : limits_(std::move(limits)), period_(period) {}

void SetpointLog::sent(std::uint64_t number, const MeasuredState& setpoint) {
  ring_[number % ring_.size()] = {number, setpoint};
}

std::optional<MeasuredState> SetpointLog::reference(std::uint64_t number, double age) const {
  const Entry& entry = ring_[number % ring_.size()];
  if (number == 0 || entry.number != number) return std::nullopt;
  MeasuredState reference = entry.setpoint;
  const double overdue = age - period_;
  if (overdue <= 0.0) {
    reference.q += reference.qd * overdue;
  } else {
    stop_for(limits_, overdue, reference.q, reference.qd);
  }
  return reference;
}

}  // namespace hecaton::planner
