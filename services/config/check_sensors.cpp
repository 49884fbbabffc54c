#include <algorithm>

#include "services/config/findings.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

/// Beams count as parallel up to this change of direction.
constexpr double kSameWay = 1e-6;
/// Rounded decimals are no reason to warn [m].
constexpr double kNearEnough = 1e-4;

/// The widest gap between two neighbouring parallel beams [m].
double widest_gap(const planner::RangeSensor& sensor) {
  double widest = 0.0;
  for (std::size_t i = 1; i < sensor.rays.size(); ++i) {
    const planner::SensorRay& one = sensor.rays[i - 1];
    const planner::SensorRay& other = sensor.rays[i];
    if ((one.direction_L - other.direction_L).norm() > kSameWay) continue;
    widest = std::max(widest, one.direction_L.cross(other.origin_L - one.origin_L).norm());
  }
  return widest;
}

}  // namespace

// docs/design/0011-sensed-cspace.md: what stands out between two beams stays within half of what is between them.
void check_sensors(const planner::Cell& cell, Findings& findings) {
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const planner::PlannedArm& planned = cell.arms[arm];
    const auto sensing_margin = planned.parameters.method->sensing_margin();
    if (!sensing_margin) continue;
    const double margin = sensing_margin->value;
    const planner::RangeSensor* worst = nullptr;
    double needed = margin + kNearEnough;
    for (const planner::RangeSensor& sensor : planned.sensors) {
      const double of_sensor = 0.5 * widest_gap(sensor) + 3.0 * sensor.noise;
      if (of_sensor <= needed) continue;
      needed = of_sensor;
      worst = &sensor;
    }
    if (worst == nullptr) continue;
    findings.push_back({Severity::kWarning, arm_key(arm) + "." + std::string(sensing_margin->key) + " = " +
                                                number_text(margin) + " should be at least " + number_text(needed) +
                                                " m: half of what is between two beams of sensor " + worst->name +
                                                ", and three times its noise"});
  }
}

}  // namespace hecaton::config
