#include "services/ros2/trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "planner/local/goal_objective.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2_messages/cell_description.hpp"

namespace hecaton::ros2 {
namespace {

using planner::JointVector;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// A trajectory begins at most this far from the measured position [rad | m].
constexpr double kStartTolerance = 0.05;
/// A velocity at the end below this counts as rest [rad/s | m/s].
constexpr double kRest = 1e-3;
/// Mean velocities between points may exceed a limit by this factor, for rounded times.
constexpr double kVelocityRounding = 1.02;
constexpr double kLongestDuration = 3600.0;  // [s]
/// A stamp may be this far in the future [s]: clocks of two hosts differ.
constexpr double kLongestAhead = 0.1;
/// Of a joint without a goal tolerance, beside joints with one [rad | m]: the usual `goal_tolerance` of a cell file.
constexpr double kJointTolerance = 2e-3;
/// An arm rests when each joint stays within kStill for kRestTime, by positions that are at most kRecent old.
constexpr double kStill = 1e-3;    // [rad | m]
constexpr double kRestTime = 0.2;  // [s]
constexpr double kRecent = 0.2;    // [s]

std::string rounded(double value) {
  std::array<char, 32> text{};
  const int size = std::snprintf(text.data(), text.size(), "%.4g", value);
  return {text.data(), static_cast<std::size_t>(size)};
}

std::string no_planner_heard() {
  return "no planner of the arm was heard for " + rounded(TrajectoryFollower::kHeardTime) +
         " s; `hecaton status` shows whether one runs";
}

struct RefusedTrajectory {
  TrajectoryRefusal refusal;
};

[[noreturn]] void refuse(TrajectoryCode code, std::string text) {
  throw RefusedTrajectory{{code, std::move(text)}};
}

/// Values in the order of the goal's joints as a joint vector of the arm.
JointVector sorted(const std::vector<double>& values, const std::vector<int>& joints) {
  JointVector q(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t i = 0; i < joints.size(); ++i) q[joints[i]] = values[i];
  return q;
}

/// `q` with joints that turn without end turned to where they are nearest to `near`.
JointVector unwound(const planner::JointLimits& limits, JointVector q, const JointVector& near) {
  const JointVector way = planner::joint_difference(limits, q, near);
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    if (std::isinf(limits.upper[j])) q[j] = near[j] - way[j];
  }
  return q;
}

void check_point(const JointTrajectoryPoint& point, std::size_t index, const std::vector<int>& joints,
                 const planner::Arm& arm) {
  const std::string where = "trajectory.points[" + std::to_string(index) + "]";
  const auto check_values = [&](const std::vector<double>& values, const char* name, double largest, bool optional) {
    if (optional && values.empty()) return;
    if (values.size() != joints.size()) {
      refuse(TrajectoryCode::kInvalidGoal, where + "." + name + " has " + std::to_string(values.size()) +
                                               " values, but must have " + std::to_string(joints.size()));
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string field = where + "." + name + "[" + std::to_string(i) + "]";
      if (auto complaint = out_of_range(field, values[i], largest)) {
        refuse(TrajectoryCode::kInvalidGoal, std::move(*complaint));
      }
    }
  };
  check_values(point.positions, "positions", kLargestPosition, false);
  check_values(point.velocities, "velocities", kLargestVelocity, true);
  check_values(point.accelerations, "accelerations", kLargestAcceleration, true);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int j = joints[i];
    const double q = point.positions[i];
    const double margin = planner::kLimitRounding;
    if (q >= arm.limits.lower[j] - margin && q <= arm.limits.upper[j] + margin) continue;
    refuse(TrajectoryCode::kInvalidGoal, where + ": joint " + arm.model->joint_names[static_cast<std::size_t>(j)] +
                                             " = " + rounded(q) + " must be within [" + rounded(arm.limits.lower[j]) +
                                             ", " + rounded(arm.limits.upper[j]) + "]");
  }
}

/// Between points a joint that turns without end makes the turns that they have, as the planner interpolates.
void check_velocity(const planner::TimedPoint& from, const planner::TimedPoint& to, const planner::Arm& arm) {
  for (Eigen::Index j = 0; j < to.q.size(); ++j) {
    const double velocity = std::abs(to.q[j] - from.q[j]) / (to.time - from.time);
    if (velocity <= kVelocityRounding * arm.limits.velocity[j]) continue;
    refuse(TrajectoryCode::kInvalidGoal, "joint " + arm.model->joint_names[static_cast<std::size_t>(j)] + " moves at " +
                                             rounded(velocity) + " before t = " + rounded(to.time) +
                                             " s, but its limit in the cell file is " +
                                             rounded(arm.limits.velocity[j]));
  }
}

/// Tolerances by joint; infinite: none, which 0, a negative one and one beyond all positions mean, too. Refuses NaN.
JointVector tolerances(const std::vector<JointTolerance>& given, const char* name, const planner::Arm& arm) {
  JointVector tolerance = JointVector::Constant(arm.model->joints(), kInfinite);
  for (const JointTolerance& entry : given) {
    const auto& names = arm.model->joint_names;
    const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& joint) {
      return entry.name == joint || entry.name == prefixed(arm.name, joint);
    });
    if (found == names.end()) {
      refuse(TrajectoryCode::kInvalidJoints, std::string(name) + " names joint '" +
                                                 bus::printable(entry.name, bus::kLongestName) + "', which arm " +
                                                 arm.name + " does not have");
    }
    if (std::isnan(entry.position)) {
      refuse(TrajectoryCode::kInvalidGoal,
             std::string(name) + " of joint " + *found + " is not a number; 0 gives the joint no tolerance");
    }
    if (entry.position > 0.0 && entry.position <= kLargestPosition) tolerance[found - names.begin()] = entry.position;
  }
  return tolerance;
}

std::string joint_list(const planner::Arm& arm) {
  std::string text;
  for (const std::string& joint : arm.model->joint_names) text += (text.empty() ? "" : ", ") + joint;
  return text;
}

TrajectoryOrder checked(const TrajectoryGoal& goal, const planner::Arm& arm, const JointVector& q, double age) {
  const JointTrajectory& trajectory = goal.trajectory;
  const auto joints = joint_numbers(trajectory.joint_names, arm);
  if (!joints) {
    refuse(TrajectoryCode::kInvalidJoints,
           "trajectory.joint_names must have each joint of arm " + arm.name + " once: " + joint_list(arm));
  }
  if (!goal.multi_dof_trajectory.joint_names.empty() || !goal.multi_dof_trajectory.points.empty()) {
    refuse(TrajectoryCode::kInvalidGoal, "multi_dof_trajectory must be empty");
  }
  const std::size_t most =
      std::min(planner::TimedTrajectory::kMostPoints, planner::TimedTrajectory::kMostValues / joints->size());
  if (trajectory.points.empty() || trajectory.points.size() > most) {
    refuse(TrajectoryCode::kInvalidGoal, "trajectory has " + std::to_string(trajectory.points.size()) +
                                             " points, but must have 1 to " + std::to_string(most));
  }
  TrajectoryOrder order;
  order.joint_names = arm.model->joint_names;
  order.limits = arm.limits;
  planner::TimedPoint before;
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    const JointTrajectoryPoint& point = trajectory.points[i];
    check_point(point, i, *joints, arm);
    const double time = seconds_of(point.time_from_start);
    planner::TimedPoint next{time, sorted(point.positions, *joints), {}, {}};
    if (!point.velocities.empty()) next.qd = sorted(point.velocities, *joints);
    if (!point.accelerations.empty()) next.qdd = sorted(point.accelerations, *joints);
    if (i == 0) before.q = order.start = unwound(arm.limits, q, next.q);
    if (i == 0 && time == 0.0) {
      Eigen::Index farthest = 0;
      const double deviation = (next.q - order.start).cwiseAbs().maxCoeff(&farthest);
      if (deviation > kStartTolerance) {
        refuse(TrajectoryCode::kInvalidGoal, "the trajectory begins " + rounded(deviation) +
                                                 " from the measured position of joint " +
                                                 arm.model->joint_names[static_cast<std::size_t>(farthest)] +
                                                 " (limit " + rounded(kStartTolerance) + ")");
      }
      order.trajectory.points.push_back(before = std::move(next));
      continue;
    }
    if (time <= before.time) {
      refuse(TrajectoryCode::kInvalidGoal, "trajectory.points[" + std::to_string(i) + "].time_from_start = " +
                                               rounded(time) + " s must be above that of the point before");
    }
    if (time > kLongestDuration) {
      refuse(TrajectoryCode::kInvalidGoal, "trajectory.points[" + std::to_string(i) +
                                               "].time_from_start = " + rounded(time) + " s must be at most " +
                                               rounded(kLongestDuration) + " s; send a longer trajectory in parts");
    }
    check_velocity(before, next, arm);
    order.trajectory.points.push_back(before = std::move(next));
  }
  for (const double velocity : trajectory.points.back().velocities) {
    if (std::abs(velocity) > kRest) {
      refuse(TrajectoryCode::kInvalidGoal, "the last point must have velocity 0, not " + rounded(velocity));
    }
  }
  if (age > order.duration() && age > 0.0) {
    refuse(TrajectoryCode::kOldStamp,
           "the trajectory of " + rounded(order.duration()) + " s was to begin " + rounded(age) + " s ago");
  }
  if (age < -kLongestAhead) {
    refuse(
        TrajectoryCode::kInvalidGoal,
        "header.stamp is " + rounded(-age) + " s in the future (limit " + rounded(kLongestAhead) +
            " s), but a trajectory begins at once: send it when it is due, or with stamp 0 if clocks of hosts differ");
  }
  order.trajectory.path_tolerance = tolerances(goal.path_tolerance, "path_tolerance", arm);
  order.goal_tolerance = tolerances(goal.goal_tolerance, "goal_tolerance", arm);
  order.goal_time_tolerance = std::max(0.0, seconds_of(goal.goal_time_tolerance));
  return order;
}

}  // namespace

std::optional<std::string> out_of_range(const std::string& field, double value, double largest) {
  if (std::abs(value) <= largest) return std::nullopt;
  return field + " = " + rounded(value) + " must be from " + rounded(-largest) + " to " + rounded(largest);
}

planner::JointState TrajectoryOrder::at(double time) const {
  const planner::TimedPoint& first = trajectory.points.front();
  if (time >= first.time) return trajectory.at(time);
  return planner::interpolate({0.0, start, {}, {}}, first, time);
}

JointVector TrajectoryOrder::error(const JointVector& q, double time) const {
  return planner::joint_difference(limits, q, at(time).q);
}

bool TrajectoryOrder::has_goal_tolerance() const {
  return (goal_tolerance.array() < kInfinite).any();
}

bool TrajectoryOrder::ends_near(const JointVector& q, double time) const {
  const auto near = [&](const JointVector& position) {
    const JointVector off = error(position, duration()).cwiseAbs();
    for (Eigen::Index j = 0; j < off.size(); ++j) {
      if (off[j] > (std::isinf(goal_tolerance[j]) ? kJointTolerance : goal_tolerance[j])) return false;
    }
    return true;
  };
  const auto& points = trajectory.points;
  const auto left = points.begin() + static_cast<std::ptrdiff_t>(trajectory.next_point(time));
  return near(q) && near(at(time).q) &&
         std::all_of(left, points.end(), [&](const planner::TimedPoint& point) { return near(point.q); });
}

std::optional<std::vector<int>> joint_numbers(const std::vector<std::string>& names, const planner::Arm& arm) {
  const auto& joints = arm.model->joint_names;
  if (names.size() != joints.size()) return std::nullopt;
  std::vector<int> numbers;
  for (const std::string& name : names) {
    const auto found = std::find_if(joints.begin(), joints.end(), [&](const std::string& joint) {
      return name == joint || name == prefixed(arm.name, joint);
    });
    const int number = static_cast<int>(found - joints.begin());
    if (found == joints.end() || std::find(numbers.begin(), numbers.end(), number) != numbers.end())
      return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

std::variant<TrajectoryOrder, TrajectoryRefusal> check_trajectory(const TrajectoryGoal& goal, const planner::Arm& arm,
                                                                  const JointVector& q, double age) {
  try {
    return checked(goal, arm, q, age);
  } catch (const RefusedTrajectory& refused) {
    return refused.refusal;
  }
}

void PlannerSilence::update(std::optional<double> reported, bool heard, double dt) {
  const bool answered = reported != std::exchange(reported_, reported);
  if (answered) unanswered_ = 0.0;
  if (!answered && heard) unanswered_ += dt;
  unheard_ = answered || heard ? 0.0 : unheard_ + dt;
}

double RestTime::update(const planner::JointLimits& limits, const std::optional<JointVector>& q, double dt) {
  const bool rests = q && since_ && planner::joint_difference(limits, *since_, *q).cwiseAbs().maxCoeff() <= kStill;
  time_ = rests ? time_ + dt : 0.0;
  if (!rests) since_ = q;
  return time_;
}

std::optional<TrajectoryRefusal> TrajectoryFollower::update(const Input& input) {
  constexpr double kLongestEstimate = 0.25;  // beyond the last report [s]
  elapsed_ += input.dt;
  silence_.update(input.reported, input.heard, input.dt);
  rested_ = rest_.update(order_.limits, input.q_age <= kRecent ? input.q : std::nullopt, input.dt);
  rate_ = input.rate;
  reported_ = std::max(reported_, input.time);
  time_ = std::max({time_, reported_, std::min(time_ + rate_ * input.dt, reported_ + kLongestEstimate)});
  time_ = std::min(time_, order_.duration());
  if (!input.reason.empty()) late_because_ = input.reason;
  const std::string because = input.reason.empty() ? "" : ": " + input.reason;
  const auto end = [&](TrajectoryCode code, std::string text) { return TrajectoryRefusal{code, std::move(text)}; };
  switch (input.report) {
    case GoalReport::kLost:
      return end(TrajectoryCode::kInvalidGoal, "the goal was lost" + because);
    case GoalReport::kReplaced:
      return end(TrajectoryCode::kInvalidGoal, "a later goal has replaced this trajectory" + because);
    case GoalReport::kRejected:
      return end(TrajectoryCode::kInvalidGoal, "the planner rejects the trajectory" + because);
    case GoalReport::kLeftPath:
      return end(TrajectoryCode::kPathTolerance, input.reason);
    case GoalReport::kUnreported:
      if (silence_.unanswered() > kReportTime) {
        return end(TrajectoryCode::kInvalidGoal,
                   "the goal was lost: hecaton-ros2 was restarted, and no planner knows the goal");
      }
      [[fallthrough]];
    case GoalReport::kUnanswered:
    case GoalReport::kUnderWay:
      if (silence_.unheard() > kHeardTime) return end(TrajectoryCode::kInvalidGoal, no_planner_heard());
      if (silence_.unanswered() > kAnswerTime && (input.reported || input.report == GoalReport::kUnanswered)) {
        return end(TrajectoryCode::kInvalidGoal, "no planner of the arm has answered the trajectory for " +
                                                     rounded(kAnswerTime) +
                                                     " s; `hecaton status` shows whether one runs");
      }
      if (rests_near_end(input)) return end(TrajectoryCode::kSuccessful, "");
      if (order_.goal_time_tolerance > 0.0 && elapsed_ > order_.duration() + order_.goal_time_tolerance) {
        const bool before = input.reason.empty() && !late_because_.empty();
        return end(TrajectoryCode::kGoalTolerance, "the goal is not reached " + rounded(order_.goal_time_tolerance) +
                                                       " s after its time" +
                                                       (before ? "; it was late before: " + late_because_ : because));
      }
      return std::nullopt;
    case GoalReport::kReached:
      break;
  }
  return judge_arrival(input);
}

// As a joint trajectory controller, which judges the end by the goal tolerances alone. Here the planner's own accuracy
// counts, too. A tolerance above it lets the arm stop where something or its drive keeps it from the last point. The
// time of the trajectory waits with the arm: a trajectory that comes back to its first point is not over there.
bool TrajectoryFollower::rests_near_end(const Input& input) const {
  return input.report == GoalReport::kUnderWay && input.reported && input.q && order_.has_goal_tolerance() &&
         elapsed_ >= order_.duration() && rested_ >= kRestTime && order_.ends_near(*input.q, reported_);
}

std::optional<TrajectoryRefusal> TrajectoryFollower::judge_arrival(const Input& input) {
  const TrajectoryRefusal success{TrajectoryCode::kSuccessful, ""};
  if (!order_.has_goal_tolerance()) return success;
  if (!input.q) {
    without_position_ += input.dt;
    if (without_position_ <= kAnswerTime) return std::nullopt;
    return TrajectoryRefusal{TrajectoryCode::kGoalTolerance,
                             "the goal tolerances are not checked: the driver of the arm has sent no state for " +
                                 rounded(kAnswerTime) + " s"};
  }
  const JointVector error = order_.error(*input.q, order_.duration()).cwiseAbs();
  for (Eigen::Index j = 0; j < error.size(); ++j) {
    if (error[j] <= order_.goal_tolerance[j]) continue;
    // The drive may still settle: the planner keeps a reached goal as its target.
    if (order_.goal_time_tolerance > 0.0 && elapsed_ <= order_.duration() + order_.goal_time_tolerance) {
      return std::nullopt;
    }
    return TrajectoryRefusal{TrajectoryCode::kGoalTolerance,
                             "joint " + order_.joint_names[static_cast<std::size_t>(j)] + " ends " + rounded(error[j]) +
                                 " from the goal (tolerance " + rounded(order_.goal_tolerance[j]) + ")"};
  }
  return success;
}

std::optional<std::string> CancellationWait::update(const Input& input) {
  silence_.update(input.reported, input.heard, input.dt);
  const bool lost = input.restored && !input.reported && silence_.unanswered() > TrajectoryFollower::kReportTime;
  if (input.over || lost) return "canceled by its client";
  if (silence_.unheard() > TrajectoryFollower::kHeardTime) return "canceled by its client; " + no_planner_heard();
  if (silence_.unanswered() <= TrajectoryFollower::kAnswerTime) return std::nullopt;
  return "canceled by its client; no planner of the arm has confirmed it for " +
         rounded(TrajectoryFollower::kAnswerTime) + " s; `hecaton status` shows whether one runs";
}

}  // namespace hecaton::ros2
