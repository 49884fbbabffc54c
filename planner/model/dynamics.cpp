#include "planner/model/dynamics.hpp"

#include <array>

#include "planner/model/kinematics.hpp"
#include "planner/model/robot_model.hpp"

namespace hecaton::planner {
namespace {

/// [c]×, so that [c]× x = c × x.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& c) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -c.z(), c.y(), c.z(), 0.0, -c.x(), -c.y(), c.x(), 0.0;
  return matrix;
}

/// Motion of a body, and what moves it, at the origin of its link and in the axes of the root link.
struct MovingBody {
  const Link* link = nullptr;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< ω [rad/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();       ///< ω̇ [rad/s²]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< minus gravity [m/s²]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();         ///< of all that is between it and the tip [N]
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();        ///< the same [N m]
};

/// The motion of a link that its joint moves at rate v and acceleration a, on the body before.
void move(const MovingBody& before, double v, double a, MovingBody& body) {
  const Eigen::Vector3d r = body.origin - before.origin;
  body.velocity = before.velocity;
  body.angular = before.angular;
  body.acceleration = before.acceleration + before.angular.cross(r) + before.velocity.cross(before.velocity.cross(r));
  if (body.link->joint_type == JointType::kPrismatic) {
    body.acceleration += a * body.axis + 2.0 * v * before.velocity.cross(body.axis);
  } else {
    body.velocity += v * body.axis;
    body.angular += a * body.axis + v * before.velocity.cross(body.axis);
  }
}

}  // namespace

void BodyMass::add(const BodyMass& other, const world::Pose& X_LO) {
  if (!(other.mass > 0.0)) return;
  // About the centre of mass, then about the origin of L: I_L = R (I_O − m ([c]×)ᵀ [c]×) Rᵀ + m ([d]×)ᵀ [d]×.
  const Eigen::Vector3d c_O = other.moment / other.mass;
  const Eigen::Vector3d c_L = X_LO * c_O;
  const Eigen::Matrix3d central = other.inertia + other.mass * cross_matrix(c_O) * cross_matrix(c_O);
  const Eigen::Matrix3d R = X_LO.linear();
  inertia += R * central * R.transpose() - other.mass * cross_matrix(c_L) * cross_matrix(c_L);
  moment += other.mass * c_L;
  mass += other.mass;
}

BodyMass body_mass(const std::string& link, double mass, const world::Pose& X_LI, const Eigen::Matrix3d& inertia) {
  BodyMass body;
  body.link = link;
  body.add({link, mass, Eigen::Vector3d::Zero(), inertia}, X_LI);
  return body;
}

// [Luh80] recursive Newton-Euler, in the axes of the root link. Differs from paper: each body has its mass, moment m c
// and inertia about its link's origin, so that no centre of mass is needed:
//   f = m v̇ + ω̇ × m c + ω × (ω × m c),   n = I ω̇ + ω × I ω + m c × v̇
JointVector inverse_dynamics(const RobotModel& model, const Eigen::Vector3d& gravity_B, const JointVector& q,
                             const JointVector& qd, const JointVector& qdd) {
  Kinematics kinematics;
  place_links(model, Pose::Identity(), q, kinematics);
  std::array<MovingBody, kMaxJoints> bodies;
  int count = 0;
  MovingBody before;
  before.acceleration = -gravity_B;
  for (int i = 0; i < kinematics.links; ++i) {
    const Link& link = model.links[i];
    if (link.joint < 0) continue;
    MovingBody& body = bodies[count];
    const Pose& X_BL = kinematics.X_WL[i];
    body.link = &link;
    body.origin = X_BL.translation();
    body.axis = X_BL.linear() * link.axis;
    move(before, link.multiplier * qd[link.joint], link.multiplier * qdd[link.joint], body);
    const BodyMass& of = model.masses->bodies[count];
    const Eigen::Vector3d moment = X_BL.linear() * of.moment;
    const Eigen::Matrix3d inertia = X_BL.linear() * of.inertia * X_BL.linear().transpose();
    body.force =
        of.mass * body.acceleration + body.angular.cross(moment) + body.velocity.cross(body.velocity.cross(moment));
    body.torque =
        inertia * body.angular + body.velocity.cross(inertia * body.velocity) + moment.cross(body.acceleration);
    before = body;
    ++count;
  }
  JointVector forces = JointVector::Zero(model.joints());
  for (int i = count - 1; i >= 0; --i) {
    const MovingBody& body = bodies[i];
    const bool slides = body.link->joint_type == JointType::kPrismatic;
    forces[body.link->joint] += body.link->multiplier * body.axis.dot(slides ? body.force : body.torque);
    if (i == 0) break;
    MovingBody& carrier = bodies[i - 1];
    carrier.force += body.force;
    carrier.torque += body.torque + (body.origin - carrier.origin).cross(body.force);
  }
  return forces;
}

std::string why_no_forces(const RobotModel& model) {
  if (!model.masses) return "the robot description has no masses";
  for (const BodyMass& body : model.masses->bodies) {
    if (body.mass > 0.0) continue;
    return "link " + body.link + " has no mass in the robot description (<inertial>)";
  }
  for (int joint = 0; joint < model.joints(); ++joint) {
    if (model.masses->effort[joint] > 0.0) continue;
    return "joint " + model.joint_names[joint] + " has no effort limit in the robot description (<limit effort=…>)";
  }
  return {};
}

}  // namespace hecaton::planner
