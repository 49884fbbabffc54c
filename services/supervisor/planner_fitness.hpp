#pragma once
/// Whether a planner must be replaced, or can replace another. Standard library only.

#include <optional>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

struct PlannerFitness {
  bool out = false;    ///< to be replaced
  bool ready = false;  ///< stands by with all that it needs
};

/// What the supervisor knows of it.
struct PlannerSigns {
  bool ended = false;               ///< its process, or it never appeared
  std::optional<Time> silence{};    ///< of its loop, in punctual time; empty: not heard yet
  bool stands_by = false;           ///< as it says itself: with every input that it needs
  std::optional<Time> in_charge{};  ///< for how long; empty: it is not
  /// Since the driver accepted a command, as its newest state says; empty: it never did, or is itself silent.
  std::optional<Time> uncommanded{};
};

struct FitnessLimits {
  Time silence = std::chrono::milliseconds(20);       ///< of a hanging planner
  Time uncommanded = std::chrono::milliseconds(100);  ///< of one that the supervisor hears and the driver does not
};

/// Commands that arrive are a sign of life, too: lost heartbeats alone replace nobody.
[[nodiscard]] inline PlannerFitness fitness_of(const PlannerSigns& signs, const FitnessLimits& limits) {
  const bool commands = signs.in_charge && signs.uncommanded && *signs.uncommanded < limits.silence;
  const bool silent = signs.silence && *signs.silence >= limits.silence && !commands;
  const bool unheard = signs.in_charge && *signs.in_charge >= limits.uncommanded && signs.uncommanded &&
                       *signs.uncommanded >= limits.uncommanded;
  const bool out = signs.ended || silent || unheard;
  return {out, !out && signs.stands_by && signs.silence.has_value()};  // what its predecessor said is not its word
}

}  // namespace hecaton::services
