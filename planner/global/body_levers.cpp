#include "planner/global/body_levers.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner::global {
namespace {

constexpr double kRoundedUp = 1.0 + 1e-5;

/// From an axis through the origin.
double across(const Eigen::Vector3d& axis, const Eigen::Vector3d& p) {
  return (p - axis.dot(p) * axis).norm();
}

// From the body to the base: what is carried lies in a ball around the origin of the frame that was reached; joints
// behind may have turned it anywhere.
void add_levers(const Arm& arm, const Body& body, float* levers) {
  const RobotModel& model = *arm.model;
  Eigen::Vector3d centre = body.bound.centre;
  double radius = body.bound.radius;
  for (int link = body.link; link >= 0; link = model.links[link].parent) {
    const Link& at = model.links[link];
    if (at.joint >= 0) {
      const bool shifts = at.joint_type == JointType::kPrismatic;
      levers[at.joint] = static_cast<float>(kRoundedUp * (shifts ? 1.0 : across(at.axis, centre) + radius));
      radius += centre.norm();
      if (shifts) radius += std::max(std::abs(arm.limits.lower[at.joint]), std::abs(arm.limits.upper[at.joint]));
      centre = Eigen::Vector3d::Zero();
    }
    centre = at.X_PJ * centre;
  }
}

}  // namespace

std::vector<float> body_levers(const std::vector<CellGeometry>& planned) {
  std::size_t dimensions = 0;
  std::size_t bodies = 0;
  for (const CellGeometry& geometry : planned) {
    dimensions += static_cast<std::size_t>(geometry.own_arm().model->joints());
    bodies += geometry.own_bodies().size();
  }
  std::vector<float> levers(bodies * dimensions, 0.0F);
  float* row = levers.data();
  int first = 0;
  for (const CellGeometry& geometry : planned) {
    for (const Body& body : geometry.own_bodies()) {
      add_levers(geometry.own_arm(), body, row + first);
      row += dimensions;
    }
    first += geometry.own_arm().model->joints();
  }
  return levers;
}

}  // namespace hecaton::planner::global
