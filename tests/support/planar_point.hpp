#pragma once
/// A robot for tests by hand: a ball on two prismatic joints, q = (x, y) of its centre. Its C-space is the workspace,
/// as in planar figures of papers.

#include <memory>

#include "planner/model/arm.hpp"
#include "world/model/scene.hpp"

namespace hecaton::test {

inline constexpr double kPeriod = 0.01;  ///< of control [s]

inline planner::JointVector joints(std::initializer_list<double> values) {
  planner::JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (double value : values) q[i++] = value;
  return q;
}

inline planner::Arm planar_point(const std::string& name = "point", double radius = 0.05) {
  using namespace planner;
  auto model = std::make_shared<RobotModel>();
  model->name = "planar_point";
  model->links.resize(3);
  model->links[0].name = "ground";
  model->links[1] = {"slide", 0, JointType::kPrismatic, "x", Pose::Identity(), Eigen::Vector3d::UnitX(), 0};
  model->links[2] = {"ball", 1, JointType::kPrismatic, "y", Pose::Identity(), Eigen::Vector3d::UnitY(), 1};
  LinkGeometry& ball = model->geometry.emplace_back();
  ball.link = 2;
  ball.shape = world::Sphere{radius};
  model->joint_names = {"x", "y"};
  model->limits = {joints({-3, -3}), joints({3, 3}), joints({0.5, 0.5}), joints({4, 4})};
  model->tool_link = 2;
  Arm arm;
  arm.name = name;
  arm.model = model;
  arm.limits = model->limits;
  arm.named["home"] = joints({0, 0});
  return arm;
}

inline world::Obstacle box_obstacle(const std::string& name, const Eigen::Vector3d& centre,
                                    const Eigen::Vector3d& half_extents) {
  world::Obstacle box;
  box.name = name;
  box.shapes.push_back({world::Box{half_extents}, world::Pose::Identity()});
  box.X_WO.translation() = centre;
  return box;
}

}  // namespace hecaton::test
