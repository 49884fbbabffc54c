#include "services/config/schema.hpp"

#include <algorithm>
#include <stdexcept>

#include "planner/local/parameters.hpp"
#include "planner/methods/registry.hpp"
#include "services/config/shape_types.hpp"

namespace hecaton::config {

void visit_parameters(planner::LocalParameters& parameters, planner::ParameterVisitor& visitor) {
  const planner::ParameterRange distance{0.0, 10.0, "m", true};
  const planner::ParameterRange delay{0.0, 3600.0, "s"};
  const planner::ParameterRange minute{0.0, 60.0, "s", true};
  visitor.section("damper");
  visitor.number("influence_distance", parameters.damper.influence_distance, distance);
  visitor.number("security_distance", parameters.damper.security_distance, distance);
  visitor.number("convergence_speed", parameters.damper.convergence_speed, {0.0, 100.0, "m/s", true});
  visitor.number("self_influence_distance", parameters.damper.self_influence_distance, distance);
  visitor.number("self_security_distance", parameters.damper.self_security_distance, distance);
  visitor.section("yielding");
  visitor.seconds("yield_request_delay", parameters.yielding.yield_request_delay, delay);
  visitor.boolean("at_rest", parameters.yielding.at_rest);
  visitor.section("rollout");
  visitor.integer("candidates", parameters.rollout.candidates, 0, 1000);
  visitor.seconds("horizon", parameters.rollout.horizon, minute);
  visitor.number("horizon_growth", parameters.rollout.horizon_growth, {1.0, 100.0, ""});
  visitor.seconds("longest_horizon", parameters.rollout.longest_horizon, minute);
  visitor.seconds("interval", parameters.rollout.interval, minute);
  visitor.integer("ticks_per_period", parameters.rollout.ticks_per_period, 1, 1'000'000);
  visitor.section("replanning");
  visitor.seconds("stall_timeout", parameters.replanning.stall_timeout, delay);
  visitor.section("coordination");
  visitor.seconds("stall_timeout", parameters.coordination.stall_timeout, delay);
}

ArmSections::ArmSections(const planner::MethodRegistry& registry) : registry_(registry) {
  struct Collector : planner::ParameterVisitor {
    std::vector<std::pair<std::string_view, Section>> found;
    std::size_t open = 0;

    void section(std::string_view name) override {
      const auto known =
          std::find_if(found.begin(), found.end(), [&](const auto& entry) { return entry.first == name; });
      open = static_cast<std::size_t>(known - found.begin());
      if (known == found.end()) found.push_back({name, {"arms[]." + std::string(name), {}}});
    }
    void key(std::string_view name) override {
      auto& keys = found[open].second.keys;
      if (std::find(keys.begin(), keys.end(), name) == keys.end()) keys.push_back(name);
    }
  } collector;
  planner::LocalParameters local;
  visit_parameters(local, collector);
  for (const auto& method : registry.make_all()) method->visit_parameters(collector);
  parameters_ = std::move(collector.found);

  arm_ = {"arms[]", {"name", "base", "host", "standby_host"}};
  defaults_ = {"defaults",
               {"robot",
                "urdf",
                "xacro",
                "srdf",
                "packages",
                "meshes",
                "allow_bare_links",
                "chain",
                "tool_link",
                "tool",
                "joints",
                "limits",
                "poses",
                "start",
                "device",
                "signals",
                "gripper",
                "method",
                "goal_tolerance",
                "acceleration_of_obstacles",
                "state_age_limit",
                "sensors"}};
  for (const auto& [name, section] : parameters_) defaults_.keys.push_back(name);
  arm_.keys.insert(arm_.keys.end(), defaults_.keys.begin(), defaults_.keys.end());
}

const Section& ArmSections::parameters(std::string_view name) const {
  return std::find_if(parameters_.begin(), parameters_.end(), [&](const auto& entry) { return entry.first == name; })
      ->second;
}

std::vector<const Section*> ArmSections::all() const {
  std::vector<const Section*> sections{&arm_, &defaults_};
  for (const auto& [name, section] : parameters_) sections.push_back(&section);
  return sections;
}

ShapeSections::ShapeSections(const std::vector<ShapeType>& types) {
  add("box", section::kBox, nullptr);
  for (const ShapeType& type : types) {
    Section section{"obstacles[].shapes[] of type " + std::string(type.name), {"type", "pose"}};
    for (const ShapeSize& size : type.sizes) section.keys.push_back(size.key);
    add(type.name, section, &type);
  }
  add("mesh", section::kMesh, nullptr);
  add("points", section::kPoints, nullptr);
}

void ShapeSections::add(std::string_view name, const Section& section, const ShapeType* type) {
  if (std::find(names_.begin(), names_.end(), name) != names_.end()) {
    throw std::invalid_argument("there are two types of shapes named " + std::string(name));
  }
  names_.push_back(name);
  sections_.push_back(section);
  types_.push_back(type);
}

std::vector<const Section*> all_sections() {
  using namespace section;
  static const ShapeSections of_shapes(shape_types());
  static const ArmSections of_arms(planner::built_in_methods());
  std::vector<const Section*> all = {
      &kRoot,     &kNetwork,    &kSecurity,   &kHosts,     &kWorld,     &kSupervision, &kRecovery, &kView,
      &kRecord,   &kRos2,       &kTiming,     &kTasks,     &kTaskAreas, &kClutter,     &kPose,     &kArmLimits,
      &kArmPoses, &kPackages,   &kHeldJoints, &kXacro,     &kDevice,    &kSignals,     &kGripper,  &kSensor,
      &kObstacle, &kAttachment, &kStatic,     &kWaypoints, &kCircle,    &kSine,        &kConveyor, &kDynamic};
  for (const Section& section : of_shapes.all()) all.push_back(&section);
  const auto arms = of_arms.all();
  all.insert(all.end(), arms.begin(), arms.end());
  return all;
}

}  // namespace hecaton::config
