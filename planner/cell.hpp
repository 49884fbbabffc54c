#pragma once
/// A whole cell as values: what the cell file says once its URDFs are loaded. No hosts, no network: those are the
/// services' business.

#include <map>
#include <string>
#include <vector>

#include "planner/local/parameters.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/range_sensor.hpp"
#include "world/model/scene.hpp"

namespace hecaton::planner {

struct PlannedArm {
  Arm arm;
  LocalParameters parameters;
  JointVector start = {};  ///< where it stands when the cell comes up, at rest [rad | m]; empty: home
  std::vector<RangeSensor> sensors = {};
  MethodSet methods = {};  ///< with this arm's parameters; parameters.method is one of them once a cell is loaded

  /// Plans the arm by its method of that name. False when it has none.
  bool select_method(std::string_view name) {
    auto found = find_method(methods, name);
    if (!found) return false;
    parameters.method = std::move(found);
    return true;
  }
  /// Nothing when the method suits the arm; otherwise one sentence that begins with the method's name.
  [[nodiscard]] std::optional<std::string> objection() const {
    auto reason = parameters.method->objection(arm, sensors);
    if (reason) reason = std::string(parameters.method->traits().name) + " " + *reason;
    return reason;
  }
};

/// Obstacles that are drawn anew for every episode of a simulation: boxes, balls and upright cylinders that stand
/// still.
struct Clutter {
  int count = 0;
  double smallest = 0.05;  ///< edges and diameters [m]
  double largest = 0.3;
  double inner = 0.3;  ///< centres are between these distances from the z axis of W [m]
  double outer = 1.0;
  double lowest = 0.0;  ///< and between these heights [m]
  double highest = 0.0;
};

/// A motion problem [Mediavilla02]: each arm goes back and forth between areas, which are balls in joint space round
/// named poses, and rests there for a while.
struct MotionProblem {
  std::map<std::string, std::vector<std::string>> areas;  ///< per arm, in turn; it starts in the first; empty: none
  double spread = 0.1;                                    ///< radius of the balls (ε_alea as joints move it) [rad]
  double mean_wait = 10.0;                                ///< between two tasks, exponential (μ_exp) [steps]
};

/// Where goals come from: named poses that all arms visit together, the areas of a motion problem, or else tool
/// positions drawn from a cylinder along z, of the cell or of each arm.
struct TaskArea {
  std::vector<std::string> pose_sequence;            ///< every arm has poses of these names; empty: drawn
  MotionProblem problem;                             ///< its areas empty: drawn
  bool of_each_arm = false;                          ///< each has its own, in its base frame B; else all share one in W
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in W or B [m]
  double radius = 0.35;                              ///< of the disc across the axis [m]
  double half_height = 0.1;                          ///< above and below the centre [m]
  std::string posture;                               ///< named pose near which arms stay; empty: any posture
  bool all_conflict = false;                         ///< every arm is in another's straight way, not just two
  double time_limit = 30.0;                          ///< for one task [s]
  Clutter clutter = {};                              ///< in the way, besides the cell's obstacles

  /// The frame in which the cylinder stands for an arm with its base at X_WB.
  [[nodiscard]] Pose frame(const Pose& X_WB) const { return of_each_arm ? X_WB : Pose::Identity(); }
};

struct Timing {
  double control_period = 0.010;   ///< of a planner's tick [s]
  double driver_period = 0.002;    ///< of an arm driver's loop [s]
  double world_period = 0.010;     ///< of the world's step [s]
  double command_timeout = 0.050;  ///< a driver without commands this long stops its arm [s]
};

struct Cell {
  std::string name;
  std::vector<PlannedArm> arms;
  world::Scene scene;
  TaskArea tasks;
  Timing timing;
};

/// Of all arms, in the cell's order.
[[nodiscard]] inline std::vector<Arm> arms_of(const Cell& cell) {
  std::vector<Arm> arms;
  for (const PlannedArm& planned : cell.arms) arms.push_back(planned.arm);
  return arms;
}
[[nodiscard]] inline std::vector<std::string> names_of(const Cell& cell) {
  std::vector<std::string> names;
  for (const PlannedArm& planned : cell.arms) names.push_back(planned.arm.name);
  return names;
}
[[nodiscard]] inline std::vector<LocalParameters> parameters_of(const Cell& cell) {
  std::vector<LocalParameters> parameters;
  for (const PlannedArm& planned : cell.arms) parameters.push_back(planned.parameters);
  return parameters;
}

}  // namespace hecaton::planner
