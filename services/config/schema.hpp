#pragma once
/// Every key that a cell file may have, section by section. Readers can only ask for keys that are listed here, and
/// docs/reference/cell-file.md documents each of them.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hecaton::planner {
class MethodRegistry;
class ParameterVisitor;
struct LocalParameters;
}  // namespace hecaton::planner

namespace hecaton::config {

struct ShapeType;

/// One kind of map in a cell file.
struct Section {
  std::string where;  ///< its key path, with "[]" for any item of a list
  std::vector<std::string_view> keys;
  bool free_names = false;  ///< the user chooses the keys; `keys` is empty
};

namespace section {
inline const Section kRoot{"cell file",
                           {"name", "network", "security", "hosts", "world", "geometry", "supervision", "view",
                            "record", "ros2", "timing", "tasks", "defaults", "arms", "obstacles"}};
inline const Section kNetwork{"network", {"domain", "transport", "interface", "discovery", "peers", "lease"}};
inline const Section kSecurity{"security", {"keystore"}};
inline const Section kHosts{"hosts", {}, true};
inline const Section kWorld{"world", {"host", "floor_z", "gravity"}};
inline const Section kSupervision{"supervision",
                                  {"host", "standby_host", "heartbeat_period", "heartbeat_deadline", "host_lease",
                                   "failover_timeout", "watchdog", "memory_limit", "recovery"}};
inline const Section kRecovery{
    "supervision.recovery",
    {"driver_silent", "world_silent", "node_missing", "node_silent", "process_died", "node_failed", "host_lost",
     "contact", "device_not_ready", "remote_control_off", "program_stopped", "safeguard_stop", "protective_stop",
     "emergency_stop", "arm_failed"}};
inline const Section kView{"view", {"host", "listen", "port", "control", "no_stop", "certificate", "key"}};
inline const Section kRecord{"record",
                             {"folder", "host", "keep", "after_fault", "limit", "split_size", "split_time", "ros2"}};
inline const Section kTiming{"timing",
                             {"control_period", "driver_period", "world_period", "command_timeout", "real_time"}};
inline const Section kTasks{"tasks",
                            {"pose_sequence", "frame", "centre", "radius", "half_height", "posture", "conflicting",
                             "time_limit", "clutter", "areas", "spread", "mean_wait"}};
inline const Section kTaskAreas{"tasks.areas", {}, true};
inline const Section kClutter{"tasks.clutter", {"count", "smallest", "largest", "inner", "outer", "lowest", "highest"}};
inline const Section kRos2{
    "ros2", {"domain", "distribution", "namespace", "host", "interface", "period", "control", "enclave"}};
inline const Section kPose{"pose", {"xyz", "rpy"}};
inline const Section kArmLimits{"arms[].limits", {"lower", "upper", "velocity", "acceleration"}};
inline const Section kArmPoses{"arms[].poses", {}, true};
inline const Section kPackages{"arms[].packages", {}, true};
inline const Section kHeldJoints{"arms[].joints", {}, true};
inline const Section kXacro{"arms[].xacro", {}, true};
inline const Section kDevice{"arms[].device", {}, true};
inline const Section kSignals{"arms[].signals", {}, true};
inline const Section kGripper{"arms[].gripper",
                              {"joint", "closed", "opened", "width", "speed", "close", "open", "time"}};
inline const Section kSensor{"arms[].sensors[]",
                             {"name", "link", "position", "direction", "to_position", "to_direction", "rays", "range",
                              "noise", "period", "simulated"}};
inline const Section kObstacle{"obstacles[]", {"name", "shapes", "pose", "motion", "attached_to"}};
inline const Section kAttachment{"obstacles[].attached_to", {"arm", "pose"}};
inline const Section kBox{"obstacles[].shapes[] of type box", {"type", "pose", "size"}};
inline const Section kMesh{"obstacles[].shapes[] of type mesh", {"type", "pose", "file", "scale"}};
inline const Section kPoints{"obstacles[].shapes[] of type points", {"type", "pose", "file", "radius"}};
inline const Section kStatic{"obstacles[].motion of type static", {"type"}};
inline const Section kWaypoints{"obstacles[].motion of type waypoints", {"type", "poses", "speed", "loop"}};
inline const Section kCircle{"obstacles[].motion of type circle",
                             {"type", "centre", "axis", "angular_speed", "turn_with_motion"}};
inline const Section kSine{"obstacles[].motion of type sine", {"type", "direction", "amplitude", "period", "phase"}};
inline const Section kConveyor{"obstacles[].motion of type conveyor", {"type", "direction", "speed", "length"}};
inline const Section kDynamic{
    "obstacles[].motion of type dynamic",
    {"type", "mass", "friction", "rolling_friction", "restitution", "linear_velocity", "angular_velocity"}};
}  // namespace section

/// Shows `visitor` the sections and keys of an arm's local planner, as MotionMethod::visit_parameters does for a
/// method.
void visit_parameters(planner::LocalParameters& parameters, planner::ParameterVisitor& visitor);

/// The sections `arms[]` and `defaults`, and those below them that parameter visitors define: of the local planner and
/// of the registry's motion methods.
class ArmSections {
 public:
  /// The registry must outlive this.
  explicit ArmSections(const planner::MethodRegistry& registry);

  [[nodiscard]] const planner::MethodRegistry& registry() const { return registry_; }
  [[nodiscard]] const Section& arm() const { return arm_; }
  [[nodiscard]] const Section& defaults() const { return defaults_; }
  /// The section at the key `name` of an arm, which must exist.
  [[nodiscard]] const Section& parameters(std::string_view name) const;
  [[nodiscard]] std::vector<const Section*> all() const;

 private:
  const planner::MethodRegistry& registry_;
  std::vector<std::pair<std::string_view, Section>> parameters_;  ///< by key of the arm
  Section arm_;
  Section defaults_;
};

/// The sections of `obstacles[].shapes[]`: of box, of the types given by their sizes, of mesh, and of points.
class ShapeSections {
 public:
  /// The types must outlive this. Throws std::invalid_argument if two have the same name.
  explicit ShapeSections(const std::vector<ShapeType>& types);

  /// The values of `type`, in the order of all().
  [[nodiscard]] const std::vector<std::string_view>& names() const { return names_; }
  [[nodiscard]] const std::vector<Section>& all() const { return sections_; }
  /// Null for box, mesh and points.
  [[nodiscard]] const ShapeType* type(std::size_t index) const { return types_[index]; }

 private:
  void add(std::string_view name, const Section& section, const ShapeType* type);

  std::vector<std::string_view> names_;
  std::vector<Section> sections_;
  std::vector<const ShapeType*> types_;
};

/// All sections, with the parameters of Hecaton's own motion methods and its own shapes.
[[nodiscard]] std::vector<const Section*> all_sections();

}  // namespace hecaton::config
