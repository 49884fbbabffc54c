#include "planner/simulation/range_scanner.hpp"

#include <algorithm>
#include <limits>

namespace hecaton::planner {
namespace {

/// Rounding must not let a sensor miss its turn [s].
constexpr double kTick = 1e-9;

}  // namespace

RangeScanner::RangeScanner(const PlannedArm& arm, std::uint64_t seed)
    : arm_(arm), random_(seed), due_(arm.sensors.size(), -std::numeric_limits<double>::infinity()) {}

std::vector<RangeScan> RangeScanner::scan(double now, const JointVector& q, const world::RayCaster& caster,
                                          std::span<const world::ObstacleState> obstacles) {
  std::vector<RangeScan> scans;
  for (int i = 0; i < static_cast<int>(arm_.sensors.size()); ++i) {
    const RangeSensor& sensor = arm_.sensors[i];
    if (now < due_[i] - kTick) continue;
    const double next = due_[i] + sensor.period;
    due_[i] = next > now ? next : now + sensor.period;
    if (scans.empty()) forward_kinematics(*arm_.arm.model, arm_.arm.X_WB, q, kinematics_);
    RangeScan& scan = scans.emplace_back(RangeScan{i, sensor.link, q, {}});
    for (const SensorRay& ray : sensor.rays) scan.readings.push_back(read(sensor, ray, caster, obstacles));
  }
  return scans;
}

RangeReading RangeScanner::read(const RangeSensor& sensor, const SensorRay& ray, const world::RayCaster& caster,
                                std::span<const world::ObstacleState> obstacles) {
  const Pose& X_WL = kinematics_.X_WL[sensor.link];
  const auto distance = caster.cast(X_WL * ray.origin_L, X_WL.linear() * ray.direction_L, sensor.range, obstacles);
  if (!distance) return {ray, sensor.range, false};
  const double noise = sensor.noise * std::clamp(random_.normal(), -3.0, 3.0);
  return {ray, std::clamp(*distance + noise, 0.0, sensor.range), true};
}

}  // namespace hecaton::planner
