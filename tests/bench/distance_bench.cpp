/// One distance pass of a PUMA-sized arm of 6 capsules against two more such arms and 20 boxes (192 pairs), beside
/// FCL's public pairwise distance on the same pairs of the same poses, in one run.

#include <cstdio>
#include <random>

#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include "planner/collision/exact_distance.hpp"
#include "tests/bench/timings.hpp"

namespace {

using namespace hecaton;
using namespace hecaton::planner;
using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Six revolute joints with the PUMA 560's link lengths; a capsule along every link.
Arm puma_like(const std::string& name, const Eigen::Vector3d& base) {
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
    Pose X_LS = Pose::Identity();
    X_LS.translation().z() = 0.5 * rows[i].length;
    model->geometry.push_back({i + 1, world::Capsule{rows[i].radius, 0.5 * rows[i].length}, X_LS, 0.0});
    model->joint_names.push_back(link.joint_name);
  }
  model->tool_link = 6;
  Arm arm;
  arm.name = name;
  arm.model = model;
  arm.X_WB.translation() = base;
  return arm;
}

std::vector<world::Obstacle> boxes(Random& random) {
  std::vector<world::Obstacle> obstacles(20);
  for (int i = 0; i < 20; ++i) {
    obstacles[i].name = "box" + std::to_string(i);
    const double x = uniform(random, 0.05, 0.2);
    const double y = uniform(random, 0.05, 0.2);
    obstacles[i].shapes.push_back({world::Box{{x, y, uniform(random, 0.05, 0.2)}}, Pose::Identity()});
  }
  return obstacles;
}

/// One configuration of the whole cell.
struct Instant {
  std::vector<Kinematics> arms;
  std::vector<world::ObstacleState> obstacles;
};

Instant random_instant(const CellGeometry& geometry, Random& random) {
  Instant instant;
  for (const Arm& arm : geometry.arms()) {
    JointVector q(6);
    for (double& angle : q) angle = uniform(random, -1.5, 1.5);
    forward_kinematics(*arm.model, arm.X_WB, q, instant.arms.emplace_back());
  }
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    const Eigen::Vector3d rpy(uniform(random, -3, 3), uniform(random, -1.5, 1.5), uniform(random, -3, 3));
    instant.obstacles.emplace_back().X_WO = world::pose_from_xyz_rpy(
        {uniform(random, -1.2, 1.2), uniform(random, -1.2, 1.2), uniform(random, 0.0, 1.4)}, rpy);
  }
  return instant;
}

/// The same pairs as FCL objects.
class FclPairs {
 public:
  explicit FclPairs(const CellGeometry& geometry) : geometry_(geometry) {
    for (int arm = 0; arm < 3; ++arm) {
      for (const Body& body : geometry.arm_bodies(arm)) {
        const auto& capsule = std::get<world::Capsule>(body.shape);
        arm_objects_[arm].emplace_back(std::make_shared<fcl::Capsuled>(capsule.radius, 2.0 * capsule.half_length));
      }
    }
    for (int i = 0; i < geometry.obstacle_count(); ++i) {
      const auto& box = std::get<world::Box>(geometry.obstacle_bodies(i)[0].shape);
      box_objects_.emplace_back(std::make_shared<fcl::Boxd>(Eigen::Vector3d(2.0 * box.half_extents)));
    }
    request_.enable_nearest_points = true;
  }

  /// Distances of all pairs in the order of ExactDistance::clearances; FCL answers −1 for overlapping pairs.
  void distances(const Instant& instant, std::vector<double>& out) {
    for (int arm = 0; arm < 3; ++arm) {
      for (std::size_t i = 0; i < arm_objects_[arm].size(); ++i) {
        const Body& body = geometry_.arm_bodies(arm)[i];
        arm_objects_[arm][i].setTransform(instant.arms[arm].X_WL[body.link] * body.X_CS);
      }
    }
    for (std::size_t i = 0; i < box_objects_.size(); ++i) box_objects_[i].setTransform(instant.obstacles[i].X_WO);
    out.clear();
    for (int arm : {1, 2}) {
      for (auto& other : arm_objects_[arm]) {
        for (auto& own : arm_objects_[0]) out.push_back(distance(own, other));
      }
    }
    for (auto& box : box_objects_) {
      for (auto& own : arm_objects_[0]) out.push_back(distance(own, box));
    }
  }

 private:
  double distance(fcl::CollisionObjectd& a, fcl::CollisionObjectd& b) {
    fcl::DistanceResultd result;
    return fcl::distance(&a, &b, request_, result);
  }

  const CellGeometry& geometry_;
  std::vector<fcl::CollisionObjectd> arm_objects_[3];
  std::vector<fcl::CollisionObjectd> box_objects_;
  fcl::DistanceRequestd request_;
};

}  // namespace

int main() {
  Random random(20060521);
  CellGeometry geometry(
      {puma_like("arm1", {0, -0.7, 0}), puma_like("arm2", {0.6, 0.35, 0}), puma_like("arm3", {-0.6, 0.35, 0})}, 0);
  geometry.set_obstacles(boxes(random));
  ExactDistance ours(geometry);
  FclPairs fcl(geometry);
  std::vector<Clearance> room(256);

  bench::Timings near_pass("Hecaton, pairs within 0.12 m (a tick's pass)");
  bench::Timings full_pass("Hecaton, all 192 pairs");
  bench::Timings fcl_pass("fcl::distance, all 192 pairs, nearest points");
  long near = 0;
  std::vector<double> theirs;
  long differing = 0;
  double most_above = 0.0;
  double most_below = 0.0;
  constexpr int kInstants = 2000;
  for (int i = 0; i < kInstants; ++i) {
    const Instant instant = random_instant(geometry, random);
    const CellPoses poses{instant.arms.data(), instant.arms, instant.obstacles};
    int count = 0;
    near_pass.measure([&] { count = ours.clearances(poses, {0.12, 0.06, {}}, room); });
    near += count;
    full_pass.measure([&] { count = ours.clearances(poses, {100.0, 0.06, {}}, room); });
    fcl_pass.measure([&] { fcl.distances(instant, theirs); });
    if (count != 192) {
      std::printf("expected 192 pairs, found %d\n", count);
      return 1;
    }
    for (int k = 0; k < count; ++k) {
      if (theirs[k] <= 0.0 || room[k].distance <= 0.0) continue;
      const double difference = theirs[k] - room[k].distance;
      differing += std::abs(difference) > 1e-4;
      most_above = std::max(most_above, difference);
      most_below = std::max(most_below, -difference);
    }
  }

  bench::Timings::print_head();
  near_pass.print();
  full_pass.print();
  fcl_pass.print();
  full_pass.print_ratio(fcl_pass);
  near_pass.print_ratio(fcl_pass);
  std::printf("near pairs a pass: %.1f\n", static_cast<double>(near) / kInstants);
  std::printf("FCL differs by more than 0.1 mm on %ld of %d pairs; at most %.2g m above ours, %.2g m below\n",
              differing, 192 * kInstants, most_above, most_below);
  return 0;
}
