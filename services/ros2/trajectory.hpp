#pragma once
/// A joint trajectory that a node of ROS 2 sends: its checks, and how an arm follows it. No network, threads or clock.
///
/// The planner of the arm follows the trajectory in each control period (planner/local/trajectory_tracking.hpp). This
/// service sends it as one goal, follows its progress, and judges the tolerances at its end.

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "planner/model/arm.hpp"
#include "planner/trajectory/timed_trajectory.hpp"
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

// Largest absolute values that the messages to planners may have (services/bus/wire_rules.cpp).
inline constexpr double kLargestPosition = 1e6;      ///< [rad | m]
inline constexpr double kLargestVelocity = 1e4;      ///< [rad/s | m/s]
inline constexpr double kLargestAcceleration = 1e6;  ///< [rad/s² | m/s²]

/// A sentence about the `field` of a message of ROS 2; empty when `value` is finite and its absolute value at most
/// `largest`.
[[nodiscard]] std::optional<std::string> out_of_range(const std::string& field, double value, double largest);

/// A trajectory that has passed the checks.
struct TrajectoryOrder {
  planner::TimedTrajectory trajectory;   ///< with path tolerances; a first point after time 0 begins at the arm
  std::vector<std::string> joint_names;  ///< from base to tip
  planner::JointLimits limits;           ///< of the arm
  /// Of the arm [rad | m]. A joint that turns without end has the turns of the first point.
  planner::JointVector start;
  planner::JointVector goal_tolerance;  ///< [rad | m]; infinite: the planner's tolerance counts alone
  /// After the last point's time [s]. 0: no limit on the way, and the goal tolerances hold when the planner arrives.
  double goal_time_tolerance = 0.0;

  [[nodiscard]] double duration() const { return trajectory.duration(); }
  /// The state that the trajectory demands at `time`.
  [[nodiscard]] planner::JointState at(double time) const;
  /// From the position `q` to that which the trajectory demands at `time` [rad | m].
  [[nodiscard]] planner::JointVector error(const planner::JointVector& q, double time) const;
  /// A joint has a goal tolerance.
  [[nodiscard]] bool has_goal_tolerance() const;
  /// `q`, and all that is left of the trajectory after `time`, are within the goal tolerances of its end. A joint
  /// without one has the planner's usual tolerance.
  [[nodiscard]] bool ends_near(const planner::JointVector& q, double time) const;
};

struct TrajectoryRefusal {
  TrajectoryCode code;
  std::string text;  ///< one sentence
};

/// Checks a goal for an arm at `q`. `age`: time since the trajectory's stamp [s], negative before it; 0 for a stamp
/// of zero.
[[nodiscard]] std::variant<TrajectoryOrder, TrajectoryRefusal> check_trajectory(const TrajectoryGoal& goal,
                                                                                const planner::Arm& arm,
                                                                                const planner::JointVector& q,
                                                                                double age);

/// The number of each joint of `names` in the arm, with or without the arm's prefix; empty unless `names` has each
/// joint of the arm once.
[[nodiscard]] std::optional<std::vector<int>> joint_numbers(const std::vector<std::string>& names,
                                                            const planner::Arm& arm);

/// How long planners have been silent about a goal. A planner that is not heard at all may be about to start.
class PlannerSilence {
 public:
  /// `reported`: age of the goal in the last report of a planner [s]; empty: none yet. `heard`: a planner of the arm
  /// runs, as far as this process knows. `dt`: since the last call [s].
  void update(std::optional<double> reported, bool heard, double dt);
  /// Without a report, while a planner was heard [s].
  [[nodiscard]] double unanswered() const { return unanswered_; }
  /// Since a planner was heard last [s].
  [[nodiscard]] double unheard() const { return unheard_; }

 private:
  double unanswered_ = 0.0;
  double unheard_ = 0.0;
  std::optional<double> reported_;
};

/// How long an arm has been at rest: no joint has left a small interval.
class RestTime {
 public:
  /// `q`: measured [rad | m]; empty: not known now. `dt`: since the last call [s]. Returns the time [s].
  double update(const planner::JointLimits& limits, const std::optional<planner::JointVector>& q, double dt);

 private:
  std::optional<planner::JointVector> since_;
  double time_ = 0.0;
};

/// Follows one trajectory.
class TrajectoryFollower {
 public:
  /// `elapsed`: since the start [s].
  explicit TrajectoryFollower(TrajectoryOrder order, double elapsed = 0.0)
      : order_(std::move(order)), elapsed_(elapsed) {}

  /// What the planner says about the goal.
  enum class GoalReport {
    kUnderWay,
    kUnanswered,  ///< no planner has reported anything yet
    kUnreported,  ///< the same, after a restart of this service: a planner may know the goal or not
    kReached,
    kRejected,  ///< the planner rejects the trajectory
    kLeftPath,  ///< the planner has ended the goal: a joint is outside its path tolerance
    kReplaced,  ///< by a later goal, which is none of the action
    kLost,      ///< the goal ended otherwise
  };
  /// A trajectory ends when no planner has answered it for this long, while one was heard [s]. The agent restarts a
  /// planner that has failed; until it answers, some seconds pass (docs/results.md, "ROS 2 and Python").
  static constexpr double kAnswerTime = 10.0;
  /// The same after a restart of this service, which has no answer of the planner yet [s].
  static constexpr double kReportTime = 5.0;
  /// A trajectory also ends when no planner was heard for this long [s].
  static constexpr double kHeardTime = 30.0;
  struct Input {
    std::optional<planner::JointVector> q;  ///< measured [rad | m]; empty: the driver has sent none
    double dt;                              ///< since the last call [s]
    GoalReport report = GoalReport::kUnderWay;
    double time = 0.0;                    ///< of the trajectory, as the planner reported it last [s]
    double rate = 0.0;                    ///< of that time
    std::string reason = {};              ///< of the report, and why the arm is late, for people
    std::optional<double> reported = {};  ///< age of the goal in the last report of a planner [s]; empty: none
    double q_age = 0.0;                   ///< of q [s]
    bool heard = true;                    ///< a planner of the arm runs
  };
  /// The end of the trajectory; kSuccessful: at its goal, also while the planner's goal is under way: the arm rests
  /// within the goal tolerances. Empty: it goes on.
  [[nodiscard]] std::optional<TrajectoryRefusal> update(const Input& input);

  [[nodiscard]] const TrajectoryOrder& order() const { return order_; }
  [[nodiscard]] double time() const { return time_; }  ///< of the trajectory, between reports estimated [s]
  [[nodiscard]] double rate() const { return rate_; }  ///< of that time, 0 to 1

 private:
  /// The end of a trajectory whose planner has arrived.
  [[nodiscard]] std::optional<TrajectoryRefusal> judge_arrival(const Input& input);
  [[nodiscard]] bool rests_near_end(const Input& input) const;

  TrajectoryOrder order_;
  double time_ = 0.0;
  double rate_ = 0.0;
  double reported_ = 0.0;  ///< time of the last report [s]
  double elapsed_ = 0.0;   ///< since the start, with waits [s]
  PlannerSilence silence_;
  RestTime rest_;
  double rested_ = 0.0;            ///< [s]
  double without_position_ = 0.0;  ///< since the planner has arrived [s]
  std::string late_because_;       ///< newest reason for being late, which may be over
};

/// Waits until the planner has ended the goal of a cancelled trajectory.
class CancellationWait {
 public:
  struct Input {
    double dt;                            ///< since the last call [s]
    bool over = false;                    ///< the goal has ended
    std::optional<double> reported = {};  ///< age of the goal in the last report of a planner [s]; empty: none
    bool heard = true;                    ///< a planner of the arm runs
    bool restored = false;                ///< an earlier process has sent the goal
  };
  /// How the trajectory has ended, for people. It also ends with the time limits of TrajectoryFollower. Empty: wait.
  [[nodiscard]] std::optional<std::string> update(const Input& input);

 private:
  PlannerSilence silence_;
};

}  // namespace hecaton::ros2
