#pragma once
/// A robot model placed in a cell, and how far it can reach.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// The shapes with which planners measure distances of an arm's links.
enum class LinkShapes {
  kFast,   ///< the model's capsules where it has them; between links of one arm the model's own shapes
  kExact,  ///< the model's own shapes
};

/// An arm of the cell. Plain value; the model is shared and constant.
struct Arm {
  std::string name;                          ///< unique in the cell
  std::shared_ptr<const RobotModel> model;   ///< never null
  Pose X_WB = Pose::Identity();              ///< root link's frame in W
  JointLimits limits;                        ///< the URDF's, tightened by the cell file
  LinkShapes shapes = LinkShapes::kFast;     ///< for distances
  std::map<std::string, JointVector> named;  ///< named configurations, within limits; "home" always exists
  int robot = -1;  ///< arms of one robot have the same number, ≥ 0; −1: the arm is a robot of its own

  [[nodiscard]] const JointVector& home() const { return named.at("home"); }  ///< the pose of that name
};

/// Two arms of one robot share the bodies that no joint moves, such as a torso. Only their moving bodies can collide
/// with each other; each arm's self pairs cover its moving bodies against the shared ones.
[[nodiscard]] inline bool same_robot(const Arm& a, const Arm& b) {
  return a.robot >= 0 && a.robot == b.robot;
}

/// Bounds from the lengths between an arm's joints: the origin of link i stays within `links[i]` of `centre` for all
/// positions of revolute joints, and for all positions of prismatic joints within the limits.
struct ArmReach {
  Eigen::Vector3d centre;     ///< the first joint's origin, in W [m]
  std::vector<double> links;  ///< by index into RobotModel::links [m]
  double tool = 0.0;          ///< the same for the origin of the tool frame T [m]
};

/// How far the arm reaches. Depends on the model, the base pose and the limits of prismatic joints only.
[[nodiscard]] ArmReach arm_reach(const Arm& arm);

}  // namespace hecaton::planner
