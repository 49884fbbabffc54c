#include "planner/local/local_planner.hpp"

#include <algorithm>

#include "planner/local/deadlock_monitor.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Motion below this share of the fastest does not count as progress.
constexpr double kStillShare = 0.02;
/// An arm that stands this long before its goal says that it is blocked [s].
constexpr double kBlockedAfter = 0.5;
/// A detour need not end exactly at its way-point [rad | m].
constexpr double kDetourTolerance = 0.1;

/// An arm with the right of way is slow while the others make room; that is no deadlock yet above this share of it.
constexpr double kPushFraction = 0.3;

/// Raises every bound that `allowed`, a velocity that is always possible, would violate to what that needs.
void relax(QpProblem& problem, const JointVector& allowed) {
  for (int i = 0; i < problem.rows; ++i) {
    problem.h[i] = std::max(problem.h[i], problem.G.row(i).head(allowed.size()).dot(allowed));
  }
}

/// The velocity nearest to `target` within bounds and the rows of `problem`. Relaxed rows are never stricter than
/// `allowed`, a velocity that is always possible: standing still, or the stop profile.
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

/// What comes nearer is fled as well as can be, also where not all of it can be fled: where one thing closes in from
/// two sides, or along a direction in which hardly any joint moves the arm. From `solution`, which satisfies the
/// relaxed rows, towards the least sum of squares of what is missing from retreats (rows with h < 0), by projected
/// gradients.
void flee(QpProblem& problem, const JointVector& allowed, QpSolution& solution) {
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

/// A detour ends near its way-point, when its time is over, or when something is in its way, too; an evasion with its
/// time.
void update_detour(const LocalInput& input, const JointVector& intended, const JointVector& wanted, Detour& detour) {
  detour.time_left -= input.dt;
  if (detour.time_left <= 0.0) detour.active = false;
  if (detour.stays || detour.of_route) return;
  const JointVector way = joint_difference(input.limits, input.q, detour.q);
  const bool there = way.cwiseAbs().maxCoeff() < kDetourTolerance;
  const bool blocked = deadlocked(intended, wanted, input.parameters.follower.deadlock_fraction);
  if (there || blocked) detour.active = false;
}

bool follows_boundaries(Method method) {
  return method == Method::kBoundaryFollowing || method == Method::kSingleSubspace || method == Method::kStrategy;
}

/// Another arm's claim is followed at once, except during a detour of its own, which ends soon. Whoever got the right
/// of way goes straight, as the others retreat.
void update_right_of_way(const RightOfWayInput& input, LocalMemory& memory) {
  RightOfWay& right = memory.right_of_way;
  const bool detours = memory.detour.active && !memory.detour.of_route;
  if (input.parameters.method != Method::kBoundaryFollowing || detours) {
    right.yields_to = -1;
    return;
  }
  const std::uint32_t claim = right.claim;
  update(input, memory.random, right);
  if (right.yields_to >= 0 || right.claim != claim) memory.follower.following = false;
}

/// The subspace has been followed long enough, or so many constraints have taken turns that the walk in the plane must
/// have closed: [Lahouar06] section 3.1 concludes then that there is no way; we conclude that there is none in this
/// plane.
bool exhausted(const FollowerMemory& follower, const LocalParameters& parameters) {
  const FollowerParameters& p = parameters.follower;
  return parameters.method != Method::kSingleSubspace && p.redraw_after > 0.0 &&
         (follower.time_in_subspace > p.patience(follower.redraws) || follower.switches_in_subspace > p.most_switches);
}

/// [Mediavilla02, footnote of section 4]: uᶠ = a u₁ + b u₂ towards the goal, uᵀ = −b u₁ + a u₂ across it, to the side
/// that the strategy says. differs from paper: uᶠ has whatever part the dampers have pushed the arm out of the plane,
/// too.
void follow_in_strategy(const JointVector& way, std::span<const Row> rows, const StrategyMemory& strategy,
                        FollowerMemory& follower) {
  const Eigen::Index n = strategy.plane.u1.size();
  const double a = strategy.plane.u1.dot(way.head(n));
  const double b = strategy.plane.u2.dot(way.head(n));
  JointVector across = JointVector::Zero(way.size());
  across.head(n) = strategy.side * (a * strategy.plane.u2 - b * strategy.plane.u1);
  follow_across(follower, way, across, rows);
}

/// Enters, keeps and leaves boundary following [Lahouar06, section 3.3 and 4]. True when the arm would enter, but
/// waits for a manoeuvre first.
bool update_follower(const LocalInput& input, const JointVector& way, const JointVector& wanted,
                     const QpSolution& intended, LocalMemory& memory) {
  FollowerMemory& follower = memory.follower;
  const FollowerParameters& p = input.parameters.follower;
  if (input.parameters.method == Method::kStrategy && !memory.strategy.under_way) {
    begin_strategy(input.parameters.strategy, input.q, way, memory.strategy);
  }
  const bool by_strategy = input.parameters.method == Method::kStrategy && memory.strategy.under_way;
  if (follower.following) {
    follower.time_in_subspace += input.dt;
    const bool nearer = way.norm() < p.exit_fraction * follower.d_lock;
    if (nearer) {
      follower.following = false;
    } else if (exhausted(follower, input.parameters) || memory.subspace_wanted) {
      if (by_strategy) {
        memory.strategy.side = -memory.strategy.side;  // behaviour 3: change local direction
        follow_in_strategy(way, input.rows, memory.strategy, follower);
      } else {
        redraw_subspace(follower, memory.random, way, input.rows);
      }
    }
  }
  const double fraction = memory.right_of_way.leads ? kPushFraction * p.deadlock_fraction : p.deadlock_fraction;
  memory.subspace_wanted = false;
  if (!follower.following && deadlocked(intended.x, wanted, fraction)) {
    if (memory.time_to_think > 0.0) {
      memory.time_to_think -= input.dt;
      return true;
    }
    if (input.parameters.method == Method::kSingleSubspace) follower.redraws = 0;
    const int blocking = strongest_row(intended);
    if (blocking >= 0 && by_strategy) {
      follower.following = true;
      follow_in_strategy(way, input.rows, memory.strategy, follower);
    } else if (blocking >= 0) {
      start_following(follower, memory.random, input.limits, input.q, way, input.rows[blocking]);
    }
  }
  return false;
}

}  // namespace

void forget_old_goal(const LocalInput& input, LocalMemory& memory) {
  if (!input.has_goal) memory.right_of_way.under_way = false;
  // Who has no goal keeps its place, wherever that is by now.
  const bool as_before = input.has_goal ? memory.q_goal.size() == input.q_goal.size() && memory.q_goal == input.q_goal
                                        : memory.q_goal.size() == 0;
  if (as_before) return;
  if (input.has_goal) {
    memory.q_goal = input.q_goal;
  } else {
    memory.q_goal.resize(0);
  }
  memory.follower = {};
  memory.without_progress = 0.0;
  memory.detour.active = false;
  memory.strategy.under_way = false;
  memory.right_of_way.under_way = input.has_goal;
  memory.right_of_way.growth = 1.0;
  memory.subspace_wanted = false;
}

void begin(const Manoeuvre& manoeuvre, LocalMemory& memory) {
  memory.time_to_think = 0.0;
  if (manoeuvre.kind == ManoeuvreKind::kGoOn) return;
  memory.random = Random(manoeuvre.seed);
  const bool evades = manoeuvre.kind == ManoeuvreKind::kEvade;
  memory.detour = {evades || manoeuvre.kind == ManoeuvreKind::kDetour, manoeuvre.q, manoeuvre.patience, evades, false};
  memory.subspace_wanted = manoeuvre.kind == ManoeuvreKind::kSubspace;
  if (manoeuvre.kind != ManoeuvreKind::kSubspace) memory.follower.following = false;
}

// Two steps. First what the arm intends, as the paper plans it: towards the goal or along a boundary, under dampers,
// velocity and position limits. Then what it commands: the nearest velocity to that which one period's acceleration can
// reach. The deadlock rule looks at the intention; safety is decided by the command.
LocalResult plan_locally(const LocalInput& input, LocalMemory& memory) {
  forget_old_goal(input, memory);
  LocalResult result;
  const JointVector still = JointVector::Zero(input.q.size());
  const JointVector braking = braking_velocity(input.limits, input.qd, input.dt);
  const JointVector& target = memory.detour.active ? memory.detour.q : input.q_goal;
  const JointVector way = joint_difference(input.limits, input.q, input.q_goal);
  const bool at_goal = way.cwiseAbs().maxCoeff() < input.parameters.goal_tolerance;
  const bool at_rest = input.qd.cwiseAbs().maxCoeff() < 10.0 * input.parameters.goal_tolerance;
  memory.right_of_way.under_way = memory.right_of_way.under_way && !(at_goal && at_rest);
  const RightOfWayInput others{input.parameters, input.arms,
                               input.self,       input.rows,
                               input.dt,         memory.follower.following || memory.without_progress > 0.0};
  update_right_of_way(others, memory);
  result.yields_to = memory.right_of_way.yields_to;
  const bool yields = result.yields_to >= 0;
  const JointVector wanted = yields                    ? retreat_velocity(others, memory.right_of_way, input.limits)
                             : input.wanted != nullptr ? *input.wanted
                                                       : goal_velocity(input.limits, input.q, target, input.dt);
  const VelocityBounds bounds = speed_and_position_bounds(input.limits, input.q, input.dt);

  QpProblem problem;
  for (const Row& row : input.rows) problem.add_row(row.g, row.h, row.key);
  bool intention_relaxed = false;
  QpSolution intended = project(problem, wanted, bounds, still, memory.intended, intention_relaxed);
  result.detouring = memory.detour.active;
  if (memory.detour.active) {
    update_detour(input, intended.x, wanted, memory.detour);
  } else if (follows_boundaries(input.parameters.method) && !at_goal && !yields) {
    result.thinks = update_follower(input, way, wanted, intended, memory);
    if (memory.follower.following) {
      // differs from paper: when no constraint is left to follow, the local planner takes over again.
      const auto along = follow_boundary(memory.follower, bounds, input.rows);
      memory.follower.following = along.has_value();
      if (along) intended = project(problem, *along, bounds, still, memory.followed, intention_relaxed);
    }
  }
  result.following = memory.follower.following;
  result.binding_row = strongest_row(intended);
  // On the boundary itself nothing pushes: what binds is the boundary.
  if (result.following && memory.follower.followed_row >= 0) result.binding_row = memory.follower.followed_row;

  const VelocityBounds reachable =
      intersect(bounds, acceleration_bounds(input.limits, input.qd, braking, input.dt), braking);
  if (!intention_relaxed && inside(reachable, intended.x)) {
    result.qd = intended.x;
  } else {
    QpSolution commanded = project(problem, intended.x, reachable, braking, memory.commanded, result.relaxed);
    if (result.relaxed) flee(problem, braking, commanded);
    result.qd = commanded.x;
  }

  const bool moves = result.qd.norm() > kStillShare * input.limits.velocity.norm();
  const bool waits = memory.detour.active && memory.detour.stays;
  memory.without_progress = moves || at_goal || waits ? 0.0 : memory.without_progress + input.dt;
  result.blocked = memory.without_progress > kBlockedAfter;
  return result;
}

}  // namespace hecaton::planner
