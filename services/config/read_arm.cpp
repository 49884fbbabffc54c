#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "planner/cell_defaults.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/model/outside_joints.hpp"
#include "planner/model/urdf_loader.hpp"
#include "services/config/readers.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostArms = 128;
constexpr std::size_t kMostPackages = 256;
constexpr std::size_t kMostHeldJoints = 1024;
constexpr std::size_t kMostXacroArguments = 256;
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

/// `chain` names the base link and the tool link, `tool_link` the latter only.
void read_chain(const ArmView& arm, planner::UrdfOptions& options) {
  const auto tool_link = arm.find("tool_link");
  if (tool_link) options.tool_link = tool_link->text();
  const auto chain = arm.find("chain");
  if (!chain) return;
  const auto links = chain->items(2, 2, "links: the base link and the tool link");
  options.base_link = links[0].text();
  if (tool_link && options.tool_link != links[1].text()) tool_link->fail("left out, because chain names the tool link");
  options.tool_link = links[1].text();
}

/// How messages of the loader name the keys of an arm.
planner::UrdfOptionNames names_of_keys(const std::string& arm) {
  return {arm + ".tool_link", arm + ".packages: {@: DIR}", arm + ".joints",
          arm + ".xacro",     arm + ".limits.velocity",    arm + ".allow_bare_links"};
}

planner::UrdfOptions read_options(const ArmView& arm) {
  planner::UrdfOptions options;
  options.sources = &arm.own.view().sources();
  read_chain(arm, options);
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
  options.joints_of_all_arms = !arm.own.find("joints");  // those of the defaults
  if (const auto joints = arm.find("joints")) {
    for (const auto& [name, position] : joints->named_items(kMostHeldJoints)) {
      const Bounds bounds{-1e6, 1e6, "rad or m"};
      if (position.is_sequence()) {
        const auto ends = position.items(2, 2, "numbers: the lowest and the highest position");
        options.moving_joints[name] = {ends[0].number(bounds), ends[1].number(bounds)};
      } else {
        options.held_joints[name] = position.number(bounds);
      }
    }
  }
  if (const auto arguments = arm.find("xacro")) {
    for (const auto& [name, value] : arguments->named_items(kMostXacroArguments)) {
      options.xacro_arguments[name] = value.text();
    }
  }
  if (const auto bare = arm.find("allow_bare_links")) options.allow_bare_links = bare->boolean();
  options.default_velocity = fallback_velocity(arm);
  options.default_acceleration.reset();
  options.names = names_of_keys(arm.own.view().path());
  return options;
}

bool same(const planner::UrdfOptions& a, const planner::UrdfOptions& b) {
  return a.base_link == b.base_link && a.tool_link == b.tool_link && a.X_LT.matrix() == b.X_LT.matrix() &&
         a.other_arms == b.other_arms && a.held_joints == b.held_joints && a.moving_joints == b.moving_joints &&
         a.joints_of_all_arms == b.joints_of_all_arms && a.srdf_path == b.srdf_path && a.packages == b.packages &&
         a.xacro_arguments == b.xacro_arguments && a.meshes == b.meshes && a.default_velocity == b.default_velocity &&
         a.allow_bare_links == b.allow_bare_links;
}

/// The description of an arm's robot: the value of `urdf`, or of `robot`.
struct RobotSource {
  YamlView view;
  bool by_name;

  /// Loads the model. Throws ConfigError.
  [[nodiscard]] std::shared_ptr<const planner::RobotModel> load(const ArmView& arm,
                                                                const planner::UrdfOptions& options) const {
    try {
      if (!by_name) return planner::load_arm_model(beside(view.file(), view.text()), options);
      const std::string name = view.text();
      if (!is_robot_name(name, view.sources())) view.fail("the name of a robot: " + robot_suggestion(name));
      return load_named_robot(read_named_robot(name, view.sources()), options);
    } catch (const planner::ModelError& error) {
      const std::string sentence = error.what();  // begins with its file
      const bool of_srdf = !options.srdf_path.empty() && sentence.starts_with(options.srdf_path + ":");
      (of_srdf ? arm.at("srdf") : view).fail_with(sentence);
    }
  }
};

/// Of the arm itself, else of the defaults. A map with both keys is an error.
RobotSource robot_source(const ArmView& arm) {
  for (const MapView* map : {&arm.own, arm.defaults ? &*arm.defaults : nullptr}) {
    if (map == nullptr) continue;
    const auto urdf = map->find("urdf");
    const auto robot = map->find("robot");
    if (urdf && robot) robot->fail("left out, because urdf = " + urdf->value() + " describes the robot");
    if (robot) return {*robot, true};
    if (urdf) return {*urdf, false};
  }
  arm.own.fail_missing("urdf", "given, or robot with a name that `hecaton robots` lists");
}

RobotFiles robot_files(const ArmView& arm) {
  const RobotSource source = robot_source(arm);
  const planner::UrdfOptions options = read_options(arm);
  const std::string text = source.view.text();
  return {source.by_name ? read_named_robot(text, source.view.sources()).urdf : beside(source.view.file(), text),
          options.packages, options.xacro_arguments};
}

/// Loads the robot models of a cell. Arms with the same robot and options share one model.
class ArmModels {
 public:
  /// `other_arms`: tool links of the other arms of the same robot.
  std::shared_ptr<const planner::RobotModel> load(const ArmView& arm, const std::vector<std::string>& other_arms) {
    const RobotSource source = robot_source(arm);
    const std::string text = source.view.text();
    planner::UrdfOptions options = read_options(arm);
    options.other_arms = other_arms;
    const auto known = std::find_if(loaded_.begin(), loaded_.end(), [&](const Loaded& loaded) {
      return loaded.by_name == source.by_name && loaded.text == text && same(loaded.options, options);
    });
    if (known != loaded_.end()) return known->model;
    loaded_.push_back({source.by_name, text, options, source.load(arm, options)});
    return loaded_.back().model;
  }

 private:
  struct Loaded {
    bool by_name;
    std::string text;  ///< of the key `robot` or `urdf`
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

bool is_within(const planner::JointLimits& limits, const planner::JointVector& q) {
  return (q.array() >= limits.lower.array()).all() && (q.array() <= limits.upper.array()).all();
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
  // Poses of the robot come last, and only those within the cell file's narrower limits.
  for (const auto& [name, q] : arm.model->named) {
    if (is_within(arm.limits, q)) arm.named.try_emplace(name, q);
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

/// The arms that are chains of one URDF at one place.
class SharedRobots {
 public:
  explicit SharedRobots(const std::vector<ArmView>& arms) {
    for (const ArmView& arm : arms) {
      planner::UrdfOptions chain;
      read_chain(arm, chain);
      const RobotSource source = robot_source(arm);
      placed_.push_back({source.by_name, place_of(source), read_pose(arm.own, "base"), chain.tool_link});
    }
  }

  /// The first arm of the robot; −1: the arm is a robot of its own.
  [[nodiscard]] int robot_of(int arm) const {
    for (int other = 0; other < static_cast<int>(placed_.size()); ++other) {
      if (other != arm && is_same_robot(arm, other)) return std::min(arm, other);
    }
    return -1;
  }
  [[nodiscard]] std::vector<std::string> tools_of_others(int arm) const {
    std::vector<std::string> tools;
    for (int other = 0; other < static_cast<int>(placed_.size()); ++other) {
      if (other != arm && is_same_robot(arm, other)) tools.push_back(placed_[other].tool_link);
    }
    return tools;
  }

 private:
  /// Equal for all ways to write the path of a file.
  static std::string place_of(const RobotSource& source) {
    const std::string text = source.view.text();
    if (source.by_name) return text;
    std::error_code ignored;
    return std::filesystem::absolute(beside(source.view.file(), text), ignored).lexically_normal().string();
  }

  struct Placed {
    bool by_name;
    std::string place;  ///< the robot's name, or the path of its URDF
    planner::Pose X_WB;
    std::string tool_link;
  };
  [[nodiscard]] bool is_same_robot(int a, int b) const {
    const Placed& one = placed_[a];
    const Placed& two = placed_[b];
    return one.by_name == two.by_name && one.place == two.place && one.X_WB.matrix() == two.X_WB.matrix() &&
           !one.tool_link.empty() && !two.tool_link.empty() && one.tool_link != two.tool_link;
  }

  std::vector<Placed> placed_;
};

/// The last joint that the first arm moves and that carries the second one; empty: none.
std::string carrying_joint(const planner::RobotModel& carrier, const planner::RobotModel& carried) {
  for (int i = carried.tool_link; i >= 0; i = carried.links[i].parent) {
    const planner::Link& link = carried.links[i];
    const std::string& name = link.joint >= 0 ? carried.joint_names[link.joint] : link.joint_name;
    const auto& moved = carrier.joint_names;
    if (std::find(moved.begin(), moved.end(), name) != moved.end()) return name;
  }
  return {};
}

/// The link below the arm's joint of this name. A joint that carries no link of the arm has none: empty.
std::string link_below(const planner::RobotModel& model, const std::string& joint) {
  const auto found = std::find_if(model.links.begin(), model.links.end(), [&](const planner::Link& link) {
    return link.joint >= 0 && !link.follows && model.joint_names[static_cast<std::size_t>(link.joint)] == joint;
  });
  return found == model.links.end() ? std::string() : found->name;
}

/// Poses in the root link's frame of the links that no joint of the arm moves, by name.
std::map<std::string, planner::Pose> poses_of_fixed_links(const planner::RobotModel& model) {
  std::map<std::string, planner::Pose> poses;
  std::vector<std::optional<planner::Pose>> in_root;
  for (const planner::Link& link : model.links) {  // parents before children
    std::optional<planner::Pose> pose;
    if (link.parent < 0) {
      pose = planner::Pose::Identity();
    } else if (link.joint < 0 && in_root[static_cast<std::size_t>(link.parent)]) {
      pose = *in_root[static_cast<std::size_t>(link.parent)] * link.X_PJ;
    }
    in_root.push_back(pose);
    if (pose) poses[link.name] = *pose;
  }
  return poses;
}

/// The joint that holds a link where another arm of the robot does not have it; empty: none. A link
/// that is merged with another has lost its joint: positions of joints come first.
std::string joint_held_elsewhere(const planner::RobotModel& model, const planner::RobotModel& other) {
  for (const auto& [joint, position] : model.held) {
    const auto there = other.held.find(joint);
    if (there != other.held.end() && std::abs(there->second - position) > 1e-9) return joint;
  }
  const auto poses = poses_of_fixed_links(model);
  const auto others = poses_of_fixed_links(other);
  for (const planner::Link& link : model.links) {
    const auto one = poses.find(link.name);
    const auto two = others.find(link.name);
    const bool shared = one != poses.end() && two != others.end();
    if (shared && !one->second.matrix().isApprox(two->second.matrix(), 1e-9)) return link.joint_name;
  }
  return {};
}

/// Refuses arms of one robot that hold a joint of it, such as a lift below both, at different positions.
void check_held_joints(const std::vector<ArmView>& views, const std::vector<planner::PlannedArm>& arms) {
  for (std::size_t i = 0; i < arms.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!planner::same_robot(arms[i].arm, arms[j].arm)) continue;
      const std::string joint = joint_held_elsewhere(*arms[i].arm.model, *arms[j].arm.model);
      if (joint.empty()) continue;
      views[i].own.view().fail_with("arm " + arms[i].arm.name + " has joint " + joint +
                                    " at another position than arm " + arms[j].arm.name +
                                    " of the same robot; give both the same position with joints");
    }
  }
}

/// Refuses arms of one robot of which one lets a joint of the base move, such as that of a head, and the other does not
/// as far: it would not know where the links of that joint can be.
void check_shared_ranges(const std::vector<ArmView>& views, const std::vector<planner::PlannedArm>& arms) {
  const auto has = [](const planner::RobotModel& model, const planner::OutsideJoint& wanted) {
    if (!model.outside) return false;
    const auto& joints = model.outside->joints;
    return std::any_of(joints.begin(), joints.end(), [&](const planner::OutsideJoint& joint) {
      return joint.name == wanted.name && joint.range == wanted.range;
    });
  };
  for (std::size_t i = 0; i < arms.size(); ++i) {
    for (std::size_t j = 0; j < arms.size(); ++j) {
      if (i == j || !planner::same_robot(arms[i].arm, arms[j].arm) || !arms[i].arm.model->outside) continue;
      for (const planner::OutsideJoint& joint : arms[i].arm.model->outside->joints) {
        if (!joint.of_base || has(*arms[j].arm.model, joint)) continue;
        const std::string range = "[" + number_text(joint.range.lower) + ", " + number_text(joint.range.upper) + "]";
        views[j].own.view().fail_with("arm " + arms[i].arm.name + " of the same robot has joint " +
                                      printable(joint.name) + " within " + range + ", arm " + arms[j].arm.name +
                                      " has not; give both joints: {" + printable(joint.name) + ": " + range + "}");
      }
    }
  }
}

/// Refuses arms of one robot of which one moves the other.
void check_shared_joints(const std::vector<ArmView>& views, const std::vector<planner::PlannedArm>& arms) {
  for (std::size_t i = 0; i < arms.size(); ++i) {
    for (std::size_t j = 0; j < arms.size(); ++j) {
      if (i == j || !planner::same_robot(arms[i].arm, arms[j].arm)) continue;
      const planner::RobotModel& model = *arms[i].arm.model;
      const std::string joint = carrying_joint(model, *arms[j].arm.model);
      if (joint.empty()) continue;
      const std::string base = link_below(model, joint);
      views[i].own.view().fail_with(
          "joint " + printable(joint) + " of arm " + arms[i].arm.name + " moves arm " + arms[j].arm.name +
          ", too, which no arm may do; hold it with chain: [" + (base.empty() ? "a link below it" : printable(base)) +
          ", " + printable(model.links[static_cast<std::size_t>(model.tool_link)].name) + "] at arm " +
          arms[i].arm.name + ", and set its position with joints: {" + printable(joint) + ": 0} at both arms");
    }
  }
}

planner::PlannedArm read_arm(const ArmView& view, const planner::Timing& timing, const ArmSections& sections,
                             const std::vector<std::string>& other_arms, ArmModels& models) {
  planner::PlannedArm planned;
  planned.arm.name = view.own.at("name").name();
  planned.arm.model = models.load(view, other_arms);
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

/// True if the cell file has the pose, which wins over the robot's.
bool gives_pose(const ArmView& view, const std::string& name) {
  const auto has = [&](const MapView& map) {
    const auto poses = map.find("poses");
    return poses && poses->entry(name);
  };
  return has(view.own) || (view.defaults && has(*view.defaults));
}

/// Poses of an SRDF or the catalogue that are beyond the limits of the cell file.
void note_poses_outside(const ArmView& view, const planner::Arm& arm, std::vector<std::string>& notes) {
  for (const auto& [name, q] : arm.model->named) {
    if (gives_pose(view, name) || is_within(arm.limits, q)) continue;
    notes.push_back(view.own.view().path() + ".limits: pose " + printable(name) +
                    " of the robot is outside of them and left out; widen them, or give poses." + printable(name));
  }
}

void note_open_values(const ArmView& view, int index, const planner::Arm& arm, OpenValues& open) {
  if (!view.find("limits", section::kArmLimits, "acceleration") && !robot_source(view).by_name)
    open.acceleration.push_back(index);
  const auto of_robot = arm.model->named.find("home");
  const bool given =
      gives_pose(view, "home") || (of_robot != arm.model->named.end() && is_within(arm.limits, of_robot->second));
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
  std::vector<ArmView> arms;
  for (const YamlView& view : root.at("arms").items(1, kMostArms, "arms")) {
    arms.push_back({view.map(sections.arm()), defaults});
  }
  const SharedRobots robots(arms);
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    const ArmView& arm = arms[i];
    require_unique_name(arm.own.at("name"), file.cell.arms);
    file.cell.arms.push_back(read_arm(arm, file.cell.timing, sections, robots.tools_of_others(i), models));
    file.cell.arms.back().arm.shapes = shapes;
    file.cell.arms.back().arm.robot = robots.robot_of(i);
    note_open_values(arm, i, file.cell.arms.back().arm, open);
    note_poses_outside(arm, file.cell.arms.back().arm, file.notes);
    const std::string host = read_host(arm.own, "host", file.hosts);
    file.devices.push_back(read_device(arm));
    file.tools.push_back(read_tools(arm, *file.cell.arms.back().arm.model));
    file.robots.push_back(robot_files(arm));
    file.arm_hosts.push_back({host, read_standby_host(arm.own, "standby_host", file.hosts, host)});
  }
  check_shared_joints(arms, file.cell.arms);
  check_shared_ranges(arms, file.cell.arms);
  check_held_joints(arms, file.cell.arms);
  return open;
}

}  // namespace hecaton::config
