#include "services/bus/convert.hpp"
#include "services/bus/validate.hpp"

namespace hecaton::bus {
namespace {

/// As read from a file or computed: a unit vector within rounding.
constexpr double kUnitTolerance = 1e-3;
/// What a planner can map in a period is not endless.
constexpr std::size_t kMostRays = 4096;

}  // namespace

msg::RangeScan to_message(const planner::RangeScan& scan, const planner::RangeSensor& sensor) {
  msg::RangeScan message;
  message.max_range(sensor.range);
  message.rays().resize(scan.readings.size());
  for (std::size_t i = 0; i < scan.readings.size(); ++i) {
    msg::RangeRay& ray = message.rays()[i];
    ray.origin_L(to_message(scan.readings[i].ray.origin_L));
    ray.direction_L(to_message(scan.readings[i].ray.direction_L));
    ray.distance(scan.readings[i].distance);
    ray.hit(scan.readings[i].hit);
  }
  return message;
}

Converted<std::vector<planner::RangeReading>> from_message(const msg::RangeScan& message) {
  const std::string what = "RangeScan \"" + message.sensor() + "\": ";
  if (message.rays().size() > kMostRays) {
    return {{},
            what + std::to_string(message.rays().size()) + " rays must be " + std::to_string(kMostRays) + " at most"};
  }
  std::vector<planner::RangeReading> readings;
  for (const msg::RangeRay& ray : message.rays()) {
    const auto origin = from_message(ray.origin_L(), what + "origin_L");
    if (!origin) return {{}, origin.error};
    const auto direction = from_message(ray.direction_L(), what + "direction_L");
    if (!direction) return {{}, direction.error};
    if (std::abs(direction->norm() - 1.0) > kUnitTolerance) return {{}, what + "direction_L must be a unit vector"};
    if (auto error = check_above(what + "distance", ray.distance(), 0.0, true); !error.empty()) return {{}, error};
    readings.push_back({{*origin, direction->normalized()}, ray.distance(), ray.hit()});
  }
  return {std::move(readings), {}};
}

}  // namespace hecaton::bus
