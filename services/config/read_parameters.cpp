#include "services/config/read_parameters.hpp"

#include <algorithm>

#include "planner/methods/registry.hpp"
#include "services/config/config_error.hpp"
#include "services/config/fields.hpp"
#include "services/config/yaml_tree.hpp"

namespace hecaton::config {
namespace {

constexpr Bounds kDistance{0.0, 10.0, "m", true};

void read_damper(const MapView& map, planner::DamperParameters& damper) {
  read_number(map, "influence_distance", kDistance, damper.influence_distance);
  read_number(map, "security_distance", kDistance, damper.security_distance);
  read_number(map, "convergence_speed", {0.0, 100.0, "m/s", true}, damper.convergence_speed);
  read_number(map, "self_influence_distance", kDistance, damper.self_influence_distance);
  read_number(map, "self_security_distance", kDistance, damper.self_security_distance);
}

void read_yielding(const MapView& map, planner::YieldingParameters& yielding) {
  read_seconds(map, "yield_request_delay", {0.0, 3600.0, "s"}, yielding.yield_request_delay);
  read_boolean(map, "at_rest", yielding.at_rest);
}

void read_rollout(const MapView& map, planner::RolloutParameters& rollout) {
  if (const auto count = map.find("candidates")) rollout.candidates = count->integer(0, 1000);
  read_seconds(map, "horizon", {0.0, 60.0, "s", true}, rollout.horizon);
  read_number(map, "horizon_growth", {1.0, 100.0, ""}, rollout.horizon_growth);
  read_seconds(map, "longest_horizon", {0.0, 60.0, "s", true}, rollout.longest_horizon);
  read_seconds(map, "interval", {0.0, 60.0, "s", true}, rollout.interval);
  if (const auto ticks = map.find("ticks_per_period")) rollout.ticks_per_period = ticks->integer(1, 1'000'000);
}

void read_replanning(const MapView& map, planner::ReplanningParameters& replanning) {
  read_seconds(map, "stall_timeout", {0.0, 3600.0, "s"}, replanning.stall_timeout);
}

void read_coordination(const MapView& map, planner::CoordinationParameters& coordination) {
  read_seconds(map, "stall_timeout", {0.0, 3600.0, "s"}, coordination.stall_timeout);
}

Bounds bounds(const planner::ParameterRange& range) {
  return {range.low, range.high, range.unit, range.low_open};
}

/// Sets what one map of the cell file says: an arm's, `defaults`, or an arm's section of a file of its own.
class ParameterReader final : public planner::ParameterVisitor {
 public:
  /// Of the sections in `arm`.
  ParameterReader(const MapView& arm, const ArmSections& sections) : arm_(&arm), sections_(&sections) {}
  /// Of the section `name` alone, which is `keys`.
  ParameterReader(std::string_view name, const MapView& keys) : only_(name), only_keys_(keys) {}

  void section(std::string_view name) override {
    section_ = name;
    keys_.reset();
    if (only_keys_) {
      if (name == only_) keys_ = only_keys_;
    } else if (const auto view = arm_->find(name)) {
      keys_ = view->map(sections_->of_method(name));
    }
  }
  void number(std::string_view name, double& value, const planner::ParameterRange& range) override {
    if (keys_) read_number(*keys_, name, bounds(range), value);
  }
  void seconds(std::string_view name, double& value, const planner::ParameterRange& range) override {
    if (keys_) read_seconds(*keys_, name, bounds(range), value);
  }
  void integer(std::string_view name, int& value, int low, int high) override {
    if (const auto view = find(name)) value = view->integer(low, high);
  }
  void word(std::string_view name, std::span<const std::string_view> words, std::size_t& index) override {
    if (const auto view = find(name)) index = view->choice(words);
  }
  void numbers(std::string_view name, std::span<double> values, int& count,
               const planner::ParameterRange& range) override {
    const auto view = find(name);
    if (!view) return;
    count = 0;
    std::fill(values.begin(), values.end(), 0.0);
    for (const YamlView& item : view->items(0, values.size(), "numbers")) values[count++] = item.number(bounds(range));
  }
  void file(std::string_view name, std::initializer_list<std::string_view> said_there) override {
    const auto given = find(name);
    if (!given) return;
    if (only_keys_) given->fail("left out: this is such a file itself");
    for (const std::string_view key : said_there) {
      if (const auto twice = keys_->find(key)) {
        twice->fail("left out, because " + std::string(section_) + "." + std::string(name) + " says it");
      }
    }
  }

 private:
  [[nodiscard]] std::optional<YamlView> find(std::string_view name) const {
    return keys_ ? keys_->find(name) : std::nullopt;
  }

  const MapView* arm_ = nullptr;
  const ArmSections* sections_ = nullptr;
  std::string_view only_;
  std::optional<MapView> only_keys_;
  std::string_view section_;
  std::optional<MapView> keys_;  ///< of the open section, if the file has it
};

/// Reads the files that sections name: the arm's own file, or else the default one, unless the arm itself says what is
/// in it.
class FileReader final : public planner::ParameterVisitor {
 public:
  FileReader(const ArmView& view, const ArmSections& sections, planner::MotionMethod& method)
      : view_(view), sections_(sections), method_(method) {}

  void section(std::string_view name) override { section_ = name; }
  void file(std::string_view name, std::initializer_list<std::string_view> said_there) override {
    if (!read_of(view_.own, name, said_there) && view_.defaults) read_of(*view_.defaults, name, said_there);
  }

 private:
  bool read_of(const MapView& arm, std::string_view name, std::initializer_list<std::string_view> said_there) {
    const auto section = arm.find(section_);
    if (!section) return false;
    const MapView keys = section->map(sections_.of_method(section_));
    if (const auto given = keys.find(name)) {
      read_file(*given, *said_there.begin());
      return true;
    }
    return keys.find(*said_there.begin()).has_value();
  }

  void read_file(const YamlView& file, std::string_view needed) {
    const std::string path = beside(file.file(), file.text());
    const YamlNode tree = read_yaml_file(path, file.sources());
    const YamlSource source{path, file.sources()};
    const YamlView root(tree, source, "");
    const std::string arm = view_.own.at("name").name();
    for (const auto& [name, view] : root.named_items(128)) {
      if (name != arm) continue;
      const MapView keys = view.map(sections_.of_method(section_));
      static_cast<void>(keys.at(needed));
      ParameterReader reader(section_, keys);
      method_.visit_parameters(reader);
      return;
    }
    root.fail_with("there is no " + std::string(section_) + " for arm " + arm);
  }

  const ArmView& view_;
  const ArmSections& sections_;
  planner::MotionMethod& method_;
  std::string_view section_;
};

}  // namespace

planner::MethodSet read_methods(const ArmView& view, const ArmSections& sections) {
  planner::MethodSet methods;
  for (const auto& method : sections.registry().make_all()) {
    for (const MapView* map : {view.defaults ? &*view.defaults : nullptr, &view.own}) {
      if (map == nullptr) continue;
      ParameterReader reader(*map, sections);
      method->visit_parameters(reader);
    }
    FileReader files(view, sections, *method);
    method->visit_parameters(files);
    if (const auto complaint = method->validate()) {
      throw ConfigError(view.own.view().file() + ": " + view.own.view().path() + "." + *complaint);
    }
    methods.push_back(method);
  }
  return methods;
}

std::string_view read_method_name(const ArmView& view, const ArmSections& sections) {
  const auto given = view.find("method");
  if (!given) return planner::default_method()->traits().name;
  const std::vector<std::string_view> names = sections.registry().names();
  return names[given->choice(names)];
}

void read_parameters(const MapView& map, planner::LocalParameters& parameters) {
  if (const auto damper = map.find("damper")) read_damper(damper->map(section::kDamper), parameters.damper);
  if (const auto yielding = map.find("yielding")) read_yielding(yielding->map(section::kYielding), parameters.yielding);
  if (const auto rollout = map.find("rollout")) read_rollout(rollout->map(section::kRollout), parameters.rollout);
  if (const auto replanning = map.find("replanning")) {
    read_replanning(replanning->map(section::kReplanning), parameters.replanning);
  }
  if (const auto coordination = map.find("coordination")) {
    read_coordination(coordination->map(section::kCoordination), parameters.coordination);
  }
  read_number(map, "goal_tolerance", {0.0, 0.1, "rad (m for a prismatic joint)", true}, parameters.goal_tolerance);
  read_number(map, "acceleration_of_obstacles", {0.0, 100.0, "m/s²", true}, parameters.acceleration_of_obstacles);
  read_seconds(map, "state_age_limit", {0.001, 10.0, "s"}, parameters.state_age_limit);
}

}  // namespace hecaton::config
