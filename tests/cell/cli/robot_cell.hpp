#pragma once
/// A live cell in which the arm `north` has a simulated controller of tests/robots.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <optional>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/robot_simulator.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {

class RobotCell : public LiveCell {
 protected:
  /// A named pose that is far from where the robot stands.
  [[nodiscard]] virtual std::string far_pose() = 0;
  /// A slower joint of the robot stands, in the units of its controller.
  [[nodiscard]] virtual double slow() const = 0;

  /// Call it before SetUp().
  void write_cell(const std::string& text) const { std::ofstream(cell_file()) << text; }
  void TearDown() override {
    LiveCell::TearDown();
    robot_.reset();
  }
  [[nodiscard]] std::string cell_file() const override { return (folder_.path() / "cell.yaml").string(); }

  [[nodiscard]] Json arm() const { return entry(json({"arms"}), "name", "north"); }
  /// The open faults of the arm, as a word each.
  [[nodiscard]] std::string faults() const {
    std::string kinds;
    for (const Json& fault : json({"faults"})) {
      if (!fault["cleared"].get<bool>() && fault["subject"] == "north") kinds += fault["kind"].get<std::string>() + " ";
    }
    return kinds;
  }
  /// A fault of the arm has this kind, also one that is over.
  [[nodiscard]] bool reported(const std::string& kind) const {
    const Json faults = json({"faults"});
    return std::any_of(faults.begin(), faults.end(),
                       [&](const Json& fault) { return fault["subject"] == "north" && fault["kind"] == kind; });
  }
  [[nodiscard]] bool until(const std::function<bool()>& event) const {
    for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
      if (event()) return true;
    }
    return false;
  }
  void reach(const std::string& named) const {
    const Ran ran = run({"goal", "north", "--named", named, "--wait", "--time-limit", "60s"});
    EXPECT_EQ(ran.code, 0) << ran.out << ran.err << arm();
  }
  /// Speed of the fastest joint, from the controller.
  [[nodiscard]] double robot_speed() {
    double fastest = 0.0;
    for (const double qd : robot_->state()["qd"].get<std::vector<double>>()) fastest = std::max(fastest, std::abs(qd));
    return fastest;
  }
  /// The robot moves; then `stop` happens. The arm is held with a fault of this kind, and its goal has ended.
  void stops_by(const std::function<void()>& stop, const std::string& kind) {
    ASSERT_EQ(run({"goal", "north", "--named", far_pose()}).code, 0);
    ASSERT_TRUE(until([&] { return robot_speed() > 1000 * slow(); })) << arm();
    stop();
    ASSERT_TRUE(until([&] { return arm()["mode"] == "hold"; })) << arm();
    const Ran ended = run({"wait", "north", "--for", "cancelled", "--timeout", "60s"});
    EXPECT_EQ(ended.code, 0) << ended.out << ended.err;
    EXPECT_TRUE(until([&] { return robot_speed() < slow(); }));
    EXPECT_TRUE(until([&] { return reported(kind); })) << kind << json({"faults"});
  }

  TemporaryFolder folder_;
  std::optional<RobotSimulator> robot_;
};

}  // namespace hecaton::test
