#pragma once
/// Everything one control period does for one arm: the only entrance to the planner's algorithms.
/// Pure: same input and memory, same result; no allocation, clock, log or network.

#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "planner/collision/cell_geometry.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local_planner.hpp"

namespace hecaton::planner {

struct TickInput {
  double dt = 0.010;           ///< control period [s]
  JointVector q;               ///< own reference position: where the last commands lead [rad | m]
  JointVector qd;              ///< own reference velocity [rad/s | m/s]
  JointVector tracking_error;  ///< measured minus reference position [rad | m]; empty: none
  JointVector q_goal;          ///< [rad | m]; ignored without goal
  bool has_goal = false;       ///< without: stay, but give way
  bool hold = false;           ///< brake on the stop profile and stay, whatever comes
  std::span<const ArmObservation> arms;
  std::span<const world::ObstacleState> obstacles;  ///< one per obstacle of the geometry
};

enum class TickStatus : std::uint8_t {
  kIdle,        ///< no goal; keeps its place
  kMoving,      ///< the local planner makes progress
  kFollowing,   ///< follows a boundary
  kDetouring,   ///< goes by a way-point
  kTogether,    ///< goes with others by a coupled plan
  kRouted,      ///< goes by the points of a planned route
  kYielding,    ///< makes room for an arm that has the right of way: see `yields_to`
  kBlocked,     ///< no progress for now: see `binding`
  kReached,     ///< within tolerance of the goal and at rest
  kHolding,     ///< told to
  kStaleInput,  ///< does not go on because it knows too little: see `stale_arm`; makes way for what it sees
};

struct TickResult {
  JointVector q;   ///< next set-point, dt later [rad | m]
  JointVector qd;  ///< velocity there [rad/s | m/s]
  TickStatus status = TickStatus::kIdle;
  bool has_binding = false;
  Clearance binding;              ///< nearest clearance that shapes the motion, if any
  int stale_arm = -1;             ///< arm whose state is too old or unknown; −1: none; −2: the obstacles
  int yields_to = -1;             ///< arm that this one makes room for, −1: none
  bool awaiting_rollout = false;  ///< its straight way is blocked, and it waits for a manoeuvre before it turns aside
  bool near = false;              ///< some pair is within its influence distance
  int rows = 0;                   ///< constraints on the motion
  /// The least distance of what it can move from obstacles and other arms, beyond dₛ, when the period began [m]; as far
  /// as it was measured: infinite when nothing is near.
  double clearance_margin = std::numeric_limits<double>::infinity();
  double clearance_margin_of_moving =
      std::numeric_limits<double>::infinity();  ///< the same from obstacles that move [m]
  bool relaxed = false;     ///< dampers asked more than the acceleration limits can give: braked as hard as allowed
  int subspaces_drawn = 0;  ///< ways around that the method has tried for this goal: subspaces drawn
};

/// What one planner remembers from tick to tick: a value, so that a rollout can copy it.
struct TickMemory {
  LocalMemory local;
};

/// Storage reused from tick to tick, one per thread. Contents mean nothing between ticks.
class TickScratch {
 public:
  explicit TickScratch(const CellGeometry& geometry);
  /// With the workspace of the arm's method. Without, a method that needs one goes straight to the goal.
  TickScratch(const CellGeometry& geometry, const LocalParameters& parameters);
  ~TickScratch();
  TickScratch(TickScratch&&) noexcept;
  TickScratch& operator=(TickScratch&&) noexcept;
  /// After CellGeometry::set_obstacles. Allocates.
  void rebuild(const CellGeometry& geometry);

  struct Storage;
  [[nodiscard]] Storage& storage() { return *storage_; }

 private:
  std::unique_ptr<Storage> storage_;
};

/// One control period of `geometry.own_arm()`.
[[nodiscard]] TickResult tick(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                              TickMemory& memory, TickScratch& scratch);

}  // namespace hecaton::planner
