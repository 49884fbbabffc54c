#include "planner/tick.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/local/joint_distance.hpp"
#include "planner/local/latency_compensation.hpp"
#include "planner/local/stop_path_check.hpp"
#include "planner/local_scene.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {

struct TickScratch::Storage {
  explicit Storage(const CellGeometry& geometry)
      : scene(geometry), distance(geometry), stop_path(geometry), clearances(kMaxRows), arms(geometry.arms().size()) {}

  LocalScene scene;
  ExactDistance distance;
  StopPathCheck stop_path;
  std::vector<Clearance> clearances;
  std::array<Row, kMaxRows> rows;
  std::unique_ptr<MethodWorkspace> of_method;
  std::vector<ArmObservation> arms;  ///< scratch of stand_aside()
};

TickScratch::TickScratch(const CellGeometry& geometry) : storage_(std::make_unique<Storage>(geometry)) {}
TickScratch::TickScratch(const CellGeometry& geometry, const LocalParameters& parameters) : TickScratch(geometry) {
  storage_->of_method = parameters.method->make_workspace(geometry);
}
TickScratch::~TickScratch() = default;
TickScratch::TickScratch(TickScratch&&) noexcept = default;
TickScratch& TickScratch::operator=(TickScratch&&) noexcept = default;
void TickScratch::rebuild(const CellGeometry& geometry) {
  storage_->scene.rebuild(geometry);
  storage_->distance.rebuild(geometry);
  storage_->stop_path = StopPathCheck(geometry);
  if (storage_->of_method) storage_->of_method->rebuild(geometry);
}

namespace {

/// Values of TickResult::stale_arm that are not the index of an arm.
constexpr int kNone = -1;
constexpr int kObstacles = -2;

int find_stale(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input) {
  for (int i = 0; i < static_cast<int>(input.arms.size()); ++i) {
    if (i == geometry.self()) continue;
    if (!input.arms[i].known || input.arms[i].age > parameters.state_age_limit) return i;
  }
  for (const auto& obstacle : input.obstacles) {
    if (obstacle.age > parameters.state_age_limit) return kObstacles;
  }
  return kNone;
}

/// Every arm is known, even if its state is old, and the obstacles are fresh: enough to give way.
bool can_give_way(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input) {
  for (int i = 0; i < static_cast<int>(input.arms.size()); ++i) {
    if (i != geometry.self() && !input.arms[i].known) return false;
  }
  return std::all_of(input.obstacles.begin(), input.obstacles.end(),
                     [&](const auto& obstacle) { return obstacle.age <= parameters.state_age_limit; });
}

/// Limits the velocity near obstacles so that every stop takes at most `stop_time` [s], and everywhere to the share
/// that this arm may use. Fills `slower` only if needed. Only the choice of the next velocity depends on these limits.
/// Distances, margins and stop paths use those of the arm, so that no order can make a margin smaller.
const JointLimits& limits_near(const JointLimits& limits, double stop_time, double speed_scaling, JointLimits& slower) {
  const bool stops_in_time = longest_stop_time(limits) <= stop_time;
  if (stops_in_time && speed_scaling >= 1.0) return limits;
  slower = limits;
  if (!stops_in_time) slower.velocity = limits.velocity.cwiseMin(limits.acceleration * stop_time);
  if (speed_scaling < 1.0)
    slower.velocity = slower.velocity.cwiseMin(limits.velocity * std::max(speed_scaling, kSlowestShare));
  return slower;
}

struct BuiltRows {
  int count = 0;
  double stop_time = std::numeric_limits<double>::infinity();       ///< stops may take no longer [s]
  double nearest = std::numeric_limits<double>::infinity();         ///< distance of obstacles and other arms [m]
  double nearest_moving = std::numeric_limits<double>::infinity();  ///< distance of what moves freely [m]
};

/// A retreat needs a higher velocity limit if all joints together, at the reduced limit, separate the pair less than
/// this many times as fast as the row asks. The factor leaves joints for other rows.
constexpr double kSpareFlight = 4.0;
/// Stops may then take this many times longer. A single immediate stop still ends before contact
/// (docs/explanation/0001-braking.md, "Flight").
constexpr double kLongerInFlight = 2.0;

bool retreats_within(const JointLimits& limits, const Row& row, double stop_time) {
  const auto slower = limits.velocity.array().min(limits.acceleration.array() * stop_time);
  return (row.g.array().abs() * slower).sum() >= -kSpareFlight * row.h;
}

/// A slower obstacle counts as static [m/s], and so does an arm whose joints are slower [rad/s | m/s].
constexpr double kMoves = 0.02;

bool moves(const world::ObstacleState& state) {
  return state.velocity.linear.squaredNorm() > kMoves * kMoves || !state.velocity.angular.isZero();
}

/// The other body moves and does not give way: a moving obstacle, or an arm that others move.
bool moves_freely(const DamperScene& scene, const Clearance& clearance) {
  switch (clearance.counterpart) {
    case Counterpart::kObstacle:
      return moves(scene.obstacles[clearance.other]);
    case Counterpart::kArm: {
      const ArmObservation& other = scene.observations[clearance.other];
      return other.foreign && other.qd.cwiseAbs().maxCoeff() > kMoves;
    }
    case Counterpart::kSelf:
      return false;
  }
  return false;
}

BuiltRows build_rows(const DamperScene& scene, const JointVector& fastest, std::span<const Clearance> clearances,
                     std::span<Row> rows) {
  BuiltRows built;
  const JointLimits& limits = scene.geometry.own_arm().limits;
  for (int i = 0; i < static_cast<int>(clearances.size()) && built.count < static_cast<int>(rows.size()); ++i) {
    Row& row = rows[built.count];
    row = velocity_damper(scene, clearances[i]);
    row.clearance = i;
    // A row that no joint can change would only make the problem infeasible.
    const double reach = row.g.cwiseAbs().dot(fastest);
    if (reach > 0.0) built.stop_time = std::min(built.stop_time, row.stop_time);
    if (reach > 0.0 && clearances[i].counterpart != Counterpart::kSelf) {
      built.nearest = std::min(built.nearest, clearances[i].distance);
      if (moves_freely(scene, clearances[i]))
        built.nearest_moving = std::min(built.nearest_moving, clearances[i].distance);
    }
    const bool can_bind = reach > row.h;
    if (reach > 0.0 && (row.influences || can_bind)) ++built.count;
  }
  const auto kept = rows.first(built.count);
  const double stop_time = built.stop_time;
  if (std::any_of(kept.begin(), kept.end(),
                  [&](const Row& row) { return row.h < 0.0 && !retreats_within(limits, row, stop_time); })) {
    built.stop_time *= kLongerInFlight;
  }
  return built;
}

/// An arm on a trajectory with path tolerance stays in a box around it, except where nothing can block it, and to evade
/// what comes.
bool stays_in_box(const TickInput& input, std::span<const Row> rows, const LocalMemory& memory) {
  const TrajectoryTracking& tracking = memory.tracking;
  if (!input.has_goal || !tracking.is_bound() || !tracking.begun) return false;
  if (memory.detour.active && memory.detour.stays) return false;
  return tracking.phase == TrackingPhase::kAround || memory.right_of_way.yields_to >= 0 ||
         std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row.influences; });
}

TickResult brake(const CellGeometry& geometry, const TickInput& input, TickStatus status) {
  TickResult result;
  result.status = status;
  result.qd = braking_velocity(geometry.own_arm().limits, input.qd, input.dt);
  result.q = input.q + 0.5 * (input.qd + result.qd) * input.dt;
  return result;
}

TickResult plan(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                TickMemory& memory, TickScratch& scratch) {
  TickScratch::Storage& s = scratch.storage();
  const Arm& arm = geometry.own_arm();
  const JointVector fastest = (input.qd.cwiseAbs() + arm.limits.acceleration * input.dt).cwiseMin(arm.limits.velocity);
  s.scene.update(geometry, parameters, input, fastest);
  const int near = s.distance.clearances(s.scene.poses(), s.scene.influence(), s.clearances);
  const std::span<const Clearance> clearances = std::span(s.clearances).first(near);
  s.stop_path.begin(geometry, parameters.damper, {input.q, input.qd, input.tracking_error, input.dt, clearances});
  const DamperScene scene = s.scene.scene(geometry, parameters, input, s.distance);
  const BuiltRows rows = build_rows(scene, fastest, clearances, s.rows);
  JointLimits slower;
  const JointLimits& limits = limits_near(arm.limits, rows.stop_time, input.speed_scaling, slower);

  const JointVector& q_goal = input.has_goal ? input.q_goal : input.q;
  const MethodScene method_scene{geometry,   s.scene.poses(),  input.arms, parameters.damper.self_security_distance,
                                 s.distance, s.of_method.get()};
  const std::span<const Row> kept = std::span(s.rows).first(rows.count);
  const auto local_input = [&](const JointLimits& used, const PathBox* box) {
    return LocalInput{used,
                      parameters,
                      input.q,
                      input.qd,
                      q_goal,
                      input.dt,
                      kept,
                      input.arms,
                      geometry.self(),
                      input.has_goal,
                      &method_scene,
                      &s.stop_path,
                      std::clamp(input.speed_scaling, kSlowestShare, 1.0),
                      box};
  };
  LocalResult local;
  bool planned = false;
  if (stays_in_box(input, kept, memory.local)) {
    const LocalMemory before = memory.local;
    const TrajectoryTracking& tracking = before.tracking;
    JointLimits on_path = limits;
    on_path.velocity = velocity_on_path(limits, input.dt, tracking);
    const PathBox box = path_box(limits, input.q, tracking);
    local = plan_locally(local_input(on_path, &box), memory.local);
    // Distances come before the path tolerance: without a velocity inside, the arm may leave the box.
    planned = !local.relaxed;
    if (!planned) memory.local = before;
  }
  if (!planned) local = plan_locally(local_input(limits, nullptr), memory.local);

  TickResult result;
  result.qd = local.qd;
  result.q = input.q + 0.5 * (input.qd + local.qd) * input.dt;
  result.rows = rows.count;
  result.clearance_margin = rows.nearest - parameters.damper.security_distance;
  result.clearance_margin_of_moving = rows.nearest_moving - parameters.damper.security_distance;
  result.relaxed = local.relaxed;
  result.awaiting_rollout = local.awaiting_rollout;
  result.near = std::any_of(s.rows.begin(), s.rows.begin() + rows.count, [](const Row& row) { return row.influences; });
  result.yields_to = local.yields_to;
  result.subspaces_drawn = memory.local.deviation.drawn;
  if (local.binding_row >= 0) {
    result.has_binding = true;
    result.binding = s.clearances[s.rows[local.binding_row].clearance];
  } else if (local.too_close) {
    const auto is_pair = [&](const Clearance& c) {
      return c.counterpart == Counterpart::kSelf && std::pair(c.own_body, c.other_body) == *local.too_close;
    };
    const auto found = std::find_if(clearances.begin(), clearances.end(), is_pair);
    result.has_binding = found != clearances.end();
    if (result.has_binding) result.binding = *found;
  }
  const bool at_goal = input.has_goal && !memory.local.tracking.follows() &&
                       farthest_joint(limits, input.q, q_goal) < parameters.goal_tolerance &&
                       input.qd.cwiseAbs().maxCoeff() < 10.0 * parameters.goal_tolerance;
  result.status = !input.has_goal        ? TickStatus::kIdle
                  : at_goal              ? TickStatus::kReached
                  : local.yields_to >= 0 ? TickStatus::kYielding
                  : local.blocked        ? TickStatus::kBlocked
                  : local.stalled        ? TickStatus::kBlocked
                  : local.following      ? TickStatus::kFollowingBoundary
                  : local.detouring      ? TickStatus::kDetouring
                                         : TickStatus::kMoving;
  return result;
}

/// While some arm's state is too old, the own arm does not pursue its goal, but still gives way to the rest. It does
/// not approach the stop sets of the arms with old states. Its memory stays as it is until fresh states arrive.
TickResult stand_aside(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                       const TickMemory& memory, TickScratch& scratch) {
  std::vector<ArmObservation>& arms = scratch.storage().arms;
  std::copy(input.arms.begin(), input.arms.end(), arms.begin());
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    ArmObservation& arm = arms[i];
    if (i == geometry.self() || arm.age <= parameters.state_age_limit) continue;
    const ReachableStopSet region = reachable_stop_set(geometry.arms()[i].limits, arm.q, arm.qd, arm.age);
    arm.q = region.q;
    arm.position_uncertainty = region.position_uncertainty;
    arm.qd.setZero();
    arm.age = 0.0;
    arm.plans = arm.foreign = arm.has_goal = false;
  }
  TickInput staying = input;
  staying.arms = arms;
  staying.has_goal = false;
  TickMemory aside = memory;
  return plan(geometry, parameters, staying, aside, scratch);
}

}  // namespace

TickResult tick(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                TickMemory& memory, TickScratch& scratch) {
  scratch.storage().stop_path.end();
  if (input.hold) return brake(geometry, input, TickStatus::kHolding);
  const int stale = find_stale(geometry, parameters, input);
  if (stale == kNone) return plan(geometry, parameters, input, memory, scratch);
  TickResult result = can_give_way(geometry, parameters, input)
                          ? stand_aside(geometry, parameters, input, memory, scratch)
                          : brake(geometry, input, TickStatus::kStaleInput);
  result.status = TickStatus::kStaleInput;
  result.stale_arm = stale;
  return result;
}

bool stop_path_is_clear(const JointVector& qd_next, TickScratch& scratch) {
  return scratch.storage().stop_path.is_clear(qd_next);
}

}  // namespace hecaton::planner
