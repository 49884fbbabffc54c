#include "tests/bench/pairs_cell.hpp"

#include <string>

namespace hecaton::bench {
namespace {

using namespace planner;

std::vector<world::Obstacle> boxes(std::mt19937_64& random) {
  std::vector<world::Obstacle> obstacles(20);
  for (int i = 0; i < 20; ++i) {
    obstacles[i].name = "box" + std::to_string(i);
    const double x = uniform(random, 0.05, 0.2);
    const double y = uniform(random, 0.05, 0.2);
    obstacles[i].shapes.push_back({world::Box{{x, y, uniform(random, 0.05, 0.2)}}, Pose::Identity()});
  }
  return obstacles;
}

CellGeometry make_geometry(std::span<const world::Obstacle> obstacles, LinkShapes shapes) {
  CellGeometry geometry({puma_like("arm1", {0, -0.7, 0}, shapes), puma_like("arm2", {0.6, 0.35, 0}, shapes),
                         puma_like("arm3", {-0.6, 0.35, 0}, shapes)},
                        0);
  geometry.set_obstacles(obstacles);
  return geometry;
}

}  // namespace

Arm puma_like(const std::string& name, const Eigen::Vector3d& base, LinkShapes shapes) {
  struct Row {
    Eigen::Vector3d offset;  // of the joint in the parent's frame [m]
    Eigen::Vector3d axis;
    double length;  // of the link's capsule, along z [m]
    double radius;  // [m]
  };
  const Row rows[] = {{{0, 0, 0.30}, Eigen::Vector3d::UnitZ(), 0.37, 0.09},
                      {{0, 0.15, 0.37}, Eigen::Vector3d::UnitY(), 0.4318, 0.08},
                      {{0, -0.02, 0.4318}, Eigen::Vector3d::UnitY(), 0.25, 0.06},
                      {{0, 0, 0.25}, Eigen::Vector3d::UnitZ(), 0.18, 0.05},
                      {{0, 0, 0.18}, Eigen::Vector3d::UnitY(), 0.06, 0.045},
                      {{0, 0, 0.06}, Eigen::Vector3d::UnitZ(), 0.10, 0.04}};
  auto model = std::make_shared<RobotModel>();
  model->name = "puma_like";
  model->links.resize(7);
  model->links[0].name = "base";
  for (int i = 0; i < 6; ++i) {
    Link& link = model->links[i + 1];
    link.name = "link" + std::to_string(i + 1);
    link.joint_name = "joint" + std::to_string(i + 1);
    link.parent = link.joint = i;
    link.joint_type = JointType::kRevolute;
    link.X_PJ.translation() = rows[i].offset;
    link.axis = rows[i].axis;
    link.motion = joint_motion(link);
    Pose X_LS = Pose::Identity();
    X_LS.translation().z() = 0.5 * rows[i].length;
    const double half_length = 0.5 * rows[i].length;
    const world::Shape shape = shapes == LinkShapes::kFast ? world::Shape(world::Capsule{rows[i].radius, half_length})
                                                           : world::Shape(world::Cylinder{rows[i].radius, half_length});
    model->geometry.push_back({i + 1, shape, X_LS, 0.0});
    model->joint_names.push_back(link.joint_name);
  }
  model->tool_link = 6;
  const auto all = [](double value) { return JointVector(JointVector::Constant(6, value)); };
  model->limits = {all(-3.0), all(3.0), all(1.5), all(10.0)};
  Arm arm;
  arm.name = name;
  arm.model = model;
  arm.limits = model->limits;
  arm.shapes = shapes;
  arm.named["home"] = all(0.0);
  arm.X_WB.translation() = base;
  return arm;
}

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

PairsCell::PairsCell(std::uint64_t seed, LinkShapes shapes)
    : random_(seed), obstacles_(boxes(random_)), geometry_(make_geometry(obstacles_, shapes)) {}

Instant PairsCell::draw() {
  Instant instant;
  for (const Arm& arm : geometry_.arms()) {
    JointVector q(6);
    for (double& angle : q) angle = uniform(random_, -1.5, 1.5);
    forward_kinematics(*arm.model, arm.X_WB, q, instant.kinematics.emplace_back());
    instant.q.push_back(q);
  }
  for (int i = 0; i < geometry_.obstacle_count(); ++i) {
    const Eigen::Vector3d rpy(uniform(random_, -3, 3), uniform(random_, -1.5, 1.5), uniform(random_, -3, 3));
    instant.obstacles.emplace_back().X_WO = world::pose_from_xyz_rpy(
        {uniform(random_, -1.2, 1.2), uniform(random_, -1.2, 1.2), uniform(random_, 0.0, 1.4)}, rpy);
  }
  return instant;
}

}  // namespace hecaton::bench
