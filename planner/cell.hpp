#pragma once
/// A cell as values: the content of the cell file with its URDFs loaded. Hosts and network are not part of it.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planner/local/parameters.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/outside_joints.hpp"
#include "planner/model/range_sensor.hpp"
#include "world/model/scene.hpp"

namespace hecaton::planner {

struct PlannedArm {
  Arm arm;
  LocalParameters parameters;
  JointVector start = {};  ///< initial position, at rest [rad | m]; empty: home
  std::vector<RangeSensor> sensors = {};
  MethodSet methods = {};  ///< with this arm's parameters; a loaded cell's parameters.method is one of them

  /// Selects the method of that name. False: there is none.
  bool select_method(std::string_view name) {
    auto found = find_method(methods, name);
    if (!found) return false;
    parameters.method = std::move(found);
    return true;
  }
  /// Nothing if the method suits the arm; otherwise one sentence that begins with the method's name.
  [[nodiscard]] std::optional<std::string> objection() const {
    auto reason = parameters.method->objection(arm, sensors);
    if (reason) reason = std::string(parameters.method->traits().name) + " " + *reason;
    return reason;
  }
};

/// Random static obstacles of each simulated episode: boxes, balls and upright cylinders.
struct Clutter {
  int count = 0;
  double smallest = 0.05;  ///< edges and diameters [m]
  double largest = 0.3;
  double inner = 0.3;   ///< least distance of a centre from the z axis of W [m]
  double outer = 1.0;   ///< largest distance [m]
  double lowest = 0.0;  ///< least height of a centre [m]
  double highest = 0.0;
};

/// A motion problem [Mediavilla02]: each arm moves back and forth between areas and rests in each for a while. An area
/// is a ball in joint space around a named pose.
struct MotionProblem {
  std::map<std::string, std::vector<std::string>> areas;  ///< of each arm, in order of visit; empty: no problem
  double spread = 0.1;                                    ///< radius of the balls (ε_alea as joints move it) [rad]
  double mean_wait = 10.0;                                ///< between two tasks, exponential (μ_exp) [steps]
};

/// The source of goals: named poses that all arms visit together, the areas of a motion problem, or random tool
/// positions in a cylinder along z, one for the cell or one for each arm.
struct TaskArea {
  std::vector<std::string> pose_sequence;            ///< every arm has poses of these names; empty: drawn
  MotionProblem problem;                             ///< its areas empty: drawn
  bool of_each_arm = false;                          ///< each has its own, in its base frame B; else all share one in W
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in W or B [m]
  double radius = 0.35;                              ///< of the disc across the axis [m]
  double half_height = 0.1;                          ///< above and below the centre [m]
  std::string posture;                               ///< named pose near which arms stay; empty: any posture
  bool all_conflict = false;                         ///< every arm blocks another's straight line, not just two
  double time_limit = 30.0;                          ///< for one task [s]
  Clutter clutter = {};                              ///< besides the cell's obstacles

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
/// The cell for the planner of an arm in a running cell. States of the arms say where the bodies are that
/// joints outside the chains move: these are left out. An arm that knows obstacles by its sensors only counts whole
/// ranges.
[[nodiscard]] inline Cell live_cell(Cell cell, int self) {
  if (cell.arms[self].parameters.method->traits().sensor_only) return cell;
  for (PlannedArm& planned : cell.arms) planned.arm.model = without_outside_bodies(std::move(planned.arm.model));
  return cell;
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
