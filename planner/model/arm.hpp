#pragma once
/// A robot model placed in a cell.

#include <map>
#include <memory>
#include <string>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// What planners take for an arm's links.
enum class LinkShapes {
  kFast,   ///< the model's capsules, where it has them; between links of one arm its own shapes
  kExact,  ///< the model's own shapes
};

struct Arm {
  std::string name;  ///< unique in the cell
  std::shared_ptr<const RobotModel> model;
  Pose X_WB = Pose::Identity();  ///< root link's frame in W
  JointLimits limits;            ///< the URDF's, tightened by the cell file
  LinkShapes shapes = LinkShapes::kFast;
  std::map<std::string, JointVector> named;  ///< named configurations, within limits; "home" always exists

  [[nodiscard]] const JointVector& home() const { return named.at("home"); }
};

}  // namespace hecaton::planner
