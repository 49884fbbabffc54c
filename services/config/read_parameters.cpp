#include <algorithm>

#include "planner/local/default_damper.hpp"
#include "planner/methods/registry.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/config/readers.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

Bounds bounds(const planner::ParameterRange& range) {
  return {range.low, range.high, range.unit, range.low_open};
}

/// Sets parameters from one map of the cell file (an arm or `defaults`), or from an arm's section in a separate file.
class ParameterReader final : public planner::ParameterVisitor {
 public:
  /// Reads the sections in `arm`.
  ParameterReader(const MapView& arm, const ArmSections& sections) : arm_(&arm), sections_(&sections) {}
  /// Reads the section `name` only, whose map is `keys`.
  ParameterReader(std::string_view name, const MapView& keys) : only_(name), only_keys_(keys) {}

  void section(std::string_view name) override {
    section_ = name;
    keys_.reset();
    if (only_keys_) {
      if (name == only_) keys_ = only_keys_;
    } else if (const auto view = arm_->find(name)) {
      keys_ = view->map(sections_->parameters(name));
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
  void boolean(std::string_view name, bool& value) override {
    if (keys_) read_boolean(*keys_, name, value);
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

/// Reads the files that sections name: the arm's own file, else the default one, unless the arm gives their keys
/// itself.
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
    const MapView keys = section->map(sections_.parameters(section_));
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
      const MapView keys = view.map(sections_.parameters(section_));
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

namespace {

planner::DamperParameters read_damper(const ArmView& view, const ArmSections& sections, const planner::Arm& arm,
                                      const planner::Timing& timing) {
  const auto given = [&](std::string_view key) -> std::optional<double> {
    const auto number = view.find("damper", sections.parameters("damper"), key);
    // The bounds are those of visit_parameters(), which also reads the value.
    return number ? std::optional(number->number({0.0, 100.0, "", true})) : std::nullopt;
  };
  const planner::DamperBasis basis{planner::arm_reach(arm).tool, planner::longest_stop_time(arm.limits),
                                   timing.control_period, timing.world_period + timing.control_period};
  return planner::default_damper(basis,
                                 {given("influence_distance"), given("security_distance"), given("convergence_speed"),
                                  given("self_influence_distance"), given("self_security_distance")});
}

}  // namespace

planner::LocalParameters read_parameters(const ArmView& view, const ArmSections& sections, const planner::Arm& arm,
                                         const planner::Timing& timing) {
  planner::LocalParameters parameters;
  for (const MapView* map : {view.defaults ? &*view.defaults : nullptr, &view.own}) {
    if (map == nullptr) continue;
    ParameterReader reader(*map, sections);
    visit_parameters(parameters, reader);
    read_number(*map, "goal_tolerance", {0.0, 0.1, "rad (m for a prismatic joint)", true}, parameters.goal_tolerance);
    read_number(*map, "acceleration_of_obstacles", {0.0, 100.0, "m/s²", true}, parameters.acceleration_of_obstacles);
    read_seconds(*map, "state_age_limit", {0.001, 10.0, "s"}, parameters.state_age_limit);
  }
  parameters.damper = read_damper(view, sections, arm, timing);
  if (const auto complaint = parameters.validate()) {
    throw ConfigError(view.own.view().file() + ": " + view.own.view().path() + "." + *complaint);
  }
  const auto require = [&](const char* key, double period) {
    if (parameters.state_age_limit >= 2.0 * period) return;
    view.own.fail("state_age_limit", milliseconds_text(parameters.state_age_limit),
                  std::string("at least twice timing.") + key + " = " + milliseconds_text(period));
  };
  require("control_period", timing.control_period);
  require("world_period", timing.world_period);
  return parameters;
}

}  // namespace hecaton::config
