#pragma once
/// A cell of random arms and obstacles in random poses, crowded enough that every kind of pair comes near.

#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/pass_input.hpp"
#include "random_shapes.hpp"

namespace hecaton::test {

/// A root that stands and `joints` revolute links, each with one or two shapes; link i's shapes are checked against
/// those of links up to i − 2.
inline planner::Arm random_arm(const std::string& name, int joints, Random& random) {
  using namespace planner;
  auto model = std::make_shared<RobotModel>();
  model->name = name;
  const auto add_shape = [&](int link) {
    const auto kind = static_cast<Kind>(std::uniform_int_distribution<int>(0, kKinds - 1)(random));
    world::Shape shape = random_shape(kind, random);
    const auto capsule = planner::link_capsule(shape);
    model->geometry.push_back({link, std::move(shape), random_pose(random, 0.1), 0.0, capsule});
  };
  model->links.emplace_back().name = "root";
  add_shape(0);
  for (int i = 0; i < joints; ++i) {
    Link link;
    link.name = "link" + std::to_string(i + 1);
    link.joint_name = "joint" + std::to_string(i + 1);
    link.parent = link.joint = i;
    link.joint_type = JointType::kRevolute;
    link.X_PJ.translation() = random_vector(random, -0.1, 0.1) + Eigen::Vector3d(0, 0, 0.3);
    link.axis = random_direction(random);
    model->links.push_back(link);
    model->joint_names.push_back(link.joint_name);
    add_shape(i + 1);
    if (i % 3 == 1) add_shape(i + 1);
  }
  model->tool_link = joints;
  const int count = static_cast<int>(model->geometry.size());
  for (int first = 0; first < count; ++first) {
    for (int second = first + 1; second < count; ++second) {
      if (model->geometry[second].link - model->geometry[first].link >= 2)
        model->self_pairs.emplace_back(first, second);
    }
  }
  model->limits.lower.setConstant(joints, -3.0);
  model->limits.upper.setConstant(joints, 3.0);
  model->limits.velocity.setConstant(joints, 2.0);
  model->limits.acceleration.setConstant(joints, 10.0);
  Arm arm;
  arm.name = name;
  arm.model = model;
  arm.limits = model->limits;
  arm.X_WB.translation() = random_vector(random, -0.8, 0.8).cwiseProduct(Eigen::Vector3d(1, 1, 0.1));
  arm.named["home"] = JointVector::Zero(joints);
  return arm;
}

class RandomCell {
 public:
  explicit RandomCell(std::uint64_t seed, planner::LinkShapes shapes = planner::LinkShapes::kExact, int arms = 3,
                      int obstacles = 6)
      : random_(seed), geometry_(make(arms, shapes)) {
    std::vector<world::Obstacle> things(obstacles);
    for (int i = 0; i < obstacles; ++i) {
      things[i].name = "thing" + std::to_string(i);
      for (int shape = 0; shape <= i % 2; ++shape) {
        things[i].shapes.push_back({random_shape(static_cast<Kind>(i % kKinds), random_), random_pose(random_, 0.2)});
      }
    }
    // A floor, much larger than everything else, and something that the own arm carries.
    things[0].shapes = {{world::Box{{3.0, 3.0, 0.05}}, world::Pose::Identity()}};
    things[1].attachment = world::Attachment{geometry_.own_arm().name, random_pose(random_, 0.1)};
    geometry_.set_obstacles(things);
    shuffle();
  }

  /// New configurations of all arms and new poses of all obstacles.
  void shuffle() {
    kinematics_.resize(geometry_.arms().size());
    for (std::size_t i = 0; i < kinematics_.size(); ++i) {
      const planner::Arm& arm = geometry_.arms()[i];
      planner::JointVector q(arm.model->joints());
      for (double& angle : q) angle = uniform(random_, -3.0, 3.0);
      planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics_[i]);
    }
    states_.resize(geometry_.obstacle_count());
    for (auto& state : states_) state.X_WO = random_pose(random_, 1.0);
    states_[0].X_WO.translation() = Eigen::Vector3d(0.0, 0.0, -0.1);
  }

  [[nodiscard]] const planner::CellGeometry& geometry() const { return geometry_; }
  [[nodiscard]] planner::CellPoses poses() const { return {&kinematics_[geometry_.self()], kinematics_, states_}; }

 private:
  planner::CellGeometry make(int arms, planner::LinkShapes shapes) {
    std::vector<planner::Arm> all;
    all.reserve(arms);
    for (int i = 0; i < arms; ++i) {
      all.push_back(random_arm("arm" + std::to_string(i + 1), 5 + i % 3, random_));
      all.back().shapes = shapes;
    }
    return {std::move(all), arms / 2};
  }

  Random random_;
  planner::CellGeometry geometry_;
  std::vector<planner::Kinematics> kinematics_;
  std::vector<world::ObstacleState> states_;
};

}  // namespace hecaton::test
