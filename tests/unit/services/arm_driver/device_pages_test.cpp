// The tables of the devices' keys in docs/ have the keys, the defaults and the ranges that the devices read.

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "services/arm_driver/devices/abb_egm/abb_egm_arm.hpp"
#include "services/arm_driver/devices/abb_egm/options.hpp"
#include "services/arm_driver/devices/ros2_control/options.hpp"
#include "services/arm_driver/devices/simulated/options.hpp"
#include "services/arm_driver/devices/universal_robots/options.hpp"
#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"

namespace hecaton::device {
namespace {

using namespace std::chrono_literals;

struct Row {
  std::string otherwise;  ///< the column "default"
  std::string allowed;
};

/// The cells of a row of a table, without the spaces around them.
std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  for (std::size_t at = row.find('|') + 1; at < row.size();) {
    const std::size_t end = std::min(row.find('|', at), row.size());
    const std::size_t first = std::min(row.find_first_not_of(' ', at), end);
    const std::size_t last = row.find_last_not_of(' ', end - 1);
    cells.push_back(first == end ? "" : row.substr(first, last + 1 - first));
    at = end + 1;
  }
  return cells;
}

/// The rows "| `key` | meaning | default | allowed |" below a heading, down to the next one of its level or above.
std::map<std::string, Row> rows_of(const std::string& page, const std::string& heading) {
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/" + page);
  std::map<std::string, Row> rows;
  const std::size_t level = heading.find(' ');
  bool below = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') && line.find(' ') <= level) below = line == heading;
    if (!below || !line.starts_with("| `")) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != 4) continue;  // of another table
    rows[cells[0].substr(1, cells[0].size() - 2)] = {cells[2], cells[3]};
  }
  return rows;
}

/// "0.03s" and "50001 plus the arm's place": its number. Empty: it begins with none.
std::optional<double> number_in(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return end == text.c_str() ? std::nullopt : std::optional(number);
}

/// "1024…65535", "0s…0.5s". Empty: the cell is no range of numbers.
std::optional<std::pair<double, double>> range_in(const std::string& text) {
  const std::size_t dots = text.find("…");
  if (dots == std::string::npos) return std::nullopt;
  const auto low = number_in(text), high = number_in(text.substr(dots + std::string("…").size()));
  return low && high ? std::optional(std::pair(*low, *high)) : std::nullopt;
}

/// An arm whose joints are as many as the device wants.
DeviceSetup setup_of(int joints) {
  DeviceSetup setup;
  setup.arm = "left";
  setup.limits.lower = JointVector::Constant(joints, -3.0);
  setup.limits.upper = JointVector::Constant(joints, 3.0);
  setup.limits.velocity = JointVector::Constant(joints, 1.0);
  setup.limits.acceleration = JointVector::Constant(joints, 10.0);
  setup.period = 2ms;
  setup.command_timeout = 100ms;
  setup.where = "cell.yaml: arms[0].device";
  for (int joint = 0; joint < joints; ++joint) setup.joint_names.push_back("joint" + std::to_string(joint));
  setup.forces.of_motion = [](const JointVector& q, const JointVector&, const JointVector&) { return q; };
  setup.forces.limits = JointVector::Constant(joints, 1.0);
  return setup;
}

/// Numbers and words by key.
using Values = std::map<std::string, std::variant<double, std::string>>;

/// One device and its table.
struct Page {
  std::string page;
  std::string heading;
  std::vector<std::string_view> keys;
  DeviceSetup setup;
  /// Numbers and words of the options that a setup leads to, by key.
  std::function<Values(const DeviceSetup&)> read;
};

Page simulated() {
  return {"reference/cell-file.md", "### A simulated arm", kSimulatedKeys, setup_of(6), [](const DeviceSetup& setup) {
            const SimulatedOptions options = read_simulated_options(setup);
            const planner::ServoParameters& servo = options.servo;
            return Values{{"dead_time", servo.dead_time},
                          {"jitter", servo.jitter},
                          {"lag", servo.lag},
                          {"damping", servo.damping},
                          {"noise", servo.noise},
                          {"resolution", servo.resolution},
                          {"protective_speed", options.protective_speed},
                          {"protective_effort", options.protective_effort}};
          }};
}

Page universal_robots() {
  DeviceSetup setup = setup_of(6);
  setup.values = {{"robot_ip", "10.0.0.1"}};
  return {"how-to/universal-robots.md", "## 2. Describe it in the cell file", kUniversalRobotsKeys, setup,
          [](const DeviceSetup& own) {
            const universal_robots::Options options = universal_robots::read_options(own);
            return Values{{"reverse_port", static_cast<double>(options.reverse_port)},
                          {"lookahead_time", options.lookahead_time},
                          {"gain", options.gain}};
          }};
}

Page abb_egm() {
  return {"how-to/abb-egm.md", "## 2. Describe it in the cell file", kAbbEgmKeys, setup_of(7),
          [](const DeviceSetup& setup) {
            const abb_egm::Options options = abb_egm::read_options(setup);
            return Values{{"port", static_cast<double>(options.port)},
                          {"external_axis", static_cast<double>(options.external_axis.value() + 1)},
                          {"tracking_delay", options.tracking_delay}};
          }};
}

Page ros2_control() {
  DeviceSetup setup = setup_of(6);
  setup.outside_names = {"finger"};
  setup.fingers = {true};
  setup.values = {{"gripper_controller", "gripper"}};
  return {"how-to/ros2-control.md", "## 2. Describe it in the cell file", ros2_control::kKeys, setup,
          [](const DeviceSetup& own) {
            const ros2_control::Options options = ros2_control::read_options(own);
            return Values{{"domain", static_cast<double>(options.domain)},
                          {"controller", options.controller},
                          {"joint_states", options.joint_states},
                          {"lookahead", options.lookahead},
                          {"tracking_delay", options.tracking_delay - options.lookahead},
                          {"gripper_effort", options.gripper.value().effort}};
          }};
}

class DevicePages : public testing::TestWithParam<Page (*)()> {};

TEST_P(DevicePages, HaveTheKeysAndDefaultsOfTheDevice) {
  const Page page = GetParam()();
  const auto rows = rows_of(page.page, page.heading);
  std::set<std::string> listed;
  for (const auto& [key, row] : rows) listed.insert(key);
  EXPECT_EQ(listed, std::set<std::string>(page.keys.begin(), page.keys.end()));
  const auto values = page.read(page.setup);
  for (const auto& [key, value] : values) {
    ASSERT_TRUE(rows.contains(key)) << key;
    const std::string& text = rows.at(key).otherwise;
    if (const auto* number = std::get_if<double>(&value)) {
      EXPECT_NEAR(number_in(text).value_or(std::nan("")), *number, 1e-9) << key << ": " << text;
    } else {  // a full name of ROS 2
      EXPECT_TRUE(text.starts_with("`" + std::get<std::string>(value).substr(1) + "`")) << key << ": " << text;
    }
  }
  // Other defaults are sentences.
  for (const auto& [key, row] : rows) EXPECT_TRUE(!number_in(row.otherwise) || values.contains(key)) << key;
}

TEST_P(DevicePages, HaveTheRangesOfTheDevice) {
  const Page page = GetParam()();
  int compared = 0;
  for (const auto& [key, row] : rows_of(page.page, page.heading)) {
    const auto range = range_in(row.allowed);
    if (!range) continue;
    ++compared;
    const auto accepts = [&](double value) {
      DeviceSetup setup = page.setup;
      setup.values[key] = std::to_string(value);
      try {
        static_cast<void>(page.read(setup));
        return true;
      } catch (const std::runtime_error&) {
        return false;
      }
    };
    const double beyond = std::max(1.0, 1e-3 * range->second);
    EXPECT_TRUE(accepts(range->first) && accepts(range->second)) << key;
    EXPECT_FALSE(accepts(range->first - beyond)) << key;
    EXPECT_FALSE(accepts(range->second + beyond)) << key;
  }
  EXPECT_GT(compared, 2) << page.page;
}

INSTANTIATE_TEST_SUITE_P(Devices, DevicePages, testing::Values(&simulated, &universal_robots, &abb_egm, &ros2_control));

}  // namespace
}  // namespace hecaton::device
