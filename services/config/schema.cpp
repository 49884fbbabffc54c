#include "services/config/schema.hpp"

#include <algorithm>
#include <array>

#include "planner/methods/registry.hpp"

namespace hecaton::config {
namespace {

using Words = std::string_view;

constexpr std::array kRootKeys = {Words("name"),     Words("network"),     Words("hosts"),    Words("world"),
                                  Words("geometry"), Words("supervision"), Words("timing"),   Words("tasks"),
                                  Words("defaults"), Words("arms"),        Words("obstacles")};
constexpr std::array kNetworkKeys = {Words("domain"), Words("transport"), Words("interface"), Words("discovery"),
                                     Words("peers")};
constexpr std::array kWorldKeys = {Words("host"), Words("floor_z"), Words("gravity")};
constexpr std::array kSupervisionKeys = {
    Words("host"),       Words("standby_host"),   Words("heartbeat_period"), Words("heartbeat_deadline"),
    Words("host_lease"), Words("takeover_lease"), Words("watchdog"),         Words("recovery")};
constexpr std::array kRecoveryKeys = {Words("driver_silent"), Words("world_silent"), Words("node_missing"),
                                      Words("node_silent"),   Words("process_died"), Words("node_failed"),
                                      Words("host_lost"),     Words("contact"),      Words("arm_failed")};
constexpr std::array kTimingKeys = {Words("control_period"), Words("driver_period"), Words("world_period"),
                                    Words("command_timeout"), Words("real_time")};
constexpr std::array kTaskKeys = {Words("pose_sequence"), Words("frame"),   Words("centre"),      Words("radius"),
                                  Words("half_height"),   Words("posture"), Words("conflicting"), Words("time_limit"),
                                  Words("clutter"),       Words("areas"),   Words("spread"),      Words("mean_wait")};
constexpr std::array kClutterKeys = {Words("count"), Words("smallest"), Words("largest"), Words("inner"),
                                     Words("outer"), Words("lowest"),   Words("highest")};
constexpr std::array kPoseKeys = {Words("xyz"), Words("rpy")};
constexpr std::array kArmKeys = {
    // What one arm alone can have first, then what `defaults` may say for all of them.
    Words("name"),
    Words("base"),
    Words("host"),
    Words("standby_host"),
    Words("urdf"),
    Words("srdf"),
    Words("packages"),
    Words("meshes"),
    Words("tool_link"),
    Words("tool"),
    Words("limits"),
    Words("poses"),
    Words("start"),
    Words("device"),
    Words("method"),
    Words("damper"),
    Words("yielding"),
    Words("rollout"),
    Words("replanning"),
    Words("coordination"),
    Words("goal_tolerance"),
    Words("acceleration_of_obstacles"),
    Words("state_age_limit"),
    Words("sensors")};
constexpr std::size_t kOwnArmKeys = 4;
constexpr std::array kArmLimitKeys = {Words("lower"), Words("upper"), Words("velocity"), Words("acceleration")};
constexpr std::array kDamperKeys = {Words("influence_distance"), Words("security_distance"), Words("convergence_speed"),
                                    Words("self_influence_distance"), Words("self_security_distance")};
constexpr std::array kYieldingKeys = {Words("yield_request_delay"), Words("at_rest")};
constexpr std::array kRolloutKeys = {Words("candidates"),      Words("horizon"),  Words("horizon_growth"),
                                     Words("longest_horizon"), Words("interval"), Words("ticks_per_period")};
constexpr std::array kReplanningKeys = {Words("stall_timeout")};
constexpr std::array kCoordinationKeys = {Words("stall_timeout")};
constexpr std::array kSensorKeys = {Words("name"),        Words("link"),         Words("position"), Words("direction"),
                                    Words("to_position"), Words("to_direction"), Words("rays"),     Words("range"),
                                    Words("noise"),       Words("period"),       Words("simulated")};
constexpr std::array kObstacleKeys = {Words("name"), Words("shapes"), Words("pose"), Words("motion"),
                                      Words("attached_to")};
constexpr std::array kAttachmentKeys = {Words("arm"), Words("pose")};
constexpr std::array kBoxKeys = {Words("type"), Words("pose"), Words("size")};
constexpr std::array kSphereKeys = {Words("type"), Words("pose"), Words("radius")};
constexpr std::array kCapsuleKeys = {Words("type"), Words("pose"), Words("radius"), Words("length")};
constexpr std::array kCylinderKeys = {Words("type"), Words("pose"), Words("radius"), Words("height")};
constexpr std::array kMeshKeys = {Words("type"), Words("pose"), Words("file"), Words("scale")};
constexpr std::array kStaticKeys = {Words("type")};
constexpr std::array kWaypointsKeys = {Words("type"), Words("poses"), Words("speed"), Words("loop")};
constexpr std::array kCircleKeys = {Words("type"), Words("centre"), Words("axis"), Words("angular_speed"),
                                    Words("turn_with_motion")};
constexpr std::array kSineKeys = {Words("type"), Words("direction"), Words("amplitude"), Words("period"),
                                  Words("phase")};
constexpr std::array kConveyorKeys = {Words("type"), Words("direction"), Words("speed"), Words("length")};
constexpr std::array kDynamicKeys = {Words("type"),
                                     Words("mass"),
                                     Words("friction"),
                                     Words("rolling_friction"),
                                     Words("restitution"),
                                     Words("linear_velocity"),
                                     Words("angular_velocity")};

}  // namespace

namespace section {
constexpr Section kRoot{"cell file", kRootKeys};
constexpr Section kNetwork{"network", kNetworkKeys};
constexpr Section kHosts{"hosts", {}, true};
constexpr Section kWorld{"world", kWorldKeys};
constexpr Section kSupervision{"supervision", kSupervisionKeys};
constexpr Section kRecovery{"supervision.recovery", kRecoveryKeys};
constexpr Section kTiming{"timing", kTimingKeys};
constexpr Section kTasks{"tasks", kTaskKeys};
constexpr Section kTaskAreas{"tasks.areas", {}, true};
constexpr Section kClutter{"tasks.clutter", kClutterKeys};
constexpr Section kPose{"pose", kPoseKeys};
constexpr Section kArmLimits{"arms[].limits", kArmLimitKeys};
constexpr Section kArmPoses{"arms[].poses", {}, true};
constexpr Section kPackages{"arms[].packages", {}, true};
constexpr Section kDevice{"arms[].device", {}, true};
constexpr Section kDamper{"arms[].damper", kDamperKeys};
constexpr Section kYielding{"arms[].yielding", kYieldingKeys};
constexpr Section kRollout{"arms[].rollout", kRolloutKeys};
constexpr Section kReplanning{"arms[].replanning", kReplanningKeys};
constexpr Section kCoordination{"arms[].coordination", kCoordinationKeys};
constexpr Section kSensor{"arms[].sensors[]", kSensorKeys};
constexpr Section kObstacle{"obstacles[]", kObstacleKeys};
constexpr Section kAttachment{"obstacles[].attached_to", kAttachmentKeys};
constexpr Section kBox{"obstacles[].shapes[] of type box", kBoxKeys};
constexpr Section kSphere{"obstacles[].shapes[] of type sphere", kSphereKeys};
constexpr Section kCapsule{"obstacles[].shapes[] of type capsule", kCapsuleKeys};
constexpr Section kCylinder{"obstacles[].shapes[] of type cylinder", kCylinderKeys};
constexpr Section kMesh{"obstacles[].shapes[] of type mesh", kMeshKeys};
constexpr Section kStatic{"obstacles[].motion of type static", kStaticKeys};
constexpr Section kWaypoints{"obstacles[].motion of type waypoints", kWaypointsKeys};
constexpr Section kCircle{"obstacles[].motion of type circle", kCircleKeys};
constexpr Section kSine{"obstacles[].motion of type sine", kSineKeys};
constexpr Section kConveyor{"obstacles[].motion of type conveyor", kConveyorKeys};
constexpr Section kDynamic{"obstacles[].motion of type dynamic", kDynamicKeys};
}  // namespace section

ArmSections::ArmSections(const planner::MethodRegistry& registry) : registry_(registry) {
  struct Collector : planner::ParameterVisitor {
    std::deque<Keys>* found;
    Keys* open = nullptr;

    void section(std::string_view name) override {
      const auto same = [&](const Keys& keys) { return keys.name == name; };
      const auto known = std::find_if(found->begin(), found->end(), same);
      open = known == found->end() ? &found->emplace_back(std::string(name)) : &*known;
    }
    void key(std::string_view name) override {
      if (std::find(open->keys.begin(), open->keys.end(), name) == open->keys.end()) open->keys.push_back(name);
    }
  } collector;
  collector.found = &of_methods_;
  for (const auto& method : registry.make_all()) method->visit_parameters(collector);
  keys_.assign(kArmKeys.begin(), kArmKeys.end());
  for (Keys& keys : of_methods_) {
    keys.section = {keys.where, keys.keys};
    keys_.push_back(keys.name);
  }
  arm_ = {"arms[]", keys_};
  defaults_ = {"defaults", std::span<const std::string_view>(keys_).subspan(kOwnArmKeys)};
}

const Section& ArmSections::of_method(std::string_view name) const {
  return std::find_if(of_methods_.begin(), of_methods_.end(), [&](const Keys& keys) { return keys.name == name; })
      ->section;
}

std::vector<const Section*> ArmSections::all() const {
  std::vector<const Section*> sections{&arm_, &defaults_};
  for (const Keys& keys : of_methods_) sections.push_back(&keys.section);
  return sections;
}

std::vector<const Section*> all_sections() {
  using namespace section;
  static const ArmSections of_arms(planner::built_in_methods());
  std::vector<const Section*> all = {&kRoot,       &kNetwork,      &kHosts,     &kWorld,    &kSupervision, &kRecovery,
                                     &kTiming,     &kTasks,        &kTaskAreas, &kClutter,  &kPose,        &kArmLimits,
                                     &kArmPoses,   &kPackages,     &kDevice,    &kDamper,   &kYielding,    &kRollout,
                                     &kReplanning, &kCoordination, &kSensor,    &kObstacle, &kAttachment,  &kBox,
                                     &kSphere,     &kCapsule,      &kCylinder,  &kMesh,     &kStatic,      &kWaypoints,
                                     &kCircle,     &kSine,         &kConveyor,  &kDynamic};
  const auto of_methods = of_arms.all();
  all.insert(all.end(), of_methods.begin(), of_methods.end());
  return all;
}

}  // namespace hecaton::config
