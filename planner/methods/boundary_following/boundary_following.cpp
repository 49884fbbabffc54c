#include "planner/methods/boundary_following/boundary_following.hpp"

#include "planner/local/deadlock_monitor.hpp"
#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {
namespace {

/// An arm with the right of way is slow while the others make room; that is no deadlock yet above this share of it.
constexpr double kPushFraction = 0.3;

Follower follower_in(FollowerMemory& memory, MethodState state) {
  return {memory, state.deviation, state.random};
}

}  // namespace

void BoundaryFollowing::visit_parameters(ParameterVisitor& visitor) {
  const ParameterRange fraction{0.0, 1.0, "", true};
  visitor.section("follower");
  visitor.number("deadlock_fraction", parameters.deadlock_fraction, fraction);
  visitor.number("exit_fraction", parameters.exit_fraction, fraction);
  visitor.seconds("resample_after", parameters.resample_after, {0.0, 3600.0, "s"});
  visitor.number("resample_growth", parameters.resample_growth, {1.0, 100.0, ""});
  visitor.seconds("resample_longest", parameters.resample_longest, {0.0, 3600.0, "s"});
}

std::optional<std::string> BoundaryFollowing::validate() const {
  const FollowerParameters& p = parameters;
  const auto fraction = [](double value) { return value > 0.0 && value < 1.0; };
  if (!fraction(p.deadlock_fraction)) {
    return must_be("follower.deadlock_fraction", p.deadlock_fraction, "between 0 and 1, both excluded");
  }
  if (!fraction(p.exit_fraction)) {
    return must_be("follower.exit_fraction", p.exit_fraction, "between 0 and 1, both excluded");
  }
  if (!std::isfinite(p.resample_after) || p.resample_after < 0.0) {
    return must_be("follower.resample_after", p.resample_after, "0 (never) or a time in seconds");
  }
  if (!std::isfinite(p.resample_growth) || p.resample_growth < 1.0) {
    return must_be("follower.resample_growth", p.resample_growth, "1 or more");
  }
  if (!std::isfinite(p.resample_longest) || p.resample_longest < p.resample_after) {
    return must_be("follower.resample_longest", p.resample_longest,
                   compared("a time in seconds, no shorter than", "resample_after", p.resample_after));
  }
  return std::nullopt;
}

bool BoundaryFollowing::held_back(const JointVector& possible, const JointVector& wanted) const {
  return deadlocked(possible, wanted, parameters.deadlock_fraction);
}

/// The subspace has been followed long enough, or so many constraints have taken turns that the walk in the plane must
/// have closed: [Lahouar06] section 3.1 concludes then that there is no way; we conclude that there is none in this
/// plane.
bool BoundaryFollowing::exhausted(const FollowerMemory& follower, const Deviation& deviation) const {
  const FollowerParameters& p = parameters;
  return p.resample_after > 0.0 &&
         (follower.time_in_subspace > p.patience(deviation.drawn) || follower.switches_in_subspace > p.most_switches);
}

void BoundaryFollowing::start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const {
  if (blocking < 0) return;
  start_following(follower_in(follower_of(state.memory), state), input.limits, input.q, way, input.rows[blocking]);
}

void BoundaryFollowing::renew(const MethodInput& input, const JointVector& way, MethodState state) const {
  redraw_subspace(follower_in(follower_of(state.memory), state), way, input.rows);
}

void SingleSubspace::start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const {
  state.deviation.drawn = 0;  // each way around is the first one
  BoundaryFollowing::start(input, way, blocking, state);
}

/// Enters, keeps and leaves boundary following [Lahouar06, section 3.3 and 4]. True when the arm would enter, but
/// waits for a rollout first.
bool BoundaryFollowing::update(const MethodInput& input, const ConstrainedMotion& constrained, const JointVector& way,
                               MethodState state) const {
  FollowerMemory& follower = follower_of(state.memory);
  Deviation& deviation = state.deviation;
  if (deviation.active) {
    follower.time_in_subspace += input.dt;
    const bool nearer = way.norm() < parameters.exit_fraction * follower.d_lock;
    if (nearer) {
      deviation.active = false;
    } else if (exhausted(follower, deviation) || deviation.renew) {
      renew(input, way, state);
    }
  }
  const double fraction =
      constrained.has_right_of_way ? kPushFraction * parameters.deadlock_fraction : parameters.deadlock_fraction;
  deviation.renew = false;
  if (!deviation.active && deadlocked(constrained.possible, constrained.wanted, fraction)) {
    if (state.rollout_wait > 0.0) {
      state.rollout_wait -= input.dt;
      return true;
    }
    start(input, way, constrained.blocking_row, state);
  }
  return false;
}

Redirection BoundaryFollowing::redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                        MethodState state) const {
  const JointVector way = joint_difference(input.limits, input.q, input.q_goal);
  Redirection redirection;
  redirection.awaiting_rollout = update(input, constrained, way, state);
  if (!state.deviation.active) return redirection;
  // differs from paper: when no constraint is left to follow, the local planner takes over again.
  const Follower follower = follower_in(follower_of(state.memory), state);
  redirection.velocity = follow_boundary(follower, constrained.bounds, input.rows);
  state.deviation.active = redirection.velocity.has_value();
  return redirection;
}

}  // namespace hecaton::planner
