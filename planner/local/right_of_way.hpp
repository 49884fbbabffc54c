#pragma once
/// The right of way between arms: a rule that every arm evaluates alone from published states. It never makes two arms
/// wait for each other (docs/explanation/0007-right-of-way.md).

#include <cstdint>
#include <limits>
#include <span>

#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local/random.hpp"
#include "planner/local/velocity_constraints.hpp"

namespace hecaton::planner {

/// The priority of an arm. A total order: of two arms exactly one precedes the other.
struct Priority {
  std::uint32_t number = 0;  ///< 0: the arm has never requested. Grows with every request and never falls
  int arm = 0;               ///< index in the cell

  /// The latest request precedes; for equal numbers the lower index does.
  [[nodiscard]] bool precedes(const Priority& other) const {
    return number > other.number || (number == other.number && arm < other.arm);
  }
};

/// Memory of one arm. A value.
struct RightOfWay {
  std::uint32_t priority = 0;  ///< own number, published
  bool under_way = false;      ///< has a goal and has not reached it; only then other arms yield to it
  bool leads = false;          ///< under way, has requested, and no arm precedes it
  int yields_to = -1;          ///< index of the arm that the own arm makes room for; −1: none
  std::uint32_t answers = 0;   ///< number of the last request that the own arm yielded to
  double waited = 0.0;         ///< time since it was first blocked, or since it yields to a new request [s]
  double request_delay = 0.0;  ///< it requests after waiting for this long [s]; 0: not drawn yet
  double growth = 1.0;         ///< factor of request_delay; grows with every request on the way to one goal
  double free = 0.0;           ///< time for which it has moved freely, nearer to its goal than while it was blocked [s]
  /// The least distance from its goal at which it was blocked, see RightOfWayInput::distance; infinite: it was not.
  double nearest = std::numeric_limits<double>::infinity();
  double apart = 0.0;  ///< time since it was last near the arm that it makes room for [s]

  void describe(MemoryArchive& archive) {
    archive(priority, under_way, leads);
    archive.arm(yields_to);
    archive(answers, waited, request_delay, growth, free, nearest, apart);
  }
};

struct RightOfWayInput {
  const LocalParameters& parameters;
  std::span<const ArmObservation> arms;  ///< one per arm of the cell
  int self;                              ///< index of the own arm
  std::span<const Row> rows;
  double dt;        ///< control period [s]
  bool blocked;     ///< the own arm follows a boundary or stands
  double distance;  ///< of the own arm from its goal [rad | m]; on a trajectory the time to its end [s]
};

/// True if arm i precedes the own arm by its published state, at any distance.
[[nodiscard]] bool goes_before(const RightOfWayInput& input, const RightOfWay& right, int i);

/// One period: decides to which arm to yield and whether to request. The caller maintains `under_way`.
void update(const RightOfWayInput& input, Random& random, RightOfWay& right);

/// The joint velocity that makes room [rad/s | m/s]: away from the near links of all arms that precede, faster for
/// nearer links, zero beyond dᵢ.
[[nodiscard]] JointVector retreat_velocity(const RightOfWayInput& input, const RightOfWay& right,
                                           const JointLimits& limits);

}  // namespace hecaton::planner
