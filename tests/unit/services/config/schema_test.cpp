// docs/reference/cell-file.md documents exactly the keys that the reader knows. (The reader cannot ask for a key that
// the schema does not list: MapView throws.)

#include "services/config/schema.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <variant>

#include <gtest/gtest.h>

#include "planner/local/parameters.hpp"
#include "planner/methods/registry.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::config {
namespace {

using Sections = std::map<std::string, std::set<std::string>>;

// "## `network`" opens a section, "| `domain` | …" documents a key of it.
Sections documented() {
  Sections sections;
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/reference/cell-file.md");
  std::set<std::string>* keys = nullptr;
  const auto between_ticks = [](const std::string& line, std::size_t from) {
    return line.substr(from, line.find('`', from) - from);
  };
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) keys = nullptr;
    if (line.starts_with("## `")) keys = &sections[between_ticks(line, 4)];
    if (line.starts_with("| `") && keys != nullptr) {
      EXPECT_TRUE(keys->insert(between_ticks(line, 3)).second) << "twice: " << line;
    }
  }
  // "## `obstacles[].motion`" has what "## `obstacles[].motion of type sine`" shares with the other types.
  std::set<std::string> common;
  for (auto& [where, own] : sections) {
    const std::string above = where.substr(0, where.find(" of type "));
    if (above == where || !sections.contains(above)) continue;
    common.insert(above);
    for (const std::string& key : sections.at(above))
      EXPECT_TRUE(own.insert(key).second) << "twice: " << where << ' ' << key;
  }
  for (const std::string& where : common) sections.erase(where);
  return sections;
}

Sections known() {
  Sections sections;
  for (const Section* section : all_sections()) {
    auto& keys = sections[std::string(section->where)];
    for (const std::string_view key : section->keys) keys.emplace(key);
  }
  return sections;
}

TEST(SchemaTest, ReferenceListsExactlyTheKeys) {
  const Sections in_reference = documented();
  const Sections in_reader = known();
  for (const auto& [where, keys] : in_reader) {
    ASSERT_TRUE(in_reference.contains(where)) << "no heading for " << where;
    if (where == "defaults") {  // the reference says in a sentence that these are the keys of an arm
      EXPECT_TRUE(std::ranges::includes(in_reader.at("arms[]"), keys));
      continue;
    }
    EXPECT_EQ(in_reference.at(where), keys) << where;
  }
  for (const auto& [where, keys] : in_reference) EXPECT_TRUE(in_reader.contains(where)) << where << " does not exist";
}

TEST(SchemaTest, ReferenceNamesEveryMotionMethod) {
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/reference/cell-file.md");
  std::string row;
  while (std::getline(file, row) && !row.starts_with("| `method` |")) continue;
  for (const std::string_view name : planner::built_in_methods().names()) {
    EXPECT_NE(row.find("`" + std::string(name) + "`"), std::string::npos) << name;
  }
}

// Text of the column "default" by "arms[].damper influence_distance".
std::map<std::string, std::string> documented_defaults() {
  std::map<std::string, std::string> defaults;
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/reference/cell-file.md");
  std::string where;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## `")) where = line.substr(4, line.find('`', 4) - 4);
    if (!line.starts_with("| `")) continue;
    const std::string key = line.substr(3, line.find('`', 3) - 3);
    const std::size_t second = line.find(" | ") + 3;
    const std::size_t third = line.find(" | ", second);
    const std::size_t begin = third == std::string::npos ? second : third + 3;  // without the column "meaning"
    defaults[where + ' ' + key] = line.substr(begin, line.find(" |", begin) - begin);
  }
  return defaults;
}

// Compares the reference with the parameters as they are constructed.
class DefaultComparison final : public planner::ParameterVisitor {
 public:
  void section(std::string_view key) override { section_ = "arms[]." + std::string(key); }
  void number(std::string_view name, double& value, const planner::ParameterRange&) override {
    if (section_ == "arms[].damper") {  // default_damper() computes them
      EXPECT_EQ(documented(name), "by reach and braking") << name;
      return;
    }
    EXPECT_NEAR(std::strtod(documented(name).c_str(), nullptr), value, 0.002 * value) << section_ << ' ' << name;
  }
  void seconds(std::string_view name, double& value, const planner::ParameterRange&) override {
    char* unit = nullptr;
    const std::string text = documented(name);
    const double number = std::strtod(text.c_str(), &unit);
    EXPECT_DOUBLE_EQ(std::string_view(unit) == "ms" ? number / 1000.0 : number, value) << section_ << ' ' << name;
  }
  void integer(std::string_view name, int& value, int, int) override {
    const std::string text = documented(name);
    EXPECT_EQ(value == 0 ? "all but the last" : std::to_string(value), text) << section_ << ' ' << name;
  }
  void boolean(std::string_view name, bool& value) override {
    EXPECT_EQ(documented(name), value ? "true" : "false") << section_ << ' ' << name;
  }
  void word(std::string_view name, std::span<const std::string_view> words, std::size_t& index) override {
    std::string text = documented(name);
    std::erase(text, '`');
    EXPECT_EQ(text, words[index]) << section_ << ' ' << name;
  }
  [[nodiscard]] int compared() const { return compared_; }

 private:
  std::string documented(std::string_view name) {
    ++compared_;
    return defaults_[section_ + ' ' + std::string(name)];
  }

  std::map<std::string, std::string> defaults_ = documented_defaults();
  std::string section_;
  int compared_ = 0;
};

TEST(SchemaTest, ReferenceGivesTheDefaultOfEveryPlanningParameter) {
  DefaultComparison comparison;
  planner::LocalParameters local;
  visit_parameters(local, comparison);
  for (const auto& method : planner::built_in_methods().make_all()) method->visit_parameters(comparison);
  EXPECT_GT(comparison.compared(), 25);
}

// A default of the reference as a number: "20ms" in seconds, "1GB" in bytes, `true` as 1, a vector by its last number.
double documented_number(std::string text) {
  if (text == "true" || text == "false") return text == "true" ? 1.0 : 0.0;
  if (const auto minus = text.find("−"); minus != std::string::npos) text.replace(minus, std::string("−").size(), "-");
  if (text.starts_with('[')) text.erase(0, text.rfind(' ') + 1);
  char* unit = nullptr;
  const double number = std::strtod(text.c_str(), &unit);
  static const std::map<std::string_view, double> units = {{"", 1.0},   {"]", 1.0},  {"ms", 1e-3},          {"s", 1.0},
                                                           {" s", 1.0}, {"GB", 1e9}, {" + DDS domain", 1.0}};
  const auto found = units.find(unit);
  return unit == text.c_str() || found == units.end() ? std::nan("") : number * found->second;
}

// Of a cell whose optional maps are there, with what they require.
TEST(SchemaTest, ReferenceGivesTheDefaultOfEverySettingOfTheCell) {
  const CellFile file = parse_cell_file(R"(
name: defaults
network: {}
world: {}
supervision: {}
view: {}
record: {folder: bags}
ros2: {}
timing: {}
tasks: {centre: [0, 0, 0], clutter: {count: 1}}
arms:
  - name: left
    urdf: urdf/planar_2r.urdf
    poses: {home: [0, 1]}
    signals: {lamp: digital_output 3}
    gripper: {close: {lamp: 1}, open: {lamp: 0}}
    sensors: [{name: eye, link: upper, position: [0, 0, 0], direction: [0, 0, 1]}]
obstacles:
  - {name: round, shapes: [{type: sphere, radius: 0.1}], pose: {xyz: [0, 0, 50]},
     motion: {type: circle, centre: [9, 9, 50], angular_speed: 1}}
  - {name: wave, shapes: [{type: sphere, radius: 0.1}], pose: {xyz: [0, 20, 50]},
     motion: {type: sine, direction: [1, 0, 0], amplitude: 1, period: 1s}}
  - {name: tour, shapes: [{type: sphere, radius: 0.1}],
     motion: {type: waypoints, poses: [{xyz: [0, 40, 50]}, {xyz: [1, 40, 50]}], speed: 1}}
  - {name: ball, shapes: [{type: sphere, radius: 0.1}], pose: {xyz: [0, 60, 50]}, motion: {type: dynamic, mass: 1}}
)",
                                        std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/inline.yaml");
  const auto seconds = [](auto duration) { return std::chrono::duration<double>(duration).count(); };
  const auto& supervision = file.supervision;
  const auto& timing = file.cell.timing;
  const auto& tasks = file.cell.tasks;
  const auto& clutter = tasks.clutter;
  const auto& sensor = file.cell.arms[0].sensors[0];
  const auto& obstacles = file.cell.scene.obstacles;
  const auto& circle = std::get<world::CircleMotion>(obstacles[0].motion);
  const auto& dynamic = std::get<world::DynamicMotion>(obstacles[3].motion);
  const std::map<std::string, double> values = {
      {"network domain", file.network.domain},
      {"network lease", seconds(file.network.lease)},
      {"world floor_z", file.cell.scene.floor_z},
      {"world gravity", file.cell.scene.gravity.z()},
      {"supervision heartbeat_period", seconds(supervision.heartbeat_period)},
      {"supervision heartbeat_deadline", seconds(supervision.heartbeat_deadline)},
      {"supervision watchdog", seconds(supervision.watchdog)},
      {"supervision memory_limit", static_cast<double>(supervision.memory_limit)},
      {"supervision host_lease", seconds(supervision.host_lease)},
      {"supervision failover_timeout", seconds(supervision.failover_timeout)},
      {"view port", view_port(0)},
      {"view control", file.view->control},
      {"view no_stop", file.view->no_stop},
      {"record keep", seconds(file.record->keep)},
      {"record after_fault", seconds(file.record->after_fault)},
      {"record limit", static_cast<double>(file.record->limit)},
      {"record ros2", file.record->ros2},
      {"ros2 domain", file.ros2->domain},
      {"ros2 period", file.ros2->period},
      {"ros2 control", file.ros2->control},
      {"timing control_period", timing.control_period},
      {"timing driver_period", timing.driver_period},
      {"timing world_period", timing.world_period},
      {"timing command_timeout", timing.command_timeout},
      {"timing real_time", file.real_time},
      {"tasks spread", tasks.problem.spread},
      {"tasks mean_wait", tasks.problem.mean_wait},
      {"tasks radius", tasks.radius},
      {"tasks half_height", tasks.half_height},
      {"tasks time_limit", tasks.time_limit},
      {"tasks.clutter smallest", clutter.smallest},
      {"tasks.clutter largest", clutter.largest},
      {"tasks.clutter inner", clutter.inner},
      {"tasks.clutter outer", clutter.outer},
      {"tasks.clutter lowest", clutter.lowest},
      {"tasks.clutter highest", clutter.highest},
      {"arms[] goal_tolerance", file.cell.arms[0].parameters.goal_tolerance},
      {"arms[] acceleration_of_obstacles", file.cell.arms[0].parameters.acceleration_of_obstacles},
      {"arms[] state_age_limit", file.cell.arms[0].parameters.state_age_limit},
      {"arms[].gripper time", seconds(file.tools[0].gripper->time)},
      {"arms[].gripper speed", file.tools[0].gripper->speed},
      {"arms[].sensors[] rays", static_cast<double>(sensor.rays.size())},
      {"arms[].sensors[] range", sensor.range},
      {"arms[].sensors[] noise", sensor.noise},
      {"arms[].sensors[] period", sensor.period},
      {"arms[].sensors[] simulated", sensor.simulated},
      {"obstacles[].motion of type circle axis", circle.axis_W.z()},
      {"obstacles[].motion of type circle turn_with_motion", circle.turn_with_motion},
      {"obstacles[].motion of type sine phase", std::get<world::SineMotion>(obstacles[1].motion).phase},
      {"obstacles[].motion of type waypoints loop", std::get<world::WaypointMotion>(obstacles[2].motion).loop},
      {"obstacles[].motion of type dynamic friction", dynamic.friction},
      {"obstacles[].motion of type dynamic rolling_friction", dynamic.rolling_friction},
      {"obstacles[].motion of type dynamic restitution", dynamic.restitution}};
  auto documented = documented_defaults();
  for (const auto& [key, value] : values) {
    EXPECT_NEAR(documented_number(documented[key]), value, 1e-9 * std::abs(value)) << key << ": " << documented[key];
  }
  // Other defaults are words or vectors of zeros. Planning parameters have a test above, the driver reads those of its
  // device, and a mesh has no scale once it is read.
  const auto elsewhere = [](const std::string& key) {
    return key.starts_with("arms[].") || key == "obstacles[].shapes[] of type mesh scale";
  };
  for (const auto& [key, text] : documented) {
    const bool number = !std::isnan(documented_number(text)) && !text.starts_with("[0, 0, 0]");
    EXPECT_TRUE(!number || values.contains(key) || elsewhere(key)) << key << ": " << text;
  }
  for (const auto& [key, text] : documented) {
    if (!key.starts_with("supervision.recovery ")) continue;
    const bool waits = supervision.waits_for_resume.contains(key.substr(key.find(' ') + 1));
    EXPECT_TRUE(text.starts_with(waits ? "`resume`" : "`automatic`")) << key << ": " << text;
  }
}

TEST(SchemaTest, OnlySectionsOfFreeNamesHaveNoKeys) {
  for (const Section* section : all_sections()) EXPECT_EQ(section->keys.empty(), section->free_names) << section->where;
}

}  // namespace
}  // namespace hecaton::config
