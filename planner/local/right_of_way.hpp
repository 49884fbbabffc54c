#pragma once
/// Who makes room for whom: a rule that every arm evaluates alone, from what all publish, and that never makes two arms
/// wait for each other (docs/design/0007-right-of-way.md).

#include <cstdint>
#include <span>

#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local/random.hpp"
#include "planner/local/velocity_constraints.hpp"

namespace hecaton::planner {

/// How urgently an arm wants the others to make room. A total order: of two arms exactly one goes first.
struct Priority {
  std::uint32_t number = 0;  ///< 0: it never asked. Grows with every asking and never falls
  int arm = 0;               ///< index in the cell

  /// Whoever asked last goes first; the lower index between those that asked at the same time.
  [[nodiscard]] bool precedes(const Priority& other) const {
    return number > other.number || (number == other.number && arm < other.arm);
  }
};

/// What an arm remembers of it.
struct RightOfWay {
  std::uint32_t priority = 0;  ///< the own one: what the arm publishes
  bool under_way = false;      ///< to a goal where it has not been yet; others need not make room for one that is not
  bool leads = false;          ///< under way, asked, and nobody goes before it
  int yields_to = -1;          ///< index of the arm that it makes room for; −1: none
  std::uint32_t answers = 0;   ///< the priority that it made room for last
  double waited = 0.0;         ///< since it was first held back or must wait for a new priority [s]
  double patience = 0.0;       ///< before it asks [s]; 0: not drawn yet
  double growth = 1.0;         ///< of its patience, by what it has asked on the way to this goal
  double free = 0.0;           ///< since nothing held it back [s]
  double apart = 0.0;          ///< since it was last near the arm that it makes room for [s]
};

struct RightOfWayInput {
  const LocalParameters& parameters;
  std::span<const ArmObservation> arms;  ///< of every arm of the cell
  int self;                              ///< index of the own arm
  std::span<const Row> rows;
  double dt;       ///< control period [s]
  bool held_back;  ///< it follows a boundary or stands
};

/// Whether the own arm is to make room for arm i by what it knows of it, near or not.
[[nodiscard]] bool goes_before(const RightOfWayInput& input, const RightOfWay& right, int i);

/// One period: for whom to make room, and whether to ask. `under_way` is the caller's business.
void update(const RightOfWayInput& input, Random& random, RightOfWay& right);

/// The joint velocity [rad/s | m/s] that makes room: away from the near links of every arm that goes first, the faster
/// the nearer they are; zero beyond dᵢ.
[[nodiscard]] JointVector retreat_velocity(const RightOfWayInput& input, const RightOfWay& right,
                                           const JointLimits& limits);

}  // namespace hecaton::planner
