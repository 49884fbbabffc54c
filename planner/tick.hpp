#pragma once
/// One control period of one arm: from what the planner knows of the cell to the next set-point. The only entrance to
/// the reactive algorithms. Pure: equal input and memory give an equal result, bit by bit; no allocation, clock, log or
/// network.

#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "planner/collision/cell_geometry.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local_planner.hpp"

namespace hecaton::planner {

/// A device that executes nothing any more, and an arm that may hardly move, still have limits of this share.
inline constexpr double kSlowestShare = 0.01;

struct TickInput {
  double dt = 0.010;           ///< control period [s]
  JointVector q;               ///< own reference position: the last set-point [rad | m]
  JointVector qd;              ///< own reference velocity [rad/s | m/s]
  JointVector tracking_error;  ///< measured minus reference position [rad | m]; empty: none
  JointVector q_goal;          ///< [rad | m]; ignored without goal
  bool has_goal = false;       ///< false: the arm keeps its position, but gives way
  bool hold = false;           ///< the arm brakes on its stop profile and stays
  double speed_scaling = 1.0;  ///< share of the velocity limits that this arm may use, 0 to 1
  std::span<const ArmObservation> arms;
  std::span<const world::ObstacleState> obstacles;  ///< one per obstacle of the geometry
};

enum class TickStatus : std::uint8_t {
  kIdle,               ///< no goal; the arm keeps its position
  kMoving,             ///< the arm moves straight to its goal
  kFollowingBoundary,  ///< the arm follows a boundary
  kDetouring,          ///< the arm visits a way-point
  kFollowingPlan,      ///< the arm follows a coupled plan
  kFollowingRoute,     ///< the arm follows the points of a planned route
  kYielding,           ///< the arm makes room for an arm with the right of way: see `yields_to`
  kBlocked,            ///< no progress for now: see `binding`
  kReached,            ///< within tolerance of the goal and at rest
  kHolding,            ///< TickInput::hold was set
  kStaleInput,  ///< a state is missing or too old: see `stale_arm`; the arm does not pursue its goal, but gives way
};

struct TickResult {
  JointVector q;   ///< next set-point, dt later [rad | m]
  JointVector qd;  ///< velocity there [rad/s | m/s]
  TickStatus status = TickStatus::kIdle;
  bool has_binding = false;
  Clearance binding;              ///< nearest clearance that limits the motion, if any
  int stale_arm = -1;             ///< arm whose state is missing or too old; −1: none; −2: the obstacles
  int yields_to = -1;             ///< arm that this arm makes room for; −1: none
  bool awaiting_rollout = false;  ///< the straight line is blocked; the arm waits for a rollout before it deviates
  bool near = false;              ///< some pair is within its influence distance
  int rows = 0;                   ///< number of constraints on the motion
  /// Least distance from obstacles and other arms minus dₛ, at the beginning of the period [m]. Only bodies that the
  /// arm can move count. Infinite beyond the range of the distance pass.
  double clearance_margin = std::numeric_limits<double>::infinity();
  double clearance_margin_of_moving = std::numeric_limits<double>::infinity();  ///< the same, moving obstacles only [m]
  bool relaxed = false;  ///< the dampers require more than the acceleration limits allow: the arm brakes at the limits
  int subspaces_drawn = 0;  ///< subspaces that the method has tried for this goal
};

/// Memory of one planner between ticks. A value, so that a rollout can copy it.
struct TickMemory {
  LocalMemory local;
};

/// Storage that ticks reuse. Its contents have no meaning between ticks. Not thread-safe: one per thread.
class TickScratch {
 public:
  /// Without the workspace of a method: a method that needs one moves straight to the goal.
  explicit TickScratch(const CellGeometry& geometry);
  /// With the workspace of the arm's method.
  TickScratch(const CellGeometry& geometry, const LocalParameters& parameters);
  ~TickScratch();
  TickScratch(TickScratch&&) noexcept;
  TickScratch& operator=(TickScratch&&) noexcept;
  /// Call after CellGeometry::set_obstacles. Allocates.
  void rebuild(const CellGeometry& geometry);

  struct Storage;
  [[nodiscard]] Storage& storage() { return *storage_; }

 private:
  std::unique_ptr<Storage> storage_;
};

/// Plans one control period of `geometry.own_arm()`. `scratch` must be built for `geometry`.
[[nodiscard]] TickResult tick(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                              TickMemory& memory, TickScratch& scratch);

/// For a caller that changes the velocity of the last tick() with this scratch: true if the stop path of `qd_next` is
/// clear (StopPathCheck). False after a tick that only brakes.
[[nodiscard]] bool stop_path_is_clear(const JointVector& qd_next, TickScratch& scratch);

}  // namespace hecaton::planner
