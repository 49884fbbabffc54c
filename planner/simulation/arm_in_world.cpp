#include "planner/simulation/arm_in_world.hpp"

#include <algorithm>
#include <limits>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner {
namespace {

/// Rounding must not delay a sensor by a period [s].
constexpr double kTimeTolerance = 1e-9;

}  // namespace

world::ArmBodies arm_bodies(const Arm& arm) {
  world::ArmBodies bodies;
  bodies.name = arm.name;
  bodies.robot = arm.robot;
  for (const LinkGeometry& geometry : arm.model->geometry) {
    bodies.parts.push_back({geometry.link,
                            arm.model->links[geometry.link].name,
                            {geometry.shape, geometry.X_LS},
                            axes_before(*arm.model, geometry.link) > 0});
  }
  bodies.self_pairs = arm.model->self_pairs;
  bodies.grasp_links = grasp_links(*arm.model);
  return bodies;
}

world::ArmBodies live_arm_bodies(const Arm& arm) {
  world::ArmBodies bodies = arm_bodies(arm);
  const RobotModel& model = *arm.model;
  const int links = static_cast<int>(model.links.size());
  for (std::size_t i = 0; i < model.geometry.size(); ++i) {
    const OutsideBody* body = outside_body(model, model.geometry[i].shape);
    if (body == nullptr) continue;
    bodies.parts[i].link = links + static_cast<int>(body - model.outside->bodies.data());
    bodies.parts[i].shape = {body->shape, body->X_LS};
    bodies.grasp_links.push_back(bodies.parts[i].link);
  }
  return bodies;
}

void set_measured(world::BulletWorld& world, int index, const Arm& arm, const JointVector& q,
                  const std::vector<double>& outside, Kinematics& scratch) {
  forward_kinematics(*arm.model, arm.X_WB, q, scratch);
  std::vector<Pose> X_WL(scratch.X_WL.begin(), scratch.X_WL.begin() + scratch.links);
  for (const Pose& X_TL : outside_places(*arm.model, outside)) X_WL.push_back(scratch.X_WT * X_TL);
  world.set_arm(index, X_WL, scratch.X_WT);
}

void set_measured(world::BulletWorld& world, int index, const Arm& arm, const JointVector& q, Kinematics& scratch) {
  forward_kinematics(*arm.model, arm.X_WB, q, scratch);
  world.set_arm(index, std::span<const Pose>(scratch.X_WL).first(scratch.links), scratch.X_WT);
}

RangeScanner::RangeScanner(const PlannedArm& arm, std::uint64_t seed)
    : arm_(arm), random_(seed), due_(arm.sensors.size(), -std::numeric_limits<double>::infinity()) {}

std::vector<RangeScan> RangeScanner::scan(double now, const JointVector& q, const world::RayCaster& caster) {
  std::vector<RangeScan> scans;
  for (int i = 0; i < static_cast<int>(arm_.sensors.size()); ++i) {
    const RangeSensor& sensor = arm_.sensors[i];
    if (now < due_[i] - kTimeTolerance) continue;
    const double next = due_[i] + sensor.period;
    due_[i] = next > now ? next : now + sensor.period;
    if (scans.empty()) forward_kinematics(*arm_.arm.model, arm_.arm.X_WB, q, kinematics_);
    RangeScan& scan = scans.emplace_back(RangeScan{i, sensor.link, q, {}});
    for (const SensorRay& ray : sensor.rays) scan.readings.push_back(read(sensor, ray, caster));
  }
  return scans;
}

RangeReading RangeScanner::read(const RangeSensor& sensor, const SensorRay& ray, const world::RayCaster& caster) {
  const Pose& X_WL = kinematics_.X_WL[sensor.link];
  const auto distance = caster.cast(X_WL * ray.origin_L, X_WL.linear() * ray.direction_L, sensor.range);
  if (!distance) return {ray, sensor.range, false};
  const double noise = sensor.noise * std::clamp(random_.normal(), -3.0, 3.0);
  return {ray, std::clamp(*distance + noise, 0.0, sensor.range), true};
}

}  // namespace hecaton::planner
