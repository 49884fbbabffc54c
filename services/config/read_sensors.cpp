#include "services/config/read_sensors.hpp"

#include <algorithm>

#include "services/config/fields.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostSensors = 64;
constexpr int kMostRays = 256;

int read_link(const YamlView& view, const planner::RobotModel& model) {
  const std::string name = view.text();
  std::vector<std::string_view> names;
  for (int i = 0; i < static_cast<int>(model.links.size()); ++i) {
    if (model.links[i].name == name) return i;
    names.push_back(model.links[i].name);
  }
  view.fail("the name of a link of the robot: " + alternatives(names));
}

/// Evenly from the first beam to the last, in place and in direction.
std::vector<planner::SensorRay> read_rays(const MapView& map) {
  const Eigen::Vector3d first = read_vector(map.at("position"), kCoordinate, "numbers [x, y, z] in m");
  const Eigen::Vector3d first_direction = read_direction(map.at("direction"));
  Eigen::Vector3d last = first;
  Eigen::Vector3d last_direction = first_direction;
  if (const auto to = map.find("to_position")) last = read_vector(*to, kCoordinate, "numbers [x, y, z] in m");
  if (const auto to = map.find("to_direction")) last_direction = read_direction(*to);
  const auto rays = map.find("rays");
  const int count = rays ? rays->integer(1, kMostRays) : 1;
  if (first_direction.dot(last_direction) < -0.999) {
    map.at("to_direction").fail("less than half a turn from direction");
  }
  std::vector<planner::SensorRay> read;
  for (int i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.0 : static_cast<double>(i) / (count - 1);
    const Eigen::Quaterniond turn = Eigen::Quaterniond::Identity().slerp(
        share, Eigen::Quaterniond::FromTwoVectors(first_direction, last_direction));
    read.push_back({first + share * (last - first), (turn * first_direction).normalized()});
  }
  return read;
}

}  // namespace

std::vector<planner::RangeSensor> read_sensors(const ArmView& view, const planner::RobotModel& model) {
  std::vector<planner::RangeSensor> sensors;
  const auto list = view.find("sensors");
  if (!list) return sensors;
  for (const YamlView& item : list->items(1, kMostSensors, "sensors")) {
    const MapView map = item.map(section::kSensor);
    planner::RangeSensor sensor;
    sensor.name = map.at("name").name();
    const bool taken = std::any_of(sensors.begin(), sensors.end(),
                                   [&](const planner::RangeSensor& other) { return other.name == sensor.name; });
    if (taken) map.at("name").fail("unique on the arm");
    sensor.link = read_link(map.at("link"), model);
    sensor.rays = read_rays(map);
    read_number(map, "range", kLength, sensor.range);
    read_number(map, "noise", {0.0, 1.0, "m"}, sensor.noise);
    if (3.0 * sensor.noise > sensor.range) map.at("noise").fail("at most a third of range: it is off by up to three");
    read_seconds(map, "period", {0.001, 10.0, "s"}, sensor.period);
    read_boolean(map, "simulated", sensor.simulated);
    sensors.push_back(std::move(sensor));
  }
  return sensors;
}

}  // namespace hecaton::config
