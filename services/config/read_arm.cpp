#include "services/config/read_arm.hpp"

#include <algorithm>
#include <array>

#include "services/config/arm_models.hpp"
#include "services/config/fields.hpp"
#include "services/config/joint_values.hpp"
#include "services/config/read_network.hpp"
#include "services/config/read_parameters.hpp"
#include "services/config/read_sensors.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostArms = 128;
constexpr std::size_t kMostPoses = 256;
constexpr std::size_t kMostDeviceKeys = 64;
constexpr std::array<std::string_view, 2> kShapeNames = {"fast", "exact"};
constexpr std::array<planner::LinkShapes, 2> kShapes = {planner::LinkShapes::kFast, planner::LinkShapes::kExact};

void read_poses(const ArmView& view, planner::Arm& arm) {
  const auto add = [&](const MapView& map) {
    const auto poses = map.find("poses");
    if (!poses) return;
    for (const auto& [name, configuration] : poses->named_items(kMostPoses)) {
      if (arm.named.contains(name)) continue;  // the arm's own comes first; the default may be for other joints
      arm.named[name] = read_configuration(configuration, *arm.model, arm.limits);
    }
  };
  add(view.own);
  if (view.defaults) add(*view.defaults);
  // What the SRDF names comes last, and only as far as the cell file's narrower limits allow it.
  for (const auto& [name, q] : arm.model->named) {
    if ((q.array() >= arm.limits.lower.array()).all() && (q.array() <= arm.limits.upper.array()).all()) {
      arm.named.try_emplace(name, q);
    }
  }
  if (!arm.named.contains("home")) view.own.fail_missing("poses.home", "given for every arm");
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

planner::LocalParameters read_arm_parameters(const ArmView& view, const planner::Timing& timing) {
  planner::LocalParameters parameters;
  if (view.defaults) read_parameters(*view.defaults, parameters);
  read_parameters(view.own, parameters);
  const std::string complaint = parameters.validate();
  if (!complaint.empty()) {
    throw ConfigError(view.own.view().file() + ": " + view.own.view().path() + "." + complaint);
  }
  const auto require = [&](const char* key, double period) {
    if (parameters.state_age_limit >= 2.0 * period) return;
    view.own.fail("state_age_limit", number_text(parameters.state_age_limit * 1e3) + "ms",
                  std::string("at least twice timing.") + key + " = " + number_text(period * 1e3) + "ms");
  };
  require("control_period", timing.control_period);
  require("world_period", timing.world_period);
  return parameters;
}

planner::PlannedArm read_arm(const ArmView& view, const planner::Timing& timing, const ArmSections& sections,
                             ArmModels& models) {
  planner::PlannedArm planned;
  planned.arm.name = view.own.at("name").name();
  planned.arm.model = models.load(view);
  planned.arm.X_WB = read_pose(view.own, "base");
  planned.arm.limits = read_limits(view, *planned.arm.model);
  read_poses(view, planned.arm);
  planned.start = read_start(view, planned.arm);
  planned.parameters = read_arm_parameters(view, timing);
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

void require_unique_name(const YamlView& name, const std::vector<planner::PlannedArm>& arms) {
  const std::string word = name.name();
  for (std::size_t i = 0; i < arms.size(); ++i) {
    if (arms[i].arm.name == word) name.fail("unique, but arms[" + std::to_string(i) + "] has the same name");
  }
}

}  // namespace

void read_arms(const MapView& root, const planner::MethodRegistry& methods, CellFile& file) {
  ArmModels models;
  const ArmSections sections(methods);
  std::optional<MapView> defaults;
  if (const auto view = root.find("defaults")) defaults = view->map(sections.defaults());
  const auto geometry = root.find("geometry");
  const planner::LinkShapes shapes = geometry ? kShapes[geometry->choice(kShapeNames)] : planner::LinkShapes::kFast;
  for (const YamlView& view : root.at("arms").items(1, kMostArms, "arms")) {
    const ArmView arm{view.map(sections.arm()), defaults};
    require_unique_name(arm.own.at("name"), file.cell.arms);
    file.cell.arms.push_back(read_arm(arm, file.cell.timing, sections, models));
    file.cell.arms.back().arm.shapes = shapes;
    const std::string host = read_host(arm.own, "host", file.hosts);
    file.devices.push_back(read_device(arm));
    file.arm_hosts.push_back({host, read_standby_host(arm.own, "standby_host", file.hosts, host)});
  }
}

}  // namespace hecaton::config
