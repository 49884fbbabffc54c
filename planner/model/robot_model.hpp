#pragma once
/// An arm as its URDF describes it. Constant after loading, therefore safe to share between threads.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "planner/model/capsules.hpp"
#include "planner/model/kinematics_kernels.hpp"
#include "planner/model/limits.hpp"
#include "world/model/shape.hpp"

namespace hecaton::planner {

using world::Pose;

enum class JointType { kFixed, kRevolute, kContinuous, kPrismatic };

/// A link and the joint that carries it. In the joint's zero position the link's frame L coincides with the joint's
/// frame: X_PL(q) = X_PJ · motion(multiplier · q[joint] + offset about or along `axis`).
struct Link {
  std::string name;
  int parent = -1;  ///< index into RobotModel::links, always smaller than its own; −1: the base
  JointType joint_type = JointType::kFixed;
  std::string joint_name;                           ///< empty for the root
  Pose X_PJ = Pose::Identity();                     ///< joint frame in the parent link's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the joint's frame
  int joint = -1;                                   ///< index into joint vectors; −1 when the joint does not move
  bool follows = false;                             ///< its own joint mimics that of `joint`
  double multiplier = 1.0;                          ///< other than 1 only if it follows [rad/rad | m/rad | …]
  double offset = 0.0;                              ///< other than 0 only if it follows [rad | m]
  JointMotion motion = JointMotion::kMoves;         ///< special case for the kinematics kernel: joint_motion()
};

/// The special case of the kinematics kernel that fits the link's joint. Builders of models set Link::motion to it.
[[nodiscard]] inline JointMotion joint_motion(const Link& link) {
  if (link.joint < 0) return JointMotion::kFixed;
  if (link.joint_type == JointType::kPrismatic) return JointMotion::kMoves;
  if (link.axis == Eigen::Vector3d::UnitX()) return JointMotion::kTurnsAboutX;
  if (link.axis == Eigen::Vector3d::UnitY()) return JointMotion::kTurnsAboutY;
  if (link.axis == Eigen::Vector3d::UnitZ()) return JointMotion::kTurnsAboutZ;
  return JointMotion::kMoves;
}

/// One collision shape of one link.
struct LinkGeometry {
  int link = 0;
  world::Shape shape;
  Pose X_LS = Pose::Identity();  ///< shape in the link's frame
  double excess_volume = 0.0;    ///< volume(shape) / volume(mesh) − 1 when the shape was fitted to a mesh, else 0;
                                 ///< for a mesh that is not closed relative to its hull
  std::optional<LinkCapsule> capsule = {};  ///< replaces the shape in cells of fast geometry; empty: the shape itself
};

struct OutsideJoints;
struct MassModel;

/// A pair of RobotModel::self_pairs that no posture brings far apart.
struct ClosePair {
  int first = 0;
  int second = 0;
  double widest = 0.0;  ///< the largest distance in any posture, as far as the filter found it [m], > 0
};

/// A serial chain of actuated joints with everything fixed to it. Links of the chain may follow one of these joints, as
/// in a parallelogram. Joints of the URDF outside the chain (fingers, a torso above the base link) are fixed where the
/// options say, else at zero or at the nearest limit. Shapes of links beside the chain that follow one of its joints
/// enclose all their places. Links of the robot's other arms are left out.
struct RobotModel {
  std::string name;
  std::vector<Link> links;                  ///< parents before children; links[0] is the root; at most kMaxLinks
  std::vector<LinkGeometry> geometry;       ///< ordered by link
  std::vector<std::string> joint_names;     ///< of the actuated joints, base to tip
  bool has_followers = false;               ///< some links follow: Link::follows
  std::map<std::string, JointType> beside;  ///< actuated joints that carry no link of the chain: followers move it
  std::shared_ptr<const OutsideJoints> outside = {};  ///< joints with a range (outside_joints.hpp); null: none
  std::map<std::string, double> held;  ///< positions of the joints outside the chain that do not move [rad | m]
  std::shared_ptr<const MassModel> masses = {};  ///< as the URDF gives them (dynamics.hpp); null: no URDF
  JointLimits limits;  ///< from the URDF, such that followers keep theirs; acceleration from UrdfOptions
  int tool_link = 0;   ///< its frame, times X_LT, is the tool frame T
  Pose X_LT = Pose::Identity();
  /// Pairs of indices into `geometry` (first < second) that self-collision checks. The SRDF and automatic_filter()
  /// remove pairs from it.
  std::vector<std::pair<int, int>> self_pairs;
  std::vector<ClosePair> close_pairs;        ///< those of self_pairs that automatic_filter() found close
  std::map<std::string, JointVector> named;  ///< the SRDF's group_states that set every joint within its limits
  std::vector<std::string> notes;            ///< decisions of the loader, a sentence each, for `hecaton check`
  std::vector<std::string> details;          ///< the same of meshes and link pairs, which tables of shapes sum up

  [[nodiscard]] int joints() const { return static_cast<int>(joint_names.size()); }
};

/// The greatest magnitude of the position of a moving link's joint within the limits [rad | m]. Infinite when endless.
[[nodiscard]] inline double largest_position(const Link& link, const JointLimits& limits) {
  return std::max(std::abs(link.multiplier * limits.lower[link.joint] + link.offset),
                  std::abs(link.multiplier * limits.upper[link.joint] + link.offset));
}

/// The type of an actuated joint.
[[nodiscard]] inline JointType joint_type(const RobotModel& model, int joint) {
  for (const Link& link : model.links) {
    if (link.joint == joint && !link.follows) return link.joint_type;
  }
  return model.beside.at(model.joint_names[joint]);
}

/// True if a whole turn of the joint leaves the arm as it is: the joint turns, and so do all links that follow it, by
/// whole turns.
[[nodiscard]] inline bool repeats_after_turn(const RobotModel& model, int joint) {
  if (joint_type(model, joint) == JointType::kPrismatic) return false;
  return std::all_of(model.links.begin(), model.links.end(), [&](const Link& link) {
    if (link.joint != joint) return true;
    return link.joint_type != JointType::kPrismatic && link.multiplier == std::round(link.multiplier);
  });
}

}  // namespace hecaton::planner
