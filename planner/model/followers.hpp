#pragma once
/// Links beside the chain that move: counterweight cylinders and rods of parallelograms, whose joints mimic a joint of
/// the chain, and grippers. The planner does not move them; their shapes enclose all places where they may be.

#include <optional>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// Positions of a joint outside the chain that moves on its own [rad | m].
struct MotionRange {
  double lower = 0.0;
  double upper = 0.0;  ///< > lower

  friend bool operator==(const MotionRange&, const MotionRange&) = default;
};

/// A joint beside the chain, at multiplier · q[joint] + offset.
struct Follower {
  int link = 0;                           ///< that it carries, an index into RobotModel::links
  JointType type = JointType::kRevolute;  ///< before it was fixed
  Pose X_PJ = Pose::Identity();           ///< joint frame in the parent link's frame, at position 0
  int joint = 0;                          ///< of the chain; RobotModel::joints() + i: the one with the i-th range
  double multiplier = 1.0;                ///< [rad/rad | m/rad | …]
  double offset = 0.0;                    ///< [rad | m]
};

/// Replaces each shape of a link that followers move by a convex polyhedron around all places of the shape within the
/// joint limits and `ranges`, fixed to the body that carries the mechanism. Removes self pairs of such a shape with the
/// body that its joint moves, because a mechanism does not collide with what drives it. Adds one note. `model` has its
/// limits, geometry and self pairs, and gets RobotModel::outside. `joint_names`: of `ranges`. Throws ModelError, which
/// begins with `path`, when more than two joints move one link's followers, or when a shape gets farther than 100 m.
void enclose_followers(const std::vector<Follower>& followers, const std::vector<MotionRange>& ranges,
                       const std::string& path, RobotModel& model, const std::vector<std::string>& joint_names = {});

/// A link or joint between the link that carries a mechanism and a link of the mechanism, in this order.
struct MechanismStep {
  bool moves = false;            ///< false: fixed at `held`
  Pose held = Pose::Identity();  ///< in the frame before, where the model holds the joint
  Pose X_PJ = Pose::Identity();  ///< joint frame in the frame before, at position 0
  JointType type = JointType::kFixed;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the joint's frame
  int joint = 0;                                    ///< index into positions
  double multiplier = 1.0;                          ///< of its position [rad/rad | m/m | …]
  double offset = 0.0;                              ///< [rad | m]
};

/// A polyhedron around all places of a shape of the last link, with its joints between these positions. Its frame is
/// that of the link that carries the mechanism. Empty when the shape gets farther than 100 m. `ranges`: by
/// MechanismStep::joint.
[[nodiscard]] std::optional<world::ConvexHull> around_places(const std::vector<MechanismStep>& steps,
                                                             const std::vector<MotionRange>& ranges,
                                                             const world::Shape& shape, const Pose& X_LS);
/// The last link in the frame of the link that carries the mechanism.
[[nodiscard]] Pose place_of(const std::vector<MechanismStep>& steps, const std::vector<double>& positions);

}  // namespace hecaton::planner
