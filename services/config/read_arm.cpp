#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planner/cell_defaults.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/model/urdf_loader.hpp"
#include "services/config/readers.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostArms = 128;
constexpr std::size_t kMostPackages = 256;
constexpr std::size_t kMostPoses = 256;
constexpr std::size_t kMostDeviceKeys = 64;
constexpr std::size_t kMostSensors = 64;
constexpr int kMostRays = 256;
constexpr std::array<std::string_view, 2> kGeometryNames = {"fast", "exact"};
constexpr std::array<std::string_view, 2> kMeshNames = {"hull", "capsule"};

// For joints without velocity limit in the URDF: the largest velocity of the cell file. read_limits() then limits each
// joint to its own value.
std::optional<double> fallback_velocity(const ArmView& arm) {
  const Bounds bounds{0.0, 1e3, "rad/s (m/s for a prismatic joint)", true};
  const auto view = arm.find("limits", section::kArmLimits, "velocity");
  if (!view) return std::nullopt;
  if (!view->is_sequence()) return view->number(bounds);
  double largest = 0.0;
  for (const YamlView& item : view->items(1, planner::kMaxJoints, "numbers, one for each joint")) {
    largest = std::max(largest, item.number(bounds));
  }
  return largest;
}

planner::UrdfOptions read_options(const ArmView& arm) {
  planner::UrdfOptions options;
  options.sources = &arm.own.view().sources();
  if (const auto tool_link = arm.find("tool_link")) options.tool_link = tool_link->text();
  if (const auto tool = arm.find("tool")) options.X_LT = read_pose(*tool);
  if (const auto srdf = arm.find("srdf")) options.srdf_path = beside(srdf->file(), srdf->text());
  if (const auto packages = arm.find("packages")) {
    for (const auto& [name, folder] : packages->named_items(kMostPackages)) {
      options.packages[name] = beside(folder.file(), folder.text());
    }
  }
  if (const auto meshes = arm.find("meshes")) {
    options.meshes = static_cast<planner::MeshGeometry>(meshes->choice(kMeshNames));
  }
  options.default_velocity = fallback_velocity(arm);
  options.default_acceleration.reset();
  options.name_of_default_velocity = arm.own.view().path() + ".limits.velocity";
  return options;
}

bool same(const planner::UrdfOptions& a, const planner::UrdfOptions& b) {
  return a.tool_link == b.tool_link && a.X_LT.matrix() == b.X_LT.matrix() && a.srdf_path == b.srdf_path &&
         a.packages == b.packages && a.meshes == b.meshes && a.default_velocity == b.default_velocity;
}

std::shared_ptr<const planner::RobotModel> load_model(const ArmView& arm, const std::string& path,
                                                      const planner::UrdfOptions& options) {
  try {
    return planner::load_arm_model(path, options);
  } catch (const planner::ModelError& error) {
    const std::string sentence = error.what();  // begins with its file
    const bool of_srdf = !options.srdf_path.empty() && sentence.starts_with(options.srdf_path + ":");
    arm.at(of_srdf ? "srdf" : "urdf").fail_with(sentence);
  }
}

/// Loads the robot models of a cell. Arms with the same URDF and options share one model.
class ArmModels {
 public:
  std::shared_ptr<const planner::RobotModel> load(const ArmView& arm) {
    const YamlView urdf = arm.at("urdf");
    const std::string path = beside(urdf.file(), urdf.text());
    const planner::UrdfOptions options = read_options(arm);
    const auto known = std::find_if(loaded_.begin(), loaded_.end(), [&](const Loaded& loaded) {
      return loaded.path == path && same(loaded.options, options);
    });
    if (known != loaded_.end()) return known->model;
    loaded_.push_back({path, options, load_model(arm, path, options)});
    return loaded_.back().model;
  }

 private:
  struct Loaded {
    std::string path;
    planner::UrdfOptions options;
    std::shared_ptr<const planner::RobotModel> model;
  };
  std::vector<Loaded> loaded_;
};

int read_link(const YamlView& view, const planner::RobotModel& model) {
  const std::string name = view.text();
  std::vector<std::string_view> names;
  for (int i = 0; i < static_cast<int>(model.links.size()); ++i) {
    if (model.links[i].name == name) return i;
    names.push_back(model.links[i].name);
  }
  view.fail("the name of a link of the robot: " + alternatives(names));
}

/// Beams from the first to the last, evenly spaced in position and direction.
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
    if (3.0 * sensor.noise > sensor.range)
      map.at("noise").fail("at most a third of range, because errors reach three times the noise");
    read_seconds(map, "period", {0.001, 10.0, "s"}, sensor.period);
    read_boolean(map, "simulated", sensor.simulated);
    sensors.push_back(std::move(sensor));
  }
  return sensors;
}

void read_poses(const ArmView& view, planner::Arm& arm) {
  const auto add = [&](const MapView& map) {
    const auto poses = map.find("poses");
    if (!poses) return;
    for (const auto& [name, configuration] : poses->named_items(kMostPoses)) {
      if (arm.named.contains(name)) continue;  // the arm's own pose has precedence; the default may have other joints
      arm.named[name] = read_configuration(configuration, *arm.model, arm.limits);
    }
  };
  add(view.own);
  if (view.defaults) add(*view.defaults);
  // Poses of the SRDF come last, and only those within the cell file's narrower limits.
  for (const auto& [name, q] : arm.model->named) {
    if ((q.array() >= arm.limits.lower.array()).all() && (q.array() <= arm.limits.upper.array()).all()) {
      arm.named.try_emplace(name, q);
    }
  }
}

planner::JointVector read_start(const ArmView& view, const planner::Arm& arm) {
  const auto start = view.find("start");
  if (!start) return arm.home();
  const auto pose = arm.named.find(start->text());
  if (pose != arm.named.end()) return pose->second;
  std::vector<std::string_view> names;
  for (const auto& [name, q] : arm.named) names.push_back(name);
  start->fail("the name of one of the arm's poses: " + alternatives(names));
}

planner::PlannedArm read_arm(const ArmView& view, const planner::Timing& timing, const ArmSections& sections,
                             ArmModels& models) {
  planner::PlannedArm planned;
  planned.arm.name = view.own.at("name").name();
  planned.arm.model = models.load(view);
  planned.arm.X_WB = read_pose(view.own, "base");
  planned.arm.limits = read_limits(view, *planned.arm.model);
  read_poses(view, planned.arm);
  if (!planned.arm.named.contains("home")) planned.arm.named["home"] = planner::compact_postures(planned.arm).front();
  planned.start = read_start(view, planned.arm);
  planned.parameters = read_parameters(view, sections, planned.arm, timing);
  planned.methods = read_methods(view, sections);
  planned.select_method(read_method_name(view, sections));
  planned.sensors = read_sensors(view, *planned.arm.model);
  if (const auto objection = planned.objection()) view.own.view().fail_with("method = " + *objection);
  return planned;
}

DeviceOptions read_device(const ArmView& view) {
  DeviceOptions device;
  const auto map = view.find("device");
  device.where = view.own.view().file() + ": " + (map ? map->path() : view.own.view().path() + ".device");
  if (!map) return device;
  if (!map->is_map() || !map->entry("type")) map->fail("a map with the key type, such as {type: simulated}");
  for (const auto& [key, value] : map->named_items(kMostDeviceKeys)) {
    (key == "type" ? device.type : device.values[key]) = value.text();
  }
  return device;
}

void note_open_values(const ArmView& view, int index, const planner::RobotModel& model, OpenValues& open) {
  if (!view.find("limits", section::kArmLimits, "acceleration")) open.acceleration.push_back(index);
  const auto has_home = [](const MapView& map) {
    const auto poses = map.find("poses");
    return poses && poses->entry("home");
  };
  const bool given = has_home(view.own) || (view.defaults && has_home(*view.defaults)) || model.named.contains("home");
  if (!given) open.home.push_back(index);
}

void require_unique_name(const YamlView& name, const std::vector<planner::PlannedArm>& arms) {
  const std::string word = name.name();
  for (std::size_t i = 0; i < arms.size(); ++i) {
    if (arms[i].arm.name == word) name.fail("unique, but arms[" + std::to_string(i) + "] has the same name");
  }
}

}  // namespace

OpenValues read_arms(const MapView& root, const planner::MethodRegistry& methods, CellFile& file) {
  OpenValues open;
  ArmModels models;
  const ArmSections sections(methods);
  std::optional<MapView> defaults;
  if (const auto view = root.find("defaults")) defaults = view->map(sections.defaults());
  planner::LinkShapes shapes = planner::LinkShapes::kFast;
  read_choice(root, "geometry", kGeometryNames, shapes);
  for (const YamlView& view : root.at("arms").items(1, kMostArms, "arms")) {
    const ArmView arm{view.map(sections.arm()), defaults};
    require_unique_name(arm.own.at("name"), file.cell.arms);
    file.cell.arms.push_back(read_arm(arm, file.cell.timing, sections, models));
    file.cell.arms.back().arm.shapes = shapes;
    note_open_values(arm, static_cast<int>(file.cell.arms.size()) - 1, *file.cell.arms.back().arm.model, open);
    const std::string host = read_host(arm.own, "host", file.hosts);
    file.devices.push_back(read_device(arm));
    file.arm_hosts.push_back({host, read_standby_host(arm.own, "standby_host", file.hosts, host)});
  }
  return open;
}

}  // namespace hecaton::config
