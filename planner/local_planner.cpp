#include "planner/local_planner.hpp"

#include <algorithm>

#include "planner/local/goal_objective.hpp"
#include "planner/local/joint_distance.hpp"
#include "planner/local/stop_path_check.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Slower motion than this share of the maximum velocity does not count as progress.
constexpr double kStillShare = 0.02;
/// An arm without motion for this long away from its goal reports that it is blocked [s].
constexpr double kBlockedAfter = 0.5;
/// An arm on a trajectory makes progress while the time runs at this share of its fastest rate.
constexpr double kRunningShare = 0.05;
/// An arm that returns to its goal stays where the constraints leave less than this share of its speed. Without it, two
/// arms would press against each other, and each change of a state's age would move them.
constexpr double kReturningShare = 0.1;
/// A detour need not end exactly at its way-point [rad | m].
constexpr double kDetourTolerance = 0.1;

/// Raises each bound that `allowed` violates to the value at `allowed`.
void relax(QpProblem& problem, const JointVector& allowed) {
  for (int i = 0; i < problem.rows; ++i) {
    problem.h[i] = std::max(problem.h[i], problem.G.row(i).head(allowed.size()).dot(allowed));
  }
}

/// The velocity nearest to `target` within `bounds` and the rows of `problem`. If there is none, the rows are relaxed
/// so that `allowed` satisfies them: zero velocity or the stop profile, which are always possible.
QpSolution project(QpProblem& problem, const JointVector& target, const VelocityBounds& bounds,
                   const JointVector& allowed, QpWarmStart& warm, bool& relaxed) {
  problem.target = target;
  problem.lower = bounds.lower;
  problem.upper = bounds.upper;
  QpSolution solution = solve(problem, warm);
  relaxed = solution.status != QpStatus::kOptimal;
  if (!relaxed) return solution;
  const auto h = problem.h;
  relax(problem, allowed);
  problem.lower = problem.lower.cwiseMin(allowed);
  problem.upper = problem.upper.cwiseMax(allowed);
  warm = {};
  solution = solve(problem, warm);
  if (solution.status != QpStatus::kOptimal) solution.x = allowed;
  problem.h = h;
  return solution;
}

/// Retreats as far as possible when not all retreats (rows with h < 0) are feasible. Starts at `solution`, which
/// satisfies the relaxed rows. Projected gradient steps reduce the sum of squares of the violations of the retreats.
void retreat(QpProblem& problem, const JointVector& allowed, QpSolution& solution) {
  constexpr int kSteps = 8;
  const auto g = [&](int i) { return problem.G.row(i).head(allowed.size()); };
  const auto h = problem.h;
  double scale = 0.0;
  for (int i = 0; i < problem.rows; ++i) {
    if (h[i] < 0.0) scale += problem.norm[i] * problem.norm[i];
  }
  relax(problem, allowed);
  for (int step = 0; step < kSteps && scale > 0.0; ++step) {
    JointVector pull = JointVector::Zero(allowed.size());
    for (int i = 0; i < problem.rows; ++i) {
      if (h[i] < 0.0) pull += std::max(0.0, g(i).dot(solution.x) - h[i]) * g(i).transpose();
    }
    problem.target = solution.x - pull / scale;
    QpWarmStart cold;
    const QpSolution nearer = solve(problem, cold);
    if (nearer.status != QpStatus::kOptimal) break;
    solution.x = nearer.x;
  }
  problem.h = h;
}

/// The velocity for a command `refused` whose stop path is not clear. First the nearest one beyond planes that cut the
/// refused ones off, so that joints outside the pair go on. Else one on the way to `braking`, whose path the last
/// period has checked: the velocities in between satisfy the rows and limits that both satisfy, because these are
/// convex.
JointVector stoppable(StopPathCheck& stop_path, QpProblem& problem, const VelocityBounds& bounds,
                      const JointVector& braking, const JointVector& refused) {
  constexpr int kCuts = 3;
  problem.target = refused;
  problem.lower = bounds.lower;
  problem.upper = bounds.upper;
  relax(problem, refused);
  for (int cut = 0; cut < kCuts && stop_path.refused(); ++cut) {
    const Row row = stop_path.cut();
    QpWarmStart cold;
    if (!problem.add_row(row.g, row.h, row.key)) break;
    const QpSolution beyond = solve(problem, cold);
    if (beyond.status != QpStatus::kOptimal) break;
    if (stop_path.is_clear(beyond.x)) return beyond.x;
  }
  for (const double share : {0.5, 0.25}) {
    JointVector slower = braking + share * (refused - braking);
    if (stop_path.is_clear(slower)) return slower;
  }
  return braking;
}

int strongest_row(const QpSolution& solution) {
  int row = -1;
  double most = 0.0;
  for (int k = 0; k < solution.active; ++k) {
    if (solution.active_row[k] >= 0 && solution.multiplier[k] > most) {
      most = solution.multiplier[k];
      row = solution.active_row[k];
    }
  }
  return row;
}

bool inside(const VelocityBounds& bounds, const JointVector& qd) {
  return (qd.array() >= bounds.lower.array()).all() && (qd.array() <= bounds.upper.array()).all();
}

VelocityBounds velocity_bounds(const LocalInput& input) {
  const VelocityBounds bounds = speed_and_position_bounds(input.limits, input.q, input.dt);
  if (input.box == nullptr) return bounds;
  JointLimits limits = input.limits;
  limits.lower = input.box->lower;
  limits.upper = input.box->upper;
  const VelocityBounds in_box = speed_and_position_bounds(limits, input.q, input.dt);
  const VelocityBounds both{bounds.lower.cwiseMax(in_box.lower), bounds.upper.cwiseMin(in_box.upper)};
  return (both.lower.array() <= both.upper.array()).all() ? both : bounds;
}

/// What the first step of plan_locally() leaves to the second.
struct Intention {
  const JointVector& velocity;
  bool relaxed;  ///< it violates a row
  const VelocityBounds& bounds;
  const JointVector& braking;  ///< the velocity that brakes hardest
};

/// The commanded velocity is the nearest one to the intention that the acceleration limits allow in one period. The arm
/// can stop from it without touching itself.
void command(const LocalInput& input, const Intention& intended, QpProblem& problem, LocalMemory& memory,
             LocalResult& result) {
  const JointVector& braking = intended.braking;
  const VelocityBounds reachable =
      intersect(intended.bounds, acceleration_bounds(input.limits, input.qd, braking, input.dt), braking);
  if (!intended.relaxed && inside(reachable, intended.velocity)) {
    result.qd = intended.velocity;
  } else {
    QpSolution commanded = project(problem, intended.velocity, reachable, braking, memory.commanded, result.relaxed);
    if (result.relaxed) retreat(problem, braking, commanded);
    result.qd = commanded.x;
  }
  if (input.stop_path != nullptr && result.qd != braking && !input.stop_path->is_clear(result.qd)) {
    result.too_close = input.stop_path->refused();
    result.qd = stoppable(*input.stop_path, problem, reachable, braking, result.qd);
  }
}

/// A detour ends near its way-point, after its time, or when it is blocked. An evasion ends after its time only.
void update_detour(const LocalInput& input, const JointVector& intended, const JointVector& wanted, Detour& detour) {
  detour.time_left -= input.dt;
  if (detour.time_left <= 0.0) detour.active = false;
  if (detour.stays || detour.of_route) return;
  const JointVector way = joint_difference(input.limits, input.q, detour.q);
  const bool there = way.cwiseAbs().maxCoeff() < kDetourTolerance;
  const bool blocked = input.parameters.method->is_blocked(intended, wanted);
  if (there || blocked) detour.active = false;
}

/// The arm yields at once, except during a detour, which ends soon. An arm with the right of way moves straight,
/// because other arms retreat.
void update_right_of_way(const RightOfWayInput& input, LocalMemory& memory) {
  RightOfWay& right = memory.right_of_way;
  const bool detours = memory.detour.active && !memory.detour.of_route;
  if (!input.parameters.method->traits().coordinates || detours) {
    right.yields_to = -1;
    return;
  }
  const std::uint32_t priority = right.priority;
  update(input, memory.random, right);
  if (right.yields_to >= 0 || right.priority != priority) memory.deviation.active = false;
}

/// Resets the memory when the goal of the input differs from the last one.
void forget_old_goal(const LocalInput& input, LocalMemory& memory) {
  if (!input.has_goal) memory.right_of_way.under_way = false;
  // An arm without a goal keeps its present position, whatever its last goal was.
  const bool as_before = input.has_goal ? memory.q_goal.size() == input.q_goal.size() && memory.q_goal == input.q_goal
                                        : memory.q_goal.size() == 0;
  if (as_before) return;
  if (input.has_goal) {
    memory.q_goal = input.q_goal;
  } else {
    memory.q_goal.resize(0);
  }
  memory.method.clear();
  memory.deviation = {};
  memory.without_progress = 0.0;
  memory.detour.active = false;
  memory.right_of_way.under_way = input.has_goal;
  memory.right_of_way.growth = 1.0;
  memory.right_of_way.nearest = std::numeric_limits<double>::infinity();
}

/// See RightOfWayInput::distance. An arm that goes around something stays on its trajectory's time.
double distance_to_goal(const LocalInput& input, const TrajectoryTracking& tracking) {
  if (tracking.phase == TrackingPhase::kNone || tracking.phase == TrackingPhase::kDone)
    return joint_difference(input.limits, input.q, input.q_goal).norm();
  return tracking.trajectory->duration() - tracking.time;
}

/// What the arm does in a tick.
struct Purpose {
  bool tracks;   ///< a trajectory
  bool at_goal;  ///< of its joints; not on a trajectory
  bool yields;   ///< to another arm
  /// Straight to a goal that it had reached and was pushed away from, as far as there is room. Two arms that searched
  /// ways to goals too near each other would never rest.
  bool returns;
};

/// The velocity without constraints.
WantedMotion wanted_motion(const LocalInput& input, const Purpose& purpose, const RightOfWayInput& others,
                           const MethodInput& method_input, const MethodState& state, LocalMemory& memory) {
  const bool detours = memory.detour.active;
  WantedMotion wish;
  if (purpose.tracks) {
    wish.velocity =
        track(input.limits, input.q, input.qd, input.dt, input.speed, purpose.yields || detours, memory.tracking);
  }
  if (purpose.yields) {
    wish.velocity = retreat_velocity(others, memory.right_of_way, input.limits);
  } else if (input.has_goal && !purpose.returns && (!purpose.tracks || detours)) {
    wish = input.parameters.method->want(method_input, state);
  } else if (!purpose.tracks) {
    wish.velocity = goal_velocity(input.limits, input.q, method_input.target, input.dt);
  }
  return wish;
}

/// An arm that stands away from its goal for long is blocked.
void judge_progress(const LocalInput& input, const Purpose& purpose, LocalMemory& memory, LocalResult& result) {
  TrajectoryTracking& tracking = memory.tracking;
  if (purpose.tracks && tracking.time >= tracking.trajectory->duration()) tracking.phase = TrackingPhase::kDone;
  const bool runs = purpose.tracks && tracking.rate > kRunningShare * input.speed;
  const bool moves = runs || result.qd.norm() > kStillShare * input.limits.velocity.norm();
  const bool waits = memory.detour.active && memory.detour.stays;
  memory.without_progress = moves || purpose.at_goal || waits ? 0.0 : memory.without_progress + input.dt;
  result.blocked = memory.without_progress > kBlockedAfter;
}

}  // namespace

void begin(const Manoeuvre& manoeuvre, LocalMemory& memory) {
  memory.rollout_wait = 0.0;
  if (manoeuvre.kind == ManoeuvreKind::kContinue) return;
  memory.random = Random(manoeuvre.seed);
  const bool evades = manoeuvre.kind == ManoeuvreKind::kEvade;
  memory.detour = {evades || manoeuvre.kind == ManoeuvreKind::kDetour, manoeuvre.q, manoeuvre.time_limit, evades,
                   false};
  memory.deviation.renew = manoeuvre.kind == ManoeuvreKind::kSubspace;
  if (manoeuvre.kind != ManoeuvreKind::kSubspace) memory.deviation.active = false;
}

// Two steps. First the intended velocity as in [Lahouar06]: towards the goal or along a boundary, under dampers,
// velocity and position limits. Then the commanded velocity: the nearest one that the acceleration limits allow in one
// period. The deadlock rule uses the intention. Safety depends on the command only.
LocalResult plan_locally(const LocalInput& input, LocalMemory& memory) {
  forget_old_goal(input, memory);
  LocalResult result;
  const JointVector still = JointVector::Zero(input.q.size());
  const JointVector braking = braking_velocity(input.limits, input.qd, input.dt);
  const JointVector& target = memory.detour.active ? memory.detour.q : input.q_goal;
  TrajectoryTracking& tracking = memory.tracking;
  const bool tracks = input.has_goal && tracking.follows();
  const bool at_goal = !tracks && farthest_joint(input.limits, input.q, input.q_goal) < input.parameters.goal_tolerance;
  const bool at_rest = input.qd.cwiseAbs().maxCoeff() < 10.0 * input.parameters.goal_tolerance;
  memory.right_of_way.under_way = memory.right_of_way.under_way && !(at_goal && at_rest);
  const bool blocked = memory.deviation.active || memory.without_progress > 0.0;
  const RightOfWayInput others{
      input.parameters, input.arms, input.self, input.rows, input.dt, blocked, distance_to_goal(input, tracking)};
  update_right_of_way(others, memory);
  result.yields_to = memory.right_of_way.yields_to;
  const bool returns = input.has_goal && !tracks && !at_goal && !memory.right_of_way.under_way;
  if (returns) memory.deviation.active = false;
  const Purpose purpose{tracks, at_goal, result.yields_to >= 0, returns};
  const MethodInput method_input{input.limits, input.q,    input.qd,    input.q_goal, target,
                                 input.dt,     input.rows, input.scene, input.speed};
  const MethodState state{memory.method, memory.deviation, memory.random, memory.rollout_wait};
  const double time_before = tracking.time;
  const WantedMotion wish = wanted_motion(input, purpose, others, method_input, state, memory);
  const JointVector& wanted = wish.velocity;
  result.stalled = wish.stalled;
  const VelocityBounds bounds = velocity_bounds(input);

  QpProblem problem;
  for (const Row& row : input.rows) problem.add_row(row.g, row.h, row.key);
  bool intention_relaxed = false;
  QpSolution intended = project(problem, wanted, bounds, still, memory.intended, intention_relaxed);
  result.detouring = memory.detour.active;
  if (memory.detour.active) {
    update_detour(input, intended.x, wanted, memory.detour);
  } else if (!at_goal && !purpose.yields && !tracks && !returns) {
    const ConstrainedMotion constrained{wanted, intended.x, bounds, strongest_row(intended), memory.right_of_way.leads};
    const Redirection redirection = input.parameters.method->redirect(method_input, constrained, state);
    result.awaiting_rollout = redirection.awaiting_rollout;
    if (redirection.velocity) {
      intended = project(problem, *redirection.velocity, bounds, still, memory.followed, intention_relaxed);
    }
  } else if (returns && !purpose.yields && deadlocked(intended.x, wanted, kReturningShare)) {
    intended.x = project(problem, still, bounds, still, memory.followed, intention_relaxed).x;
  }
  result.following = memory.deviation.active;
  result.binding_row = strongest_row(intended);
  // On the boundary no row has a multiplier: the followed row binds.
  if (result.following && memory.deviation.row >= 0) result.binding_row = memory.deviation.row;

  command(input, {intended.x, intention_relaxed, bounds, braking}, problem, memory, result);
  if (input.has_goal && tracking.is_bound()) {
    const JointVector q_next = input.q + 0.5 * (input.qd + result.qd) * input.dt;
    const double stop_time = input.box != nullptr ? longest_stop_time(input.limits) + input.dt : 0.0;
    keep_box(input.limits, q_next, result.qd, input.dt, stop_time, time_before, tracking);
  }

  judge_progress(input, purpose, memory, result);
  return result;
}

}  // namespace hecaton::planner
