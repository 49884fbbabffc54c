#include "planner/methods/boundary_following/boundary_following.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "planner/local/goal_objective.hpp"
#include "planner/qp/dense_qp.hpp"

namespace hecaton::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Shorter projected normals do not constrain motion in P [m/rad].
constexpr double kFlat = 1e-9;
/// A vertex slower than this share of the fastest step in P counts as null (fig. 10).
constexpr double kNullShare = 0.02;
constexpr int kMostSwitches = 4;

/// A half-plane A · u ≤ b of the plane P, u = (u₁, u₂) [rad/s].
struct HalfPlane {
  Eigen::Vector2d A;  ///< unit
  double b;
  int row;        ///< its source; −1: a joint limit
  bool obstacle;  ///< from a pair inside the influence distance: it can be followed
};

struct ProjectedConstraints {
  std::array<HalfPlane, kMaxRows + 2 * kMaxJoints> items;
  int count = 0;

  void add(const Eigen::Vector2d& A, double b, int row, bool obstacle) {
    const double length = A.norm();
    if (length < kFlat || count == static_cast<int>(items.size())) return;
    items[count++] = {A / length, b / length, row, obstacle};
  }
};

// [Lahouar06] eq. 14–20: au₁ = a·U₁, au₂ = a·U₂.
// differs from paper: velocity and position limits are projected, too, because the vertex could be unbounded otherwise.
ProjectedConstraints project(const FollowerMemory& memory, const VelocityBounds& bounds, std::span<const Row> rows) {
  ProjectedConstraints projected;
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
    const Row& row = rows[i];
    projected.add({row.g.dot(memory.U1), row.g.dot(memory.U2)}, row.h, i, row.influences);
  }
  for (Eigen::Index j = 0; j < bounds.upper.size(); ++j) {
    const Eigen::Vector2d unit(memory.U1[j], memory.U2[j]);
    projected.add(unit, bounds.upper[j], -1, false);
    projected.add(-unit, -bounds.lower[j], -1, false);
  }
  return projected;
}

/// The part of the line p + t·S inside all half-planes but `skip`, and the half-plane that ends it.
struct Interval {
  double low = -kInfinity;
  double high = kInfinity;
  int high_from = -1;
  [[nodiscard]] bool empty() const { return low > high; }
};

Interval clip(const ProjectedConstraints& all, int skip, const Eigen::Vector2d& p, const Eigen::Vector2d& S) {
  Interval interval;
  for (int i = 0; i < all.count; ++i) {
    if (i == skip) continue;
    const double rate = all.items[i].A.dot(S);
    const double room = all.items[i].b - all.items[i].A.dot(p);
    if (std::abs(rate) < 1e-12) {
      if (room < 0.0) interval.low = kInfinity;
    } else if (rate > 0.0) {
      if (room / rate < interval.high) {
        interval.high = room / rate;
        interval.high_from = i;
      }
    } else {
      interval.low = std::max(interval.low, room / rate);
    }
  }
  return interval;
}

/// The obstacle constraint with the largest scalar product with A_lock; −1: none.
int track(const ProjectedConstraints& projected, const Eigen::Vector2d& A_lock) {
  int tracked = -1;
  double most = 0.0;
  for (int i = 0; i < projected.count; ++i) {
    const double product = projected.items[i].A.dot(A_lock);
    if (projected.items[i].obstacle && product > most) {
      most = product;
      tracked = i;
    }
  }
  return tracked;
}

JointVector unit_normal_to(const JointVector& U1, JointVector direction) {
  direction -= U1.dot(direction) * U1;
  return direction.normalized();
}

JointVector random_direction(Random& random, Eigen::Index n) {
  JointVector direction(n);
  for (auto& value : direction) value = random.normal();
  return direction;
}

void aim(FollowerMemory& memory, const Row& blocking) {
  const Eigen::Vector2d A(blocking.g.dot(memory.U1), blocking.g.dot(memory.U2));
  memory.A_lock = A.norm() < kFlat ? Eigen::Vector2d(1.0, 0.0) : A.normalized();
  memory.time_in_subspace = 0.0;
  memory.switches_in_subspace = 0;
}

}  // namespace

void start_following(BoundaryFollower follower, const JointLimits& limits, const JointVector& q,
                     const JointVector& way_to_goal, const Row& blocking) {
  FollowerMemory& memory = follower.memory;
  Random& random = follower.random;
  follower.deviation.active = true;
  memory.d_lock = way_to_goal.norm();
  memory.U1 = way_to_goal / memory.d_lock;  // eq. 10
  // eq. 11–12: V towards q_lim, U₂ its part orthogonal to U₁. The limits are drawn as section 3.1 draws left or right.
  JointVector V;
  if (follower.deviation.drawn == 0) {
    const bool upper = random.uniform() < 0.5;
    V = (upper ? limits.upper : limits.lower) - q;
    for (auto& value : V) {
      if (std::isinf(value)) value = std::copysign(std::numbers::pi, value);  // a continuous joint: half a turn away
    }
  } else {
    V = random_direction(random, q.size());
  }
  memory.U2 = unit_normal_to(memory.U1, V);
  if (!memory.U2.allFinite()) memory.U2 = unit_normal_to(memory.U1, random_direction(random, q.size()));
  ++follower.deviation.drawn;
  aim(memory, blocking);
}

void resample_subspace(BoundaryFollower follower, const JointVector& way_to_goal, std::span<const Row> rows) {
  follow_across(follower, way_to_goal, random_direction(follower.random, way_to_goal.size()), rows);
}

void follow_across(BoundaryFollower follower, const JointVector& way_to_goal, const JointVector& across,
                   std::span<const Row> rows) {
  FollowerMemory& memory = follower.memory;
  const JointVector U1 = way_to_goal.normalized();
  const JointVector U2 = unit_normal_to(U1, across);
  if (!U2.allFinite()) return;
  memory.d_lock = way_to_goal.norm();
  memory.U1 = U1;
  memory.U2 = U2;
  ++follower.deviation.drawn;
  memory.time_in_subspace = 0.0;
  memory.switches_in_subspace = 0;
  memory.A_lock = {1.0, 0.0};
  double most = 0.0;
  for (const Row& row : rows) {
    const Eigen::Vector2d A(row.g.dot(memory.U1), row.g.dot(memory.U2));
    if (row.influences && A.x() > most) {
      most = A.x();
      memory.A_lock = A.normalized();
    }
  }
}

std::optional<JointVector> follow_boundary(BoundaryFollower follower, const VelocityBounds& bounds,
                                           std::span<const Row> rows) {
  FollowerMemory& memory = follower.memory;
  const ProjectedConstraints projected = project(memory, bounds, rows);
  int followed = track(projected, memory.A_lock);
  if (followed < 0) return std::nullopt;

  Eigen::Vector2d u = Eigen::Vector2d::Zero();
  for (int attempt = 0; attempt <= kMostSwitches; ++attempt) {
    const HalfPlane& wall = projected.items[followed];
    memory.A_lock = wall.A;
    follower.deviation.row = wall.row;
    const Eigen::Vector2d S(-wall.A.y(), wall.A.x());  // eq. 22
    // The vertex on the followed constraint, or, if limits exclude that line, the end of the motion along S from rest.
    Eigen::Vector2d p = wall.b * wall.A;
    Interval interval = clip(projected, followed, p, S);
    if (interval.empty()) {
      p.setZero();
      interval = clip(projected, -1, p, S);
    }
    int blocking = interval.high_from;
    if (!interval.empty() && std::isfinite(interval.high)) {
      u = p + interval.high * S;
      const double fastest = bounds.upper.maxCoeff();
      if (u.norm() > kNullShare * fastest && interval.high > 0.0) break;
    }
    if (blocking < 0 || blocking == followed) break;
    followed = blocking;  // fig. 10: follow what blocks
    ++memory.switches_in_subspace;
  }
  return JointVector(u.x() * memory.U1 + u.y() * memory.U2);  // eq. 13
}

namespace {

/// Factor of the deadlock fraction for an arm with the right of way, which is slow while other arms yield.
constexpr double kPushFraction = 0.3;

BoundaryFollower follower_in(FollowerMemory& memory, MethodState state) {
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

bool BoundaryFollowing::is_blocked(const JointVector& possible, const JointVector& wanted) const {
  return deadlocked(possible, wanted, parameters.deadlock_fraction);
}

/// The time limit is over, or the constraints have changed so often that the path in the plane must have closed. Then
/// [Lahouar06, section 3.1] concludes that there is no path; this method concludes that there is none in this plane.
bool BoundaryFollowing::exhausted(const FollowerMemory& follower, const Deviation& deviation) const {
  const FollowerParameters& p = parameters;
  return p.resample_after > 0.0 && (follower.time_in_subspace > p.subspace_time(deviation.drawn) ||
                                    follower.switches_in_subspace > p.most_switches);
}

void BoundaryFollowing::start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const {
  if (blocking < 0) return;
  start_following(follower_in(follower_of(state.memory), state), input.limits, input.q, way, input.rows[blocking]);
}

void BoundaryFollowing::renew(const MethodInput& input, const JointVector& way, MethodState state) const {
  resample_subspace(follower_in(follower_of(state.memory), state), way, input.rows);
}

void SingleSubspace::start(const MethodInput& input, const JointVector& way, int blocking, MethodState state) const {
  state.deviation.drawn = 0;  // each subspace is the first one
  BoundaryFollowing::start(input, way, blocking, state);
}

/// Enters, keeps and leaves boundary following [Lahouar06, section 3.3 and 4]. Returns true if the arm would enter but
/// waits for a rollout first.
bool BoundaryFollowing::update(const MethodInput& input, const ConstrainedMotion& constrained, const JointVector& way,
                               MethodState state) const {
  FollowerMemory& follower = follower_of(state.memory);
  Deviation& deviation = state.deviation;
  if (deviation.active) {
    follower.time_in_subspace += input.dt * input.speed;
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
  // differs from paper: without a constraint to follow, the local planner continues straight.
  const BoundaryFollower follower = follower_in(follower_of(state.memory), state);
  redirection.velocity = follow_boundary(follower, constrained.bounds, input.rows);
  state.deviation.active = redirection.velocity.has_value();
  return redirection;
}

}  // namespace hecaton::planner
