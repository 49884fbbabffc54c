#pragma once
/// A joint trajectory that a node of ROS 2 sends: its checks, and how an arm follows it. No network, threads or clock.
///
/// The arm does not track the trajectory period by period. It moves through the trajectory's points in their order, one
/// joint goal after the other, and never passes a point before its time. Between two points, at most kLongestStep apart
/// in time, its planner chooses the speed within the limits of the cell file. When the arm is late, the time of the
/// trajectory waits for it.

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "planner/model/arm.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::ros2 {

// Result codes of control_msgs/action/FollowJointTrajectory.
enum class TrajectoryCode : std::int32_t {
  kSuccessful = 0,
  kInvalidGoal = -1,
  kInvalidJoints = -2,
  kOldStamp = -3,
  kPathTolerance = -4,
  kGoalTolerance = -5,
};

struct TimedPoint {
  double time;             ///< since the start of the trajectory [s]
  planner::JointVector q;  ///< [rad | m]
};

/// A trajectory that has passed the checks.
struct TrajectoryOrder {
  std::vector<TimedPoint> points;       ///< the first is the start at time 0
  planner::JointVector path_tolerance;  ///< [rad | m]; infinite: not checked
  planner::JointVector goal_tolerance;  ///< [rad | m]; infinite: the planner's tolerance counts alone
  double goal_time_tolerance = 0.0;     ///< after the last point's time [s]; 0: no limit

  [[nodiscard]] double duration() const { return points.back().time; }
  /// The trajectory's position at `time`, which is cut to its duration [rad | m].
  [[nodiscard]] planner::JointVector at(double time) const;
};

struct TrajectoryRefusal {
  TrajectoryCode code;
  std::string text;  ///< one sentence
};

/// Checks a goal for an arm at `q`. `age`: time since the trajectory's stamp [s]; 0 for a stamp of zero.
[[nodiscard]] std::variant<TrajectoryOrder, TrajectoryRefusal> check_trajectory(const TrajectoryGoal& goal,
                                                                                const planner::Arm& arm,
                                                                                const planner::JointVector& q,
                                                                                double age);

/// The number of each joint of `names` in the arm, with or without the arm's prefix; empty unless `names` has each
/// joint of the arm once.
[[nodiscard]] std::optional<std::vector<int>> joint_numbers(const std::vector<std::string>& names,
                                                            const planner::Arm& arm);

/// Follows one trajectory.
class TrajectoryFollower {
 public:
  static constexpr double kLongestStep = 0.2;  ///< between two joint goals [s]

  explicit TrajectoryFollower(TrajectoryOrder order);

  /// What the planner says about the present joint goal.
  enum class GoalReport {
    kUnderWay,  ///< or not answered yet
    kReached,
    kRejected,  ///< the planner rejects this point
    kLost,      ///< the goal ended otherwise: another client has replaced it, for instance
  };
  struct Input {
    planner::JointVector q;  ///< measured [rad | m]
    double dt;               ///< since the last call [s]
    GoalReport report = GoalReport::kUnderWay;
    std::string reason = {};  ///< of the report, and why the arm is late, for people
  };
  struct Output {
    std::optional<planner::JointVector> goal;  ///< the next joint goal to send [rad | m]
    std::optional<TrajectoryRefusal> end;      ///< the trajectory has ended; kSuccessful: at its goal
  };
  [[nodiscard]] Output update(const Input& input);

  [[nodiscard]] const TrajectoryOrder& order() const { return order_; }
  [[nodiscard]] double time() const { return time_; }  ///< of the trajectory [s]
  /// Largest excess of the distance from the path over the tolerance, as a joint number; −1: within.
  [[nodiscard]] int outside(const planner::JointVector& q) const;

 private:
  [[nodiscard]] Output end(TrajectoryCode code, std::string text) const;
  [[nodiscard]] Output send_next();
  [[nodiscard]] bool near_step(const planner::JointVector& q) const;

  TrajectoryOrder order_;
  std::vector<TimedPoint> steps_;  ///< joint goals with their times; the first is the start
  std::size_t next_ = 0;           ///< index of the present joint goal; 0: none was sent yet
  double time_ = 0.0;
  double elapsed_ = 0.0;  ///< since the start, with waits [s]
};

}  // namespace hecaton::ros2
