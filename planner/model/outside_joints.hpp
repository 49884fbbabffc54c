#pragma once
/// Joints outside the chain that have a range, such as those of fingers, and the shapes of the links that they move. A
/// model holds these links in shapes that enclose all their places. A running cell knows where the joints are, and
/// replaces these shapes by smaller ones, as bodies that the tool carries
/// (docs/explanation/0018-postures-at-run-time.md).

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/model/arm.hpp"
#include "planner/model/followers.hpp"
#include "planner/model/robot_model.hpp"
#include "world/model/scene.hpp"

namespace hecaton::planner {

/// A joint with a range.
struct OutsideJoint {
  std::string name;
  JointType type = JointType::kRevolute;
  MotionRange range;     ///< of the cell file
  bool of_tool = false;  ///< it moves a shape that is fixed to the tool's body: only these become smaller
  bool of_base = false;  ///< it moves a shape that no joint of the arm moves: arms of one robot share it
};

/// A shape that such joints move, and that the tool's body carries.
struct OutsideBody {
  std::string link;  ///< its name
  /// Around all places: the shape of RobotModel::geometry that this one replaces.
  std::shared_ptr<const world::ConvexHull> enclosure;
  world::Shape shape;                ///< of the URDF
  Pose X_LS = Pose::Identity();      ///< of the shape in the link's frame
  Pose X_TP = Pose::Identity();      ///< link that carries the mechanism, in the tool frame T
  std::vector<MechanismStep> steps;  ///< from that link to this one
};

struct OutsideJoints {
  std::vector<OutsideJoint> joints;  ///< ordered by name
  std::vector<OutsideBody> bodies;
};

/// The body whose enclosing shape this is; null: none.
[[nodiscard]] const OutsideBody* outside_body(const RobotModel& model, const world::Shape& shape);
/// The ranges of all joints; empty without such joints.
[[nodiscard]] std::vector<MotionRange> outside_ranges(const RobotModel& model);

/// The model without the shapes of OutsideJoints::bodies; the same model if it has none.
[[nodiscard]] std::shared_ptr<const RobotModel> without_outside_bodies(std::shared_ptr<const RobotModel> model);

/// The shapes with their joints between `positions`, as obstacles that the arm carries; one for each link. `positions`:
/// one for each joint.
[[nodiscard]] std::vector<world::Obstacle> outside_obstacles(const Arm& arm, std::span<const MotionRange> positions);

/// The link's frame of each body in the tool frame T, with the joints at `positions`.
[[nodiscard]] std::vector<Pose> outside_places(const RobotModel& model, const std::vector<double>& positions);

}  // namespace hecaton::planner
