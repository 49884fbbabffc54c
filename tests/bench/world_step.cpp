/// Steps of the world of three moving arms among many obstacles, beside a pass over all pairs.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "planner/simulation/arm_in_world.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"
#include "tests/support/pairwise_contacts.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::bench {
namespace {

using Eigen::Vector3d;
using planner::JointVector;
using planner::PlannedArm;
using world::Obstacle;
using world::Pose;

constexpr double kPeriod = 0.01;  // a world's default [s]
constexpr int kSteps = 2000;
constexpr int kWarmUp = 100;         // steps: the first separations
constexpr double kClearance = 0.01;  // of static obstacles from the arms' ways [m]
constexpr double kSample = 0.05;     // of these ways [s]
constexpr int kRays = 8;             // of each arm's sensor
constexpr double kRange = 1.5;       // of the sensors [m]

struct Arms {
  Arms() {
    int number = 0;
    for (const Vector3d& base : {Vector3d(0, -0.7, 0), Vector3d(0.6, 0.35, 0), Vector3d(-0.6, 0.35, 0)}) {
      PlannedArm& planned = planned_.emplace_back();
      planned.arm = puma_like("arm" + std::to_string(++number), base);
      planner::RangeSensor& sensor = planned.sensors.emplace_back();
      sensor.name = "around";
      sensor.link = 3;
      sensor.range = kRange;
      sensor.period = kPeriod;
      for (int i = 0; i < kRays; ++i) {
        const double angle = 2.0 * M_PI * i / kRays;
        sensor.rays.push_back({{0, 0, 0.1}, {std::cos(angle), std::sin(angle), 0}});
      }
      bodies_.push_back(planner::arm_bodies(planned.arm));
    }
  }

  [[nodiscard]] static JointVector q(int arm, double time) {
    JointVector q(6);
    for (int i = 0; i < 6; ++i) q[i] = 0.9 * std::sin((0.7 + 0.13 * i + 0.05 * arm) * time + 1.7 * i + 2.3 * arm);
    return q;
  }

  /// Poses of the links of each arm.
  [[nodiscard]] std::vector<std::vector<Pose>> at(double time) const {
    std::vector<std::vector<Pose>> poses;
    planner::Kinematics scratch;
    for (int i = 0; i < static_cast<int>(planned_.size()); ++i) {
      const planner::Arm& arm = planned_[i].arm;
      planner::forward_kinematics(*arm.model, arm.X_WB, q(i, time), scratch);
      poses.emplace_back(scratch.X_WL.begin(), scratch.X_WL.begin() + scratch.links);
    }
    return poses;
  }

  [[nodiscard]] const std::vector<world::ArmBodies>& bodies() const { return bodies_; }
  [[nodiscard]] const std::vector<PlannedArm>& planned() const { return planned_; }

 private:
  std::vector<PlannedArm> planned_;
  std::vector<world::ArmBodies> bodies_;
};

world::Shape small_shape(std::mt19937_64& random) {
  const auto size = [&] { return uniform(random, 0.01, 0.04); };
  switch (std::uniform_int_distribution<int>(0, 3)(random)) {
    case 0:
      return world::Box{{size(), size(), size()}};
    case 1:
      return world::Sphere{size()};
    case 2:
      return world::Capsule{size(), size()};
    default:
      return world::Cylinder{size(), size()};
  }
}

/// Keeps obstacles off the ways of the arms.
class Ways {
 public:
  explicit Ways(const Arms& arms) {
    for (double time = 0.0; time < kPeriod * (kSteps + kWarmUp); time += kSample) {
      const auto poses = arms.at(time);
      for (std::size_t arm = 0; arm < poses.size(); ++arm) {
        for (const auto& part : arms.bodies()[arm].parts) {
          const Pose X_WS = poses[arm][part.link] * part.shape.X_BS;
          const world::BoundingSphere bound = world::bounding_sphere(part.shape.shape);
          taken_.push_back(
              {X_WS * bound.centre, bound.radius, world::to_bullet(X_WS), world::make_bullet_shape(part.shape.shape)});
        }
      }
    }
  }

  [[nodiscard]] bool clear(const Obstacle& obstacle) const {
    const auto shape = world::make_bullet_shape(obstacle.shapes[0].shape);
    const double radius = world::bounding_sphere(obstacle.shapes[0].shape).radius + kClearance;
    const btTransform X = world::to_bullet(obstacle.X_WO);
    for (const Taken& taken : taken_) {
      const double reach = taken.radius + radius;
      if ((taken.centre_W - obstacle.X_WO.translation()).squaredNorm() > reach * reach) continue;
      if (world::signed_distance(*taken.shape, taken.X_WS, *shape, X).distance < kClearance) return false;
    }
    return true;
  }

 private:
  struct Taken {
    Vector3d centre_W;
    double radius;
    btTransform X_WS;
    std::shared_ptr<const btConvexShape> shape;
  };
  std::vector<Taken> taken_;
};

/// Static obstacles anywhere in 4 m × 4 m × 2 m, beside the ways of the arms.
std::vector<Obstacle> static_obstacles(const Arms& arms, int count) {
  std::mt19937_64 random(20260711);
  const Ways ways(arms);
  std::vector<Obstacle> obstacles;
  while (static_cast<int>(obstacles.size()) < count) {
    Obstacle obstacle;
    obstacle.name = "obstacle" + std::to_string(obstacles.size());
    obstacle.shapes.push_back({small_shape(random), Pose::Identity()});
    const Vector3d rpy(uniform(random, -3, 3), uniform(random, -1.5, 1.5), uniform(random, -3, 3));
    obstacle.X_WO =
        world::pose_from_xyz_rpy({uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, 0.05, 2)}, rpy);
    if (ways.clear(obstacle)) obstacles.push_back(obstacle);
  }
  return obstacles;
}

/// Dynamic boxes on the floor around the arms, in stacks of two; a tenth falls from 0.5 m.
std::vector<Obstacle> dynamic_obstacles(int count) {
  std::vector<Obstacle> obstacles;
  const int stacks = (count + 1) / 2;
  const int side = static_cast<int>(std::ceil(std::sqrt(stacks)));
  for (int i = 0; i < count; ++i) {
    Obstacle obstacle;
    obstacle.name = "box" + std::to_string(i);
    obstacle.shapes.push_back({world::Box{{0.03, 0.03, 0.03}}, Pose::Identity()});
    const double height = i % 2 == 0 ? 0.03 : (i % 20 == 1 ? 0.59 : 0.09);
    obstacle.X_WO.translation() =
        Vector3d(0.1 * (i / 2 % side) - 0.05 * side, 0.1 * (i / 2 / side) - 0.05 * side, height);
    obstacle.motion = world::DynamicMotion{};
    obstacles.push_back(obstacle);
  }
  return obstacles;
}

/// A world in which the arms move on.
class Running {
 public:
  Running(const Arms& arms, std::vector<Obstacle> obstacles)
      : arms_(arms), world_(world::Scene{std::move(obstacles), 0.0, {0, 0, -9.81}}, arms.bodies()) {}

  void step() {
    time_ += kPeriod;
    for (int i = 0; i < static_cast<int>(arms_.planned().size()); ++i) {
      planner::set_measured(world_, i, arms_.planned()[i].arm, Arms::q(i, time_), scratch_);
    }
    world_.step(kPeriod);
  }
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] world::BulletWorld& world() { return world_; }

 private:
  const Arms& arms_;
  world::BulletWorld world_;
  planner::Kinematics scratch_;
  double time_ = 0.0;
};

/// Beside a pass over all pairs of a moving part and an obstacle, with spheres as bounds.
void step(benchmark::State& state, std::vector<Obstacle> (*make)(const Arms&, int), int count) {
  const int peer_every = std::max(1, count / 20);
  const Arms arms;
  const std::vector<Obstacle> obstacles = make(arms, count);
  Running running(arms, obstacles);
  world::PairwiseContacts pairwise(arms.bodies(), obstacles);
  Timings ours;
  Timings peer;
  for (int i = 0; i < kWarmUp; ++i) running.step();
  int number = 0;
  for (auto _ : state) {
    const double taken = processor_time_once([&] { running.step(); });
    ours.add(taken);
    set_iteration_time(state, taken);
    if (number++ % peer_every != 0) continue;
    const auto poses = arms.at(running.time());
    std::vector<world::MeasuredArm> measured;
    for (const auto& links : poses) measured.push_back({true, links});
    const auto states = running.world().snapshot().states;
    peer.add(processor_time_once([&] { pairwise.update(measured, states, running.time(), true); }));
  }
  report(state, ours, peer);
  const world::ContactReport contacts = running.world().contact_monitor().report();
  state.counters["smallest_mm"] = contacts.kinds[1].smallest.distance * 1e3;
  state.counters["contacts"] = static_cast<double>(contacts.contacts);
}

std::vector<Obstacle> only_dynamic(const Arms&, int count) {
  return dynamic_obstacles(count);
}

std::vector<Obstacle> static_and_a_dynamic_one(const Arms& arms, int count) {
  std::vector<Obstacle> obstacles = static_obstacles(arms, count);
  Obstacle ball;
  ball.name = "ball";
  ball.shapes.push_back({world::Sphere{0.03}, Pose::Identity()});
  ball.X_WO.translation() = Vector3d(1.9, 1.9, 1.0);
  ball.motion = world::DynamicMotion{};
  obstacles.push_back(ball);
  return obstacles;
}

/// One scan of each arm. The peer asks for each obstacle by itself, as a loop over all obstacles does.
void scan(benchmark::State& state, int count) {
  const int peer_every = std::max(1, count / 100);
  const Arms arms;
  const std::vector<Obstacle> obstacles = static_obstacles(arms, count);
  Running running(arms, obstacles);
  world::RayCaster all;
  all.set_obstacles(obstacles);
  std::vector<world::RayCaster> each(obstacles.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const world::ObstacleState resting{obstacles[i].X_WO, {}, 0.0};
    each[i].set_obstacles(std::span(&obstacles[i], 1));
    each[i].place(std::span(&resting, 1));
  }
  std::vector<planner::RangeScanner> scanners;
  for (std::size_t i = 0; i < arms.planned().size(); ++i) scanners.emplace_back(arms.planned()[i], i + 1);
  Timings ours;
  Timings peer;
  int number = 0;
  double hits = 0.0;
  for (auto _ : state) {
    for (int i = 0; i < 10; ++i) running.step();
    const double taken = processor_time_once([&] {
      all.place(running.world().present());
      for (int i = 0; i < static_cast<int>(scanners.size()); ++i) {
        for (const auto& scan : scanners[i].scan(running.time(), Arms::q(i, running.time()), all)) {
          for (const auto& reading : scan.readings) hits += reading.hit ? 1.0 : 0.0;
        }
      }
    });
    ours.add(taken);
    set_iteration_time(state, taken);
    if (number++ % peer_every != 0) continue;
    const auto poses = arms.at(running.time());
    peer.add(processor_time_once([&] {
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const planner::RangeSensor& sensor = arms.planned()[i].sensors[0];
        const Pose& X_WL = poses[i][sensor.link];
        for (const planner::SensorRay& ray : sensor.rays) {
          for (std::size_t k = 0; k < each.size(); ++k) {
            benchmark::DoNotOptimize(each[k].cast(X_WL * ray.origin_L, X_WL.linear() * ray.direction_L, sensor.range));
          }
        }
      }
    }));
  }
  report(state, ours, peer);
  state.counters["rays"] = kRays * static_cast<double>(scanners.size());
  state.counters["hits"] = benchmark::Counter(hits, benchmark::Counter::kAvgIterations);
}

/// An obstacle is added and removed again.
void edit(benchmark::State& state, int count) {
  const Arms arms;
  Running running(arms, static_obstacles(arms, count));
  running.step();
  Obstacle extra;
  extra.name = "extra";
  extra.shapes.push_back({world::Box{{0.03, 0.03, 0.03}}, Pose::Identity()});
  extra.X_WO.translation() = Vector3d(1.9, 1.9, 2.5);
  Timings ours;
  for (auto _ : state) {
    const double taken = processor_time_once([&] {
      running.world().add(extra);
      running.step();
      running.world().remove("extra");
      running.step();
    });
    ours.add(taken);
    set_iteration_time(state, taken);
  }
  report(state, ours);
}

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, int iterations, auto function, auto... arguments) {
    benchmark::RegisterBenchmark(("world/" + name).c_str(), function, arguments...)
        ->Iterations(iterations)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  };
  for (const int count : {100, 1000, 10000}) {
    const std::string of = std::to_string(count);
    add("step_among_static/" + of, kSteps, step, static_obstacles, count);
    add("scan_among_static/" + of, kSteps / 10, scan, count);
    add("edit_among_static/" + of, 20, edit, count);
  }
  for (const int count : {100, 1000})
    add("step_with_dynamic/" + std::to_string(count), kSteps, step, only_dynamic, count);
  add("step_among_static_with_a_dynamic_one/10000", kSteps, step, static_and_a_dynamic_one, 10000);
  return true;
}();

}  // namespace
}  // namespace hecaton::bench
