#include "services/ros2/trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

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
constexpr std::size_t kMostPoints = 10'000;
/// The arm gets a joint goal for each kLongestStep of a trajectory, which takes memory [s].
constexpr double kLongestDuration = 3600.0;
/// A joint goal counts as passed within this distance, so that the arm does not stop at it [rad | m].
constexpr double kPassed = 0.03;

std::string rounded(double value) {
  std::array<char, 32> text{};
  const int size = std::snprintf(text.data(), text.size(), "%.4g", value);
  return {text.data(), static_cast<std::size_t>(size)};
}

struct Refused {
  TrajectoryRefusal refusal;
};

[[noreturn]] void refuse(TrajectoryCode code, std::string text) {
  throw Refused{{code, std::move(text)}};
}

/// Values in the order of the goal's joints as a joint vector of the arm.
JointVector sorted(const std::vector<double>& values, const std::vector<int>& joints) {
  JointVector q(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t i = 0; i < joints.size(); ++i) q[joints[i]] = values[i];
  return q;
}

void check_point(const JointTrajectoryPoint& point, std::size_t index, const std::vector<int>& joints,
                 const planner::Arm& arm) {
  const std::string where = "trajectory.points[" + std::to_string(index) + "]";
  const auto check_size = [&](const std::vector<double>& values, const char* name, bool optional) {
    if (optional && values.empty()) return;
    if (values.size() != joints.size()) {
      refuse(TrajectoryCode::kInvalidGoal, where + "." + name + " has " + std::to_string(values.size()) +
                                               " values, but must have " + std::to_string(joints.size()));
    }
    if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); })) {
      refuse(TrajectoryCode::kInvalidGoal, where + "." + name + " must be finite numbers");
    }
  };
  check_size(point.positions, "positions", false);
  check_size(point.velocities, "velocities", true);
  check_size(point.accelerations, "accelerations", true);
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

void check_velocity(const TimedPoint& from, const TimedPoint& to, const planner::Arm& arm) {
  for (Eigen::Index j = 0; j < to.q.size(); ++j) {
    const double velocity = std::abs(to.q[j] - from.q[j]) / (to.time - from.time);
    if (velocity <= kVelocityRounding * arm.limits.velocity[j]) continue;
    refuse(TrajectoryCode::kInvalidGoal, "joint " + arm.model->joint_names[static_cast<std::size_t>(j)] + " moves at " +
                                             rounded(velocity) + " before t = " + rounded(to.time) +
                                             " s, but its limit in the cell file is " +
                                             rounded(arm.limits.velocity[j]));
  }
}

/// Tolerances by joint. 0, or no entry: `unspecified`; negative: none.
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
    if (entry.position > 0.0) tolerance[found - names.begin()] = entry.position;
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
  if (!goal.multi_dof_trajectory.points.empty()) {
    refuse(TrajectoryCode::kInvalidGoal, "multi_dof_trajectory must be empty");
  }
  if (trajectory.points.empty() || trajectory.points.size() > kMostPoints) {
    refuse(TrajectoryCode::kInvalidGoal, "trajectory has " + std::to_string(trajectory.points.size()) +
                                             " points, but must have 1 to " + std::to_string(kMostPoints));
  }
  TrajectoryOrder order;
  order.points.push_back({0.0, q});
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    const JointTrajectoryPoint& point = trajectory.points[i];
    check_point(point, i, *joints, arm);
    const double time = seconds_of(point.time_from_start);
    const TimedPoint next{time, sorted(point.positions, *joints)};
    if (i == 0 && time == 0.0) {
      Eigen::Index farthest = 0;
      const double deviation = (next.q - q).cwiseAbs().maxCoeff(&farthest);
      if (deviation > kStartTolerance) {
        refuse(TrajectoryCode::kInvalidGoal, "the trajectory begins " + rounded(deviation) +
                                                 " from the measured position of joint " +
                                                 arm.model->joint_names[static_cast<std::size_t>(farthest)] +
                                                 " (limit " + rounded(kStartTolerance) + ")");
      }
      continue;
    }
    if (time <= order.points.back().time) {
      refuse(TrajectoryCode::kInvalidGoal, "trajectory.points[" + std::to_string(i) + "].time_from_start = " +
                                               rounded(time) + " s must be above that of the point before");
    }
    if (time > kLongestDuration) {
      refuse(TrajectoryCode::kInvalidGoal, "trajectory.points[" + std::to_string(i) +
                                               "].time_from_start = " + rounded(time) + " s must be at most " +
                                               rounded(kLongestDuration) + " s; send a longer trajectory in parts");
    }
    check_velocity(order.points.back(), next, arm);
    order.points.push_back(next);
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
  order.path_tolerance = tolerances(goal.path_tolerance, "path_tolerance", arm);
  order.goal_tolerance = tolerances(goal.goal_tolerance, "goal_tolerance", arm);
  order.goal_time_tolerance = std::max(0.0, seconds_of(goal.goal_time_tolerance));
  return order;
}

/// Joint goals of a trajectory: all its points, with at least the last of each kLongestStep and no two much closer.
std::vector<TimedPoint> steps_of(const TrajectoryOrder& order) {
  constexpr double kStep = TrajectoryFollower::kLongestStep;
  std::vector<TimedPoint> steps{order.points.front()};
  const double duration = order.duration();
  const int count = std::max(1, static_cast<int>(std::ceil(duration / kStep)));
  for (int i = 1; i <= count; ++i) {
    const double time = duration * i / count;
    steps.push_back({time, order.at(time)});
  }
  steps.back().q = order.points.back().q;
  return steps;
}

}  // namespace

JointVector TrajectoryOrder::at(double time) const {
  const auto after = std::lower_bound(points.begin(), points.end(), time,
                                      [](const TimedPoint& point, double value) { return point.time < value; });
  if (after == points.begin()) return points.front().q;
  if (after == points.end()) return points.back().q;
  const auto before = std::prev(after);
  const double share = (time - before->time) / (after->time - before->time);
  return before->q + share * (after->q - before->q);
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
  } catch (const Refused& refused) {
    return refused.refusal;
  }
}

TrajectoryFollower::TrajectoryFollower(TrajectoryOrder order) : order_(std::move(order)), steps_(steps_of(order_)) {}

TrajectoryFollower::Output TrajectoryFollower::end(TrajectoryCode code, std::string text) const {
  return {std::nullopt, TrajectoryRefusal{code, std::move(text)}};
}

TrajectoryFollower::Output TrajectoryFollower::send_next() {
  ++next_;
  return {steps_[next_].q, std::nullopt};
}

bool TrajectoryFollower::near_step(const JointVector& q) const {
  return (q - steps_[next_].q).cwiseAbs().maxCoeff() <= kPassed;
}

int TrajectoryFollower::outside(const JointVector& q) const {
  if (next_ == 0) return -1;
  // The nearest point of the present step and of the one before: the arm may still be between those.
  JointVector nearest = steps_[next_].q;
  for (std::size_t i = next_ > 1 ? next_ - 1 : next_; i <= next_; ++i) {
    const JointVector way = steps_[i].q - steps_[i - 1].q;
    const double length2 = way.squaredNorm();
    const double share = length2 > 0.0 ? std::clamp((q - steps_[i - 1].q).dot(way) / length2, 0.0, 1.0) : 0.0;
    const JointVector candidate = steps_[i - 1].q + share * way;
    if ((q - candidate).squaredNorm() < (q - nearest).squaredNorm()) nearest = candidate;
  }
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    if (std::abs(q[j] - nearest[j]) > order_.path_tolerance[j]) return static_cast<int>(j);
  }
  return -1;
}

TrajectoryFollower::Output TrajectoryFollower::update(const Input& input) {
  if (next_ == 0) return send_next();
  elapsed_ += input.dt;
  const bool last = next_ + 1 == steps_.size();
  const std::string because = input.reason.empty() ? "" : ": " + input.reason;
  if (input.report == GoalReport::kLost) return end(TrajectoryCode::kInvalidGoal, "the goal was lost" + because);
  if (input.report == GoalReport::kRejected && last) {
    return end(TrajectoryCode::kInvalidGoal, "the last point is rejected" + because);
  }
  if (const int joint = outside(input.q); joint >= 0) {
    return end(TrajectoryCode::kPathTolerance, "joint number " + std::to_string(joint + 1) +
                                                   " is outside its path tolerance of " +
                                                   rounded(order_.path_tolerance[joint]) + because);
  }
  const bool reached = last && input.report == GoalReport::kReached;
  if (!reached && order_.goal_time_tolerance > 0.0 && elapsed_ > order_.duration() + order_.goal_time_tolerance) {
    return end(TrajectoryCode::kGoalTolerance,
               "the goal is not reached " + rounded(order_.goal_time_tolerance) + " s after its time" + because);
  }
  const bool passed =
      input.report == GoalReport::kReached || input.report == GoalReport::kRejected || near_step(input.q);
  time_ = std::min(time_ + input.dt, passed ? order_.duration() : steps_[next_].time);
  if (!last) {
    if (passed && time_ >= steps_[next_].time) return send_next();
    return {};
  }
  if (reached && time_ >= order_.duration()) {
    for (Eigen::Index j = 0; j < input.q.size(); ++j) {
      const double error = std::abs(input.q[j] - steps_.back().q[j]);
      if (error > order_.goal_tolerance[j]) {
        return end(TrajectoryCode::kGoalTolerance, "joint number " + std::to_string(j + 1) + " ends " + rounded(error) +
                                                       " from the goal (tolerance " +
                                                       rounded(order_.goal_tolerance[j]) + ")");
      }
    }
    return end(TrajectoryCode::kSuccessful, "");
  }
  return {};
}

}  // namespace hecaton::ros2
