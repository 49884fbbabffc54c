#include "planner/local/trajectory_tracking.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "planner/local/goal_objective.hpp"
#include "planner/local/joint_distance.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// The time runs freely up to the first lag, and stands from the second on [rad | m].
constexpr double kFreeLag = 0.01;
constexpr double kLongestLag = 0.05;
/// With a path tolerance the time already stands at this share of it.
constexpr double kLagShare = 0.5;
/// Set-points use this share of the path tolerance; the rest is for the errors of the drive.
constexpr double kBoxShare = 0.8;
/// The wanted velocity uses this share of the velocity at which the arm can stop in the box.
constexpr double kVelocityInBox = 0.8;
/// An arm that goes around is searched on this part of the trajectory in each period [s].
constexpr double kCreep = 0.25;
/// A joint without tolerance counts as one with this, to find where the arm is [rad | m].
constexpr double kLooseTolerance = 0.3;
/// The rate grows with this share of the acceleration limits; the rest is for the trajectory's own accelerations.
constexpr double kGrowthShare = 0.5;
/// The rate changes at most this much in a second.
constexpr double kFastestChange = 10.0;
/// The rate before a jump of the velocity falls with this share of the acceleration limits. Jumps farther away in time
/// do not count, and a jump may have what the limits allow in kJumpTime, at the end in kJumpTimeAtEnd [s].
constexpr double kBrakingShare = 0.8;
constexpr double kBrakingTime = 1.0;
constexpr double kJumpTime = 0.05;
constexpr double kJumpTimeAtEnd = 0.02;
/// The arm is searched on this part of the trajectory after a pause [s], and on all the rest when it is farther from
/// that part than kNear [rad | m].
constexpr double kSearchedTime = 3.0;
constexpr double kNear = 0.2;
/// Of several times at which the arm is about as near, within this, the first counts [rad | m].
constexpr double kAboutAsNear = 0.01;
/// Path tolerances count from the path within this before and after the present time [s].
constexpr double kPathWindow = 0.5;

/// Longest rate that `velocity`, a velocity of the trajectory, allows within the velocity limits.
double fastest_rate(const JointLimits& limits, const JointVector& velocity) {
  double rate = 1.0;
  for (Eigen::Index j = 0; j < velocity.size(); ++j) {
    const double speed = std::abs(velocity[j]);
    if (speed > limits.velocity[j]) rate = std::min(rate, limits.velocity[j] / speed);
  }
  return rate;
}

/// Change of the rate in a second that needs `share` of the acceleration limits.
double rate_change(const JointLimits& limits, const JointVector& velocity, double share) {
  double change = kFastestChange;
  for (Eigen::Index j = 0; j < velocity.size(); ++j) {
    const double speed = std::abs(velocity[j]);
    if (speed > 0.0) change = std::min(change, share * limits.acceleration[j] / speed);
  }
  return change;
}

/// Without velocities of the points, the velocity jumps at a point. The rate falls before it as the arm can brake.
double rate_before_corners(const JointLimits& limits, const TrajectoryTracking& tracking) {
  const std::vector<TimedPoint>& points = tracking.trajectory->points;
  const auto velocity_to = [&](std::size_t i) -> JointVector {
    if (i == 0 || i >= points.size()) return JointVector::Zero(points.front().q.size());
    return (points[i].q - points[i - 1].q) / (points[i].time - points[i - 1].time);
  };
  double fastest = 1.0;
  for (std::size_t i = tracking.trajectory->next_point(tracking.time); i < points.size(); ++i) {
    const double left = points[i].time - tracking.time;
    if (left > kBrakingTime) break;
    if (points[i].qd.size() > 0) continue;
    const JointVector before = velocity_to(i);
    const JointVector jump = (velocity_to(i + 1) - before).cwiseAbs();
    double at_corner = 1.0;
    for (Eigen::Index j = 0; j < jump.size(); ++j) {
      const double allowed = (i + 1 < points.size() ? kJumpTime : kJumpTimeAtEnd) * limits.acceleration[j];
      if (jump[j] > allowed) at_corner = std::min(at_corner, allowed / jump[j]);
    }
    const double change = rate_change(limits, before, kBrakingShare);
    fastest = std::min(fastest, std::sqrt(at_corner * at_corner + 2.0 * change * left));
  }
  return fastest;
}

double longest_lag(const TimedTrajectory& trajectory) {
  double longest = kLongestLag;
  for (const double tolerance : trajectory.path_tolerance) longest = std::min(longest, kLagShare * tolerance);
  return longest;
}

/// T = √(x / a) of a tolerance x and an acceleration a. There the velocities x / T and a T are equal: the highest one
/// that satisfies both.
double stop_time_on_path(const JointLimits& limits, const JointVector& tolerance) {
  double time = longest_stop_time(limits);
  for (Eigen::Index j = 0; j < tolerance.size(); ++j) {
    time = std::min(time, std::sqrt(kBoxShare * tolerance[j] / limits.acceleration[j]));
  }
  return time;
}

/// An arm at (q, q̇) is in the box at that time, and its velocity is below the distance to the sides over `stop_time`.
bool in_box(const JointLimits& limits, const JointVector& q, const JointVector& qd, double stop_time, double when,
            const TrajectoryTracking& tracking) {
  const JointVector off = joint_difference(limits, tracking.at(when).q, q);
  const JointVector& tolerance = tracking.trajectory->path_tolerance;
  return ((off + stop_time * qd.cwiseMax(0.0)).array() <= kBoxShare * tolerance.array()).all() &&
         ((off + stop_time * qd.cwiseMin(0.0)).array() >= -kBoxShare * tolerance.array()).all();
}

struct Nearest {
  double time;
  double distance;  ///< [rad | m]
};

/// The first time within [from, to] at which the trajectory is about nearest to q.
Nearest nearest(const JointLimits& limits, const JointVector& q, const TrajectoryTracking& tracking, double from,
                double to) {
  constexpr int kSamples = 256;
  std::array<double, kSamples + 1> distances;
  for (int i = 0; i <= kSamples; ++i) {
    distances[i] = farthest_joint(limits, q, tracking.at(from + (to - from) * i / kSamples).q);
  }
  const double least = *std::min_element(distances.begin(), distances.end());
  const auto first = std::find_if(distances.begin(), distances.end(),
                                  [&](double distance) { return distance <= least + kAboutAsNear; });
  return {from + (to - from) * static_cast<double>(first - distances.begin()) / kSamples, *first};
}

}  // namespace

JointState TrajectoryTracking::at(double when) const {
  const TimedPoint& first = trajectory->points.front();
  if (begun && when < first.time && start.time < first.time) return interpolate(start, first, when);
  return trajectory->at(when);
}

void TrajectoryTracking::describe(MemoryArchive& archive) {
  bool has = trajectory != nullptr;
  archive(has);
  if (has) {
    TimedTrajectory value;
    if (!archive.loads()) value = *trajectory;
    value.describe(archive);
    if (archive.loads()) trajectory = std::make_shared<const TimedTrajectory>(std::move(value));
  } else {
    trajectory = nullptr;
  }
  archive.number(phase, 0, static_cast<int>(TrackingPhase::kAround));
  archive(time, rate, begun, start);
  if (archive.loads() && (has ? trajectory->points.empty() : phase != TrackingPhase::kNone)) archive.fail();
}

JointVector track(const JointLimits& limits, const JointVector& q, const JointVector& qd, double dt, double speed,
                  bool waits, TrajectoryTracking& tracking) {
  const double duration = tracking.trajectory->duration();
  const JointState now = tracking.at(tracking.time);
  const double behind = farthest_joint(limits, q, now.q);
  const double longest = longest_lag(*tracking.trajectory);
  const double free = std::min(kFreeLag, 0.5 * longest);
  const double keeps_up = waits ? 0.0 : std::clamp((longest - behind) / (longest - free), 0.0, 1.0);
  const double wanted_rate =
      std::min({keeps_up, speed, fastest_rate(limits, now.qd), rate_before_corners(limits, tracking)});
  const double before = tracking.rate;
  tracking.rate = wanted_rate > before ? std::min(wanted_rate, before + dt * rate_change(limits, now.qd, kGrowthShare))
                                       : std::max(wanted_rate, before - dt * rate_change(limits, now.qd, 1.0));
  tracking.time = std::min(duration, tracking.time + 0.5 * (before + tracking.rate) * dt);
  const JointState next = tracking.at(tracking.time);
  const JointVector velocity = tracking.rate * next.qd;
  // What is left when the arm moves with that velocity at the end of the period.
  const JointVector there = q + 0.5 * (qd + velocity) * dt;
  return velocity + goal_velocity(limits, there, next.q, dt);
}

void resume_tracking(const JointLimits& limits, const JointVector& q, const JointVector& qd,
                     TrajectoryTracking& tracking) {
  const double duration = tracking.trajectory->duration();
  const bool first = !tracking.begun;
  if (first || tracking.time < tracking.trajectory->points.front().time) {
    tracking.begun = true;
    tracking.start = {tracking.time, q, qd, {}};
  }
  if (!first || tracking.time > 0.0) {
    Nearest found = nearest(limits, q, tracking, tracking.time, std::min(duration, tracking.time + kSearchedTime));
    if (found.distance > kNear) {
      const Nearest farther = nearest(limits, q, tracking, tracking.time, duration);
      if (farther.distance < found.distance) found = farther;
    }
    tracking.time = found.time;
  }
  // The part of the trajectory's velocity that the arm has.
  const JointVector wanted = tracking.at(tracking.time).qd;
  const double square = wanted.squaredNorm();
  tracking.rate = square > 0.0 ? std::clamp(qd.dot(wanted) / square, 0.0, 1.0) : 1.0;
}

PathBox path_box(const JointLimits& limits, const JointVector& q, const TrajectoryTracking& tracking) {
  const JointVector centre = q + joint_difference(limits, q, tracking.at(tracking.time).q);
  const JointVector reach = kBoxShare * tracking.trajectory->path_tolerance;
  return {centre - reach, centre + reach};
}

JointVector velocity_on_path(const JointLimits& limits, double dt, const TrajectoryTracking& tracking) {
  const JointVector& tolerance = tracking.trajectory->path_tolerance;
  const double stop_time = stop_time_on_path(limits, tolerance);
  return limits.velocity.cwiseMin(limits.acceleration * stop_time)
      .cwiseMin(kVelocityInBox * kBoxShare / (stop_time + dt) * tolerance);
}

void keep_box(const JointLimits& limits, const JointVector& q, const JointVector& qd, double dt, double stop_time,
              double before, TrajectoryTracking& tracking) {
  constexpr int kSteps = 8;
  const JointVector& tolerance = tracking.trajectory->path_tolerance;
  if (tracking.follows()) {
    const double step = (tracking.time - before) / kSteps;
    // An arm that has just come near something is still too fast to stop in the box.
    const double stops = in_box(limits, q, qd, stop_time, before, tracking) ? stop_time : 0.0;
    int steps = kSteps;
    while (steps > 0 && !in_box(limits, q, qd, stops, before + steps * step, tracking)) --steps;
    if (steps == kSteps) return;
    tracking.time = before + steps * step;
    tracking.rate = std::min(tracking.rate, steps * step / dt);
  } else if (tracking.phase == TrackingPhase::kAround) {
    const double to = std::min(tracking.trajectory->duration(), before + kCreep);
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kSteps; ++i) {
      const double when = before + (to - before) * i / kSteps;
      const JointVector off = joint_difference(limits, tracking.at(when).q, q);
      const double distance = off.cwiseQuotient(tolerance.cwiseMin(kLooseTolerance)).squaredNorm();
      if (distance >= least || (i > 0 && !in_box(limits, q, qd, stop_time, when, tracking))) continue;
      least = distance;
      tracking.time = when;
    }
  }
}

int outside_path_tolerance(const JointLimits& limits, const JointVector& q, const TrajectoryTracking& tracking) {
  if (!tracking.trajectory || !tracking.trajectory->has_path_tolerance() || !tracking.begun) return -1;
  constexpr int kParts = 20;
  const JointVector& tolerance = tracking.trajectory->path_tolerance;
  const double from = std::max(tracking.start.time, tracking.time - kPathWindow);
  const double to = std::min(tracking.trajectory->duration(), tracking.time + kPathWindow);
  double least = std::numeric_limits<double>::infinity();
  int joint = -1;
  JointVector last = tracking.at(from).q;
  for (int i = 1; i <= kParts; ++i) {
    const JointVector next = tracking.at(from + (to - from) * i / kParts).q;
    // In units of the tolerances; joints without one do not count.
    const JointVector way = joint_difference(limits, last, next).cwiseQuotient(tolerance);
    const JointVector off = joint_difference(limits, last, q).cwiseQuotient(tolerance);
    const double length2 = way.squaredNorm();
    const double share = length2 > 0.0 ? std::clamp(off.dot(way) / length2, 0.0, 1.0) : 0.0;
    Eigen::Index worst = 0;
    const double distance = (off - share * way).cwiseAbs().maxCoeff(&worst);
    if (distance < least) {
      least = distance;
      joint = static_cast<int>(worst);
    }
    last = next;
  }
  return least > 1.0 ? joint : -1;
}

}  // namespace hecaton::planner
