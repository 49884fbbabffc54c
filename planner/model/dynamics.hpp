#pragma once
/// Masses of a robot's moving bodies, and the forces of its joints that a motion takes. Without friction, rotors of
/// motors and payloads, which a URDF does not have.

#include <string>
#include <vector>

#include "planner/model/limits.hpp"
#include "world/model/shape.hpp"

namespace hecaton::planner {

struct RobotModel;

/// Mass of a link as the URDF gives it, or of a body: a link that a joint moves, with all links fixed to it. In the
/// frame L of the link.
struct BodyMass {
  std::string link;                                   ///< its name
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();   ///< mass times centre of mass [kg m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the origin of L [kg m²]

  /// Adds a link that is fixed to this body.
  void add(const BodyMass& other, const world::Pose& X_LO);
};

/// What a URDF says about masses and drives.
struct MassModel {
  std::vector<BodyMass> bodies;  ///< by axis (Kinematics), base to tip; a mass of 0 is not known
  JointVector effort;            ///< limits of the joints [N m | N]; 0: not known
};

/// The mass of a URDF's <inertial>. `inertia`: about the centre of mass, in the frame I of the <inertial>.
[[nodiscard]] BodyMass body_mass(const std::string& link, double mass, const world::Pose& X_LI,
                                 const Eigen::Matrix3d& inertia);

/// Force of each joint [N m | N] that the acceleration qdd at q and qd takes against `gravity_B` [m/s²], given in the
/// frame of the root link, which stands. `model` has masses. Unknown masses count as none.
[[nodiscard]] JointVector inverse_dynamics(const RobotModel& model, const Eigen::Vector3d& gravity_B,
                                           const JointVector& q, const JointVector& qd, const JointVector& qdd);

/// Why inverse_dynamics() and the limits of the drives cannot be compared: a clause without its full stop. Empty: they
/// can.
[[nodiscard]] std::string why_no_forces(const RobotModel& model);

}  // namespace hecaton::planner
