#pragma once
/// The readers of a cell file's sections, for cell_file.cpp. All throw ConfigError.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planner/cell.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/model/robot_model.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

/// `network`.
[[nodiscard]] Network read_network(const MapView& root);
/// `security.keystore`, beside the cell file; empty without the section.
[[nodiscard]] std::string read_keystore(const MapView& root);
/// `hosts`; without the section one host "localhost".
[[nodiscard]] std::vector<Host> read_hosts(const MapView& root);
/// `supervision`.
[[nodiscard]] Supervision read_supervision(const MapView& root, const std::vector<Host>& hosts);

/// `view`; empty without the section.
[[nodiscard]] std::optional<View> read_view(const MapView& root, const std::vector<Host>& hosts);
[[nodiscard]] std::optional<Record> read_record(const MapView& root, const std::vector<Host>& hosts);
/// `ros2`; empty without the section.
[[nodiscard]] std::optional<Ros2> read_ros2(const MapView& root, const std::vector<Host>& hosts);

/// The declared host at `key`. Without the key: the only declared host; an error when there are several.
[[nodiscard]] std::string read_host(const MapView& map, std::string_view key, const std::vector<Host>& hosts);
/// The declared host at `key`, which must differ from `active`; empty without the key.
[[nodiscard]] std::string read_standby_host(const MapView& map, std::string_view key, const std::vector<Host>& hosts,
                                            const std::string& active);

/// Indices of the arms for which the file leaves something open.
struct OpenValues {
  std::vector<int> home;          ///< without a pose "home": it is a compact posture for now
  std::vector<int> acceleration;  ///< without limits.acceleration
};

/// `defaults` and `arms`: loads models, tightens limits, checks poses. Appends to cell.arms, arm_hosts, devices and
/// tools of `file`; hosts and timing must be there already. `methods`: the allowed values of `method`.
[[nodiscard]] OpenValues read_arms(const MapView& root, const planner::MethodRegistry& methods, CellFile& file);

/// `world` and `obstacles`. Attachments must name one of `arms`.
[[nodiscard]] world::Scene read_scene(const MapView& root, std::span<const planner::PlannedArm> arms,
                                      const ShapeSections& shapes);

/// The map of an arm with the `defaults` behind it.
struct ArmView {
  MapView own;
  std::optional<MapView> defaults;

  /// The arm's own value, else the default one.
  [[nodiscard]] std::optional<YamlView> find(std::string_view key) const {
    if (auto view = own.find(key)) return view;
    return defaults ? defaults->find(key) : std::nullopt;
  }
  /// The same; a key in neither is an error.
  [[nodiscard]] YamlView at(std::string_view key) const {
    const auto view = find(key);
    return view ? *view : own.at(key);
  }
  /// The same for the key `inner` of the map at `key`: an arm may override a single entry of a map.
  [[nodiscard]] std::optional<YamlView> find(std::string_view key, const Section& section,
                                             std::string_view inner) const {
    for (const MapView* map : {&own, defaults ? &*defaults : nullptr}) {
      if (map == nullptr) continue;
      const auto section_map = map->find(key);
      if (!section_map) continue;
      if (auto view = section_map->map(section).find(inner)) return view;
    }
    return std::nullopt;
  }
};

/// `signals` and `gripper` of an arm.
[[nodiscard]] ToolOptions read_tools(const ArmView& arm, const planner::RobotModel& model);

/// The URDF's limits, tightened by the arm's `limits`.
[[nodiscard]] planner::JointLimits read_limits(const ArmView& arm, const planner::RobotModel& model);
/// One position per joint, each within `limits`.
[[nodiscard]] planner::JointVector read_configuration(const YamlView& view, const planner::RobotModel& model,
                                                      const planner::JointLimits& limits);

/// The parameters of the local planner of `arm`, whose model, base and limits are there already. Missing damper
/// parameters follow from them. Checks all parameters against `timing`, too.
[[nodiscard]] planner::LocalParameters read_parameters(const ArmView& view, const ArmSections& sections,
                                                       const planner::Arm& arm, const planner::Timing& timing);
/// Every method of the registry with the arm's parameters, which it also checks together. A section may name a file
/// that has the parameters for each arm.
[[nodiscard]] planner::MethodSet read_methods(const ArmView& view, const ArmSections& sections);
/// The name of the arm's method: one of the registry's.
[[nodiscard]] std::string_view read_method_name(const ArmView& view, const ArmSections& sections);

}  // namespace hecaton::config
