#pragma once
/// Whether what a planner that was restarted remembers of its arm's goals still counts, or another planner may have
/// dealt with them since. Standard library only: time is an argument; docs/design/0005-return.md.

#include <chrono>
#include <cstdint>
#include <optional>

#include "services/planner/duty.hpp"

namespace hecaton::services {

enum class Recollection : std::uint8_t {
  kUnknown,  ///< not yet
  kCounts,
  kOutdated,
};

/// The last command that the arm's driver has accepted, as its state tells.
struct LastCommand {
  std::uint64_t term = 0;
  std::chrono::nanoseconds at{0};  ///< on this host's steady clock
};

/// Who stands by and dies with the planner in charge does not die in the same instant: what that one may have told
/// meanwhile is missing. As long as a process may stall before it counts as stopped (services/bus/absence.hpp).
constexpr std::chrono::milliseconds kTogether{250};

/// `under`: the mandate under which it was remembered; `until`: when that was last all that there was to know.
[[nodiscard]] inline Recollection judge_recollection(const ArmLease& under, std::chrono::nanoseconds until,
                                                     const Duty& duty, const std::optional<LastCommand>& last) {
  const ArmLease& newest = duty.mandate();
  if (newest.term == 0) return Recollection::kUnknown;
  // Mandates never come back: nobody else can have had the arm.
  if (newest == under && duty.in_charge()) return Recollection::kCounts;
  if (!last) return Recollection::kUnknown;
  // Whoever is in charge commands, also an arm that stands.
  if (last->term != under.term || last->at > until + kTogether) return Recollection::kOutdated;
  if (newest == under || duty.in_charge()) return Recollection::kCounts;
  return Recollection::kUnknown;  // another was put in charge since, and has not begun: perhaps it is dead
}

}  // namespace hecaton::services
