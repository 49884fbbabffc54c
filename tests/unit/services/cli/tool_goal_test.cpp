/// Goals of the tool frame on the command line: --pose, --position, --free, --tolerance.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>

#include "services/command_line/document.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

/// A SCARA with links of 0.4 and 0.3 m, limits of 2.5 rad, and a vertical slide of 0.2 m. Its tool cannot tilt.
class ToolGoalOptionsTest : public testing::Test {
 protected:
  ToolGoalOptionsTest() {
    const auto link = [](const std::string& name) {
      return "<link name='" + name + "'><collision><geometry><sphere radius='0.03'/></geometry></collision></link>";
    };
    const auto joint = [](const std::string& name, const std::string& type, const std::string& parent,
                          const std::string& child, const std::string& x, const std::string& axis,
                          const std::string& limits) {
      return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
             "'/><origin xyz='" + x + " 0 0'/><axis xyz='" + axis + "'/><limit " + limits +
             " velocity='1' effort='1'/></joint>";
    };
    const std::string wide = "lower='-2.5' upper='2.5'";
    std::ofstream(robot_) << "<robot name='scara'>" << link("base") << link("a") << link("b") << link("c") << link("d")
                          << joint("j1", "revolute", "base", "a", "0", "0 0 1", wide)
                          << joint("j2", "revolute", "a", "b", "0.4", "0 0 1", wide)
                          << joint("j3", "prismatic", "b", "c", "0.3", "0 0 -1", "lower='0' upper='0.2'")
                          << joint("j4", "revolute", "c", "d", "0", "0 0 1", "lower='-3.1' upper='3.1'") << "</robot>";
  }
  ~ToolGoalOptionsTest() override { std::filesystem::remove(robot_); }

  [[nodiscard]] Ran plan(std::vector<std::string> words) const {
    std::vector<std::string> line{"plan", robot_, "--from", "0.6 0.6 0 0", "-o", "json"};
    line.insert(line.end(), words.begin(), words.end());
    return run_line(line);
  }
  static std::vector<double> end_of(const Ran& ran) {
    return Json::parse(ran.out)["path"].back().get<std::vector<double>>();
  }
  static void expect_usage(const Ran& ran, const std::string& says) {
    EXPECT_EQ(ran.code, ExitCode::kUsage) << ran.out;
    EXPECT_NE(ran.err.find(says), std::string::npos) << ran.err;
  }

  const std::string robot_ =
      std::filesystem::temp_directory_path() / ("tool_goal" + std::to_string(::getpid()) + ".urdf");
};

TEST_F(ToolGoalOptionsTest, PlanToAPoseWithItsOrientation) {
  for (const double yaw : {0.0, 2.0}) {
    const Ran ran = plan({"--pose", "0.4 0.2 -0.1 0 0 " + std::to_string(yaw)});
    ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err << ran.out;
    const std::vector<double> q = end_of(ran);
    EXPECT_NEAR(0.4 * std::cos(q[0]) + 0.3 * std::cos(q[0] + q[1]), 0.4, 1e-3);
    EXPECT_NEAR(0.4 * std::sin(q[0]) + 0.3 * std::sin(q[0] + q[1]), 0.2, 1e-3);
    EXPECT_NEAR(q[2], 0.1, 1e-3);
    EXPECT_NEAR(std::remainder(q[0] + q[1] + q[3] - yaw, 2.0 * std::numbers::pi), 0.0, 9e-3);
  }
}

// From Ry(0.8) the nearest orientation without tilt is the identity, 0.8 rad = 45.8° away.
TEST_F(ToolGoalOptionsTest, PlanRejectsAnOrientationWithTheNearestOne) {
  const Ran ran = plan({"--pose", "0.4 0.2 -0.1 0 0.8 0"});
  EXPECT_EQ(ran.code, ExitCode::kNegative);
  const Json plan = Json::parse(ran.out);
  EXPECT_EQ(plan["solved"], false);
  EXPECT_EQ(plan["status"], "goal_invalid");
  EXPECT_EQ(plan["reason"],
            "the tool of arm scara cannot be at (0.4, 0.2, -0.1) in that orientation: the nearest that it can take "
            "there is 45.8° away, roll pitch yaw 0.000 0.000 0.000");
  EXPECT_NEAR(plan["nearest"]["angle_rad"].get<double>(), 0.8, 1e-3);
  EXPECT_NEAR(plan["nearest"]["xyz_rpy"][0].get<double>(), 0.4, 1e-3);
}

TEST_F(ToolGoalOptionsTest, PlanToAnOrientationThatStaysFree) {
  EXPECT_EQ(plan({"--position", "0.4 0.2 -0.1"}).code, ExitCode::kDone);
  EXPECT_EQ(plan({"--pose", "0.4 0.2 -0.1 0 0.8 0", "--free", "pitch"}).code, ExitCode::kDone);
  EXPECT_EQ(plan({"--pose", "0.4 0.2 -0.1 0 0.8 0", "--free", "yaw"}).code, ExitCode::kNegative);
  EXPECT_EQ(plan({"--pose", "0.4 0.2 -0.1 0 0.8 0", "--tolerance", "60deg"}).code, ExitCode::kDone);
  EXPECT_EQ(plan({"--pose", "0.4 0.2 -0.1 0 0.8 0", "--tolerance", "5mm,40deg"}).code, ExitCode::kNegative);
  EXPECT_EQ(plan({"--position", "0.4 0.2 0.004", "--tolerance", "5mm"}).code, ExitCode::kDone) << "4 mm out of reach";
  EXPECT_EQ(plan({"--position", "0.4 0.2 0.004", "--tolerance", "3mm"}).code, ExitCode::kNegative);
}

TEST_F(ToolGoalOptionsTest, RejectTolerancesWithoutUnitOrOutOfRange) {
  for (const std::string bad : {"5", "5cm", "0mm", "2m", "1mm,2mm", "200deg", "nandeg", ",", "1mm,,x"}) {
    const Ran ran = plan({"--pose", "0.4 0.2 -0.1 0 0 0", "--tolerance", bad});
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << bad << ran.out;
    EXPECT_NE(ran.err.find("--tolerance = '"), std::string::npos) << ran.err;
  }
  for (const std::string good : {"0.01mm", "1m", "180deg", "0.5rad", "2deg 1mm"}) {
    EXPECT_EQ(plan({"--pose", "0.4 0.2 -0.1 0 0 0", "--tolerance", good}).code, ExitCode::kDone) << good;
  }
}

TEST_F(ToolGoalOptionsTest, RejectCombinationsThatMeanNothing) {
  expect_usage(plan({"--to", "0 0 0 0", "--tolerance", "1mm"}), "--tolerance is for --pose and --position");
  expect_usage(plan({"--position", "0.4 0.2 -0.1", "--free", "yaw"}), "--pose");
  expect_usage(plan({"--position", "0.4 0.2 -0.1", "--pose", "0.4 0.2 -0.1 0 0 0"}), "--position");
  expect_usage(plan({"--to", "0 0 0 0", "--pose", "0.4 0.2 -0.1 0 0 0"}), "--to");
}

TEST_F(ToolGoalOptionsTest, PlanMovesAJointOntoItsLimitWhenItIsOutsideByRounding) {
  const Ran ran = plan({"--to", "2.5000000001 0 0 0"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.out;
  EXPECT_EQ(end_of(ran)[0], 2.5);
  EXPECT_NE(ran.err.find("note: goal: joint j1 = 2.5000000001 is outside its limit by rounding and becomes 2.5"),
            std::string::npos)
      << ran.err;
  const Ran outside = plan({"--to", "2.5005 0 0 0"});
  EXPECT_EQ(outside.code, ExitCode::kNegative);
  EXPECT_NE(outside.out.find("joint j1 = 2.5005 must be within -2.5 … 2.5"), std::string::npos) << outside.out;
}

}  // namespace
}  // namespace hecaton::services::cli
