#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "services/command_line/document.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

const std::string kPlanCell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
const std::string kPlanRobot = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";

/// A temporary file.
class ScratchFile {
 public:
  ScratchFile(const std::string& name, const std::string& text)
      : path_(std::filesystem::temp_directory_path() / (name + std::to_string(::getpid()) + ".yaml")) {
    std::ofstream(path_) << text;
  }
  ~ScratchFile() { std::filesystem::remove(path_); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  [[nodiscard]] std::string path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string scene(const std::string& x, const std::string& type = "box") {
  return "world:\n  collision_objects:\n    - id: shelf\n      primitives:\n        - {type: " + type +
         ", dimensions: [0.3, 0.3, 0.3]}\n      primitive_poses:\n        - {position: [" + x +
         ", 0.15, 0.67], orientation: [0, 0, 0, 1]}\n";
}

TEST(PlanCommand, PlansForAnArmOfACell) {
  const Ran ran = run_line({"plan", kPlanCell, "--arm", "west", "--to", "ready", "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json plan = Json::parse(ran.out);
  EXPECT_EQ(plan["status"], "solved");
  EXPECT_EQ(plan["path"].front(), Json::parse("[0, -1.9, 2.6, 0, 0.6, 0]").get<std::vector<double>>());
  EXPECT_EQ(plan["path"].back(), Json::parse("[-0.3, -1.25, 3.5, 0, 0.89, 0]").get<std::vector<double>>());
  EXPECT_GT(plan["length"].get<double>(), 1.15);  // of the straight way: √(0.3² + 0.65² + 0.9² + 0.29²) = 1.185
  EXPECT_GT(plan["min_clearance_m"].get<double>(), 0.0);
  EXPECT_GT(plan["checks"].get<int>(), 0);
}

TEST(PlanCommand, PrintsATrajectoryWithinTheLimits) {
  const Ran ran = run_line({"plan", kPlanCell, "--arm", "west", "--to", "ready", "--trajectory", "10ms", "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json plan = Json::parse(ran.out);
  const double duration = plan["duration_s"].get<double>();
  const Json& samples = plan["trajectory"]["samples"];
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(std::ceil(duration / 0.01)) + 1);
  EXPECT_EQ(samples.front()["q"], plan["path"].front());
  EXPECT_EQ(samples.back()["time_s"], plan["duration_s"]);
  EXPECT_EQ(samples.back()["qd"], Json::parse("[0, 0, 0, 0, 0, 0]").get<std::vector<double>>());
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    for (int j = 0; j < 6; ++j) {
      const auto value = [&](std::size_t at, const char* key) { return samples[at][key][j].get<double>(); };
      // What positions do from sample to sample is what the velocities say, within what accelerations can add.
      const double dt = samples[i + 1]["time_s"].get<double>() - samples[i]["time_s"].get<double>();
      ASSERT_NEAR(value(i + 1, "q") - value(i, "q"), 0.5 * dt * (value(i, "qd") + value(i + 1, "qd")), 2e-3);
    }
  }
  const Ran table = run_line({"plan", kPlanCell, "--arm", "west", "--to", "ready", "--trajectory", "100ms"});
  EXPECT_NE(table.out.find("takes the arm "), std::string::npos);
  EXPECT_NE(table.out.find("trajectory: t q"), std::string::npos);
}

TEST(PlanCommand, LimitsJerkWithTheOption) {
  std::vector<std::string> words{"plan",  kPlanCell,      "--arm", "west", "--to",
                                 "ready", "--trajectory", "10ms",  "-o",   "json"};
  const Json quick = Json::parse(run_line(words).out);
  words.insert(words.end(), {"--jerk", "50"});
  const Ran ran = run_line(words);
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json smooth = Json::parse(ran.out);
  const auto steepest = [](const Json& plan) {
    const Json& samples = plan["trajectory"]["samples"];
    double most = 0.0;
    for (std::size_t i = 0; i + 2 < samples.size(); ++i) {  // the last one comes after less than a period
      for (int j = 0; j < 6; ++j) {
        most = std::max(most, std::abs(samples[i + 1]["qdd"][j].get<double>() - samples[i]["qdd"][j].get<double>()));
      }
    }
    return most / 0.01;
  };
  EXPECT_GT(steepest(quick), 100.0);
  EXPECT_LE(steepest(smooth), 50.0 * (1 + 1e-6));
  EXPECT_GT(smooth["duration_s"].get<double>(), quick["duration_s"].get<double>());
  EXPECT_EQ(smooth["path"], quick["path"]);
}

TEST(PlanCommand, StopsAtCornersWithoutDeviation) {
  const std::vector<std::string> words{"plan",  std::string(HECATON_SOURCE_DIR) + "/deploy/cells/narrow_passage.yaml",
                                       "--to",  "across",
                                       "-o",    "json",
                                       "--raw", "--method",
                                       "prm"};
  const auto duration = [&](const char* deviation) {
    std::vector<std::string> line = words;
    line.insert(line.end(), {"--deviation", deviation});
    const Ran ran = run_line(line);
    EXPECT_EQ(ran.code, ExitCode::kDone) << ran.err;
    return Json::parse(ran.out)["duration_s"].get<double>();
  };
  EXPECT_LT(duration("0.1"), duration("0"));
}

std::string cell(const std::string& name) {
  return std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + name + ".yaml";
}

TEST(PlanCommand, RejectsOptionsThatTheMethodIgnores) {
  const auto refused = [](const std::string& file, const std::string& method, const std::string& option,
                          const std::string& value) {
    const Ran ran = run_line({"plan", cell(file), "--to", "across", "--method", method, option, value});
    EXPECT_EQ(ran.code, ExitCode::kUsage) << option;
    EXPECT_NE(ran.err.find(option + " is not for " + method), std::string::npos) << ran.err;
  };
  refused("planar_2r", "known_cspace", "--trajectory", "10ms");
  refused("planar_2r", "known_cspace", "--jerk", "10");
  refused("planar_2r", "known_cspace", "--clearance", "0.1");
  refused("planar_2r", "sensed_cspace", "--keep", "0.1");
  refused("planar_3r", "potential_field", "--budget", "1s");
  refused("planar_3r", "potential_field", "--step", "0.1");
}

TEST(PlanCommand, RejectsEmptyText) {
  for (const std::string option : {"--from", "--to", "--moveit-scene", "--moveit-request", "--srdf", "--plot"}) {
    std::vector<std::string> words{"plan", kPlanRobot, option, ""};
    if (option != "--to") words.insert(words.end(), {"--to", "0 -1.5 1 0 0 0"});
    const Ran ran = run_line(words);
    EXPECT_EQ(ran.code, ExitCode::kBadInput) << option << ran.out;
    EXPECT_NE(ran.err.find(option + " = ''"), std::string::npos) << ran.err;
  }
}

// Links of the arm are nearer to each other than to the shelf, but --clearance does not apply to them.
TEST(PlanCommand, NamesThePairWithTooLittleClearance) {
  const ScratchFile far("beside_scene", scene("1.5"));
  const Ran ran = run_line({"plan", kPlanRobot, "--from", "0 0 0 0 0 0", "--to", "0 -1.5 1 0 0 0", "--moveit-scene",
                            far.path(), "--clearance", "0.9"});
  EXPECT_EQ(ran.code, ExitCode::kNegative);
  EXPECT_NE(ran.out.find("is too close to collision"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("shelf"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("(minimum distance 900 mm); choose another "), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find(", or ask for less clearance"), std::string::npos) << ran.out;
}

TEST(PlanCommand, HasATrajectoryWhenTheStartIsTheGoal) {
  const Ran ran =
      run_line({"plan", cell("planar_2r"), "--from", "across", "--to", "across", "--trajectory", "10ms", "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json plan = Json::parse(ran.out);
  ASSERT_EQ(plan["trajectory"]["samples"].size(), 1U);
  EXPECT_EQ(plan["trajectory"]["samples"][0]["q"], plan["path"].front());
}

TEST(PlanCommand, KeepsTheClearanceOfAFieldsPath) {
  const auto room = [](const std::string& keep) {
    const Ran ran = run_line(
        {"plan", cell("planar_3r"), "--to", "across", "--method", "potential_field", "--keep", keep, "-o", "json"});
    EXPECT_EQ(ran.code, ExitCode::kDone) << ran.err;
    return Json::parse(ran.out)["min_obstacle_clearance_m"].get<double>();
  };
  EXPECT_LT(room("0"), 0.04);
  EXPECT_GT(room("0.04"), 0.04);
}

TEST(PlanCommand, RejectsAPlotOfSeveralArmsAndKeepsTheFile) {
  const ScratchFile plot("plot", "unchanged");
  const Ran several =
      run_line({"plan", kPlanCell, "--arm", "north", "--arm", "west", "--to", "ready", "--plot", plot.path()});
  EXPECT_EQ(several.code, ExitCode::kUsage);
  EXPECT_NE(several.err.find("--plot"), std::string::npos) << several.err;
  EXPECT_EQ(several.err.find("potential_field"), std::string::npos) << several.err;
  std::ifstream file(plot.path());
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "unchanged");
}

TEST(PlanCommand, PlansForAllArmsOfACellTogether) {
  const Ran ran =
      run_line({"plan", kPlanCell, "--arm", "north", "--arm", "west", "--arm", "east", "--to", "ready", "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json plan = Json::parse(ran.out);
  EXPECT_EQ(plan["path"][0].size(), 18U);
  EXPECT_GT(plan["min_clearance_m"].get<double>(), 0.0);
}

TEST(PlanCommand, NamesTheObjectOfAMoveItSceneInCollision) {
  const ScratchFile far("far_scene", scene("1.5"));
  const ScratchFile near("near_scene", scene("0.4"));
  const std::vector<std::string> words{"plan", kPlanRobot, "--from", "0 0 0 0 0 0", "--to", "0 -1.5 1 0 0 0"};
  const auto with = [&](const std::string& file) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--moveit-scene", file});
    return run_line(all);
  };
  EXPECT_EQ(with(far.path()).code, ExitCode::kDone);
  const Ran blocked = with(near.path());
  EXPECT_EQ(blocked.code, ExitCode::kNegative);
  EXPECT_NE(blocked.out.find("start is in collision"), std::string::npos) << blocked.out;
  EXPECT_NE(blocked.out.find("shelf"), std::string::npos) << blocked.out;
}

TEST(PlanCommand, ReadsAMoveItRequest) {
  const ScratchFile request("request", R"(start_state:
  joint_state:
    name: [joint1, joint2, joint3, joint4, joint5, joint6, gripper]
    position: [0, -1.5, 1, 0, 0, 0, 0.1]
goal_constraints:
  - joint_constraints:
      - {joint_name: joint1, position: 1}
      - {joint_name: joint2, position: -1.5}
      - {joint_name: joint3, position: 1}
      - {joint_name: joint4, position: 0}
      - {joint_name: joint5, position: 0}
      - {joint_name: joint6, position: 0.5}
)");
  const Ran ran = run_line({"plan", kPlanRobot, "--moveit-request", request.path(), "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json plan = Json::parse(ran.out);
  EXPECT_EQ(plan["path"].size(), 2U) << "no obstacle is on the straight line";
  EXPECT_DOUBLE_EQ(plan["path"][1][5].get<double>(), 0.5);
  ASSERT_EQ(plan["findings"].size(), 1U);
  EXPECT_EQ(plan["findings"][0]["severity"], "note");
  EXPECT_NE(ran.err.find("note: " + plan["findings"][0]["sentence"].get<std::string>()), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("start_state: no planned joint is called gripper"), std::string::npos) << ran.err;
}

TEST(PlanCommand, RejectsARequestForOtherJoints) {
  const auto refused = [](const std::string& goal, const std::string& says) {
    const ScratchFile request("other_request",
                              "start_state:\n  joint_state: {name: [joint1, joint2, joint3, joint4, joint5, joint6], "
                              "position: [0, 0, 0, 0, 0, 0]}\ngoal_constraints:\n  - joint_constraints: [" +
                                  goal + "]\n");
    const Ran ran = run_line({"plan", kPlanRobot, "--moveit-request", request.path()});
    EXPECT_EQ(ran.code, ExitCode::kBadInput);
    EXPECT_NE(ran.err.find(says), std::string::npos) << ran.err;
  };
  refused("{joint_name: joint7, position: 0}", "joint_name = 'joint7' is no planned joint");
  refused("{joint_name: joint1, position: 0}", "goal_constraints: joint 'joint2' is missing");
}

TEST(PlanCommand, RejectsInvalidValues) {
  const auto refused = [](const std::vector<std::string>& words, ExitCode code, const std::string& says) {
    const Ran ran = run_line(words);
    EXPECT_EQ(ran.code, code) << says;
    EXPECT_NE(ran.err.find(says), std::string::npos) << ran.err;
  };
  refused({"plan", kPlanCell, "--arm", "nroth", "--to", "ready"}, ExitCode::kBadInput, "allowed are north, west, east");
  refused({"plan", kPlanCell, "--to", "ready", "--jerk", "0"}, ExitCode::kBadInput, "--jerk = '0' must be a number");
  refused({"plan", kPlanCell, "--to", "1 2"}, ExitCode::kBadInput, "must be 6 numbers, or the name of a pose");
  refused({"plan", kPlanCell, "--to", "1e9 0 0 0 0 0"}, ExitCode::kBadInput, "must be between -100 and 100 rad");
  refused({"plan", kPlanCell}, ExitCode::kBadInput,
          "--to, --pose, --position or --moveit-request is needed for the goal");
  refused({"plan", kPlanRobot, "--to", "0 0 0 0 0 0"}, ExitCode::kBadInput, "is needed: arm puma560 has no start");
  refused({"plan", kPlanCell, "--to", "ready", "--method", "magic"}, ExitCode::kUsage, "rrt_connect");
  refused({"plan", kPlanCell, "--to", "ready", "--trajectory", "10"}, ExitCode::kBadInput, "a number with its unit");
  refused({"plan", kPlanCell, "--to", "ready", "--deviation", "-1"}, ExitCode::kBadInput, "--deviation");
  refused({"plan", kPlanCell, "--to", "ready", "--tool", "hand"}, ExitCode::kUsage, "--tool is for a URDF");
  refused({"plan", kPlanRobot, "--to", "0 0 0 0 0 0", "--arm", "x"}, ExitCode::kUsage, "--arm is for a cell file");
  const ScratchFile cone("cone_scene", scene("1", "cone"));
  refused({"plan", kPlanRobot, "--to", "0 0 0 0 0 0", "--moveit-scene", cone.path()}, ExitCode::kBadInput,
          "world.collision_objects[0].primitives[0].type = cone must be box, sphere or cylinder");
}

TEST(PlanCommand, DescendsAPotentialFieldAndPlotsIt) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("field" + std::to_string(::getpid()) + ".svg");
  for (const std::string cell : {"mobile_rectangle", "planar_3r", "puma_potential"}) {
    const Ran ran =
        run_line({"plan", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + cell + ".yaml", "--to", "across",
                  "--method", "potential_field", "--clearance", "0.01", "--plot", file.string(), "-o", "json"});
    ASSERT_EQ(ran.code, ExitCode::kDone) << cell << ran.err << ran.out;
    const Json plan = Json::parse(ran.out);
    EXPECT_EQ(plan["status"], "solved");
    EXPECT_EQ(plan["method"], "potential_field");
    EXPECT_GT(plan["min_clearance_m"].get<double>(), 0.0099) << cell;
    EXPECT_GT(plan["path"].size(), 2U) << "an obstacle is on the straight line";
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    EXPECT_TRUE(text.str().starts_with("<svg"));
    EXPECT_TRUE(text.str().ends_with("</svg>\n"));
  }
  std::filesystem::remove(file);
}

std::string content_of(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// [Li96] figure 4: every step in workspace and C-space, with sensed and with known obstacles.
TEST(PlanCommand, PlansInCspaceAndPlotsEveryStep) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("steps" + std::to_string(::getpid()));
  for (const std::string method : {"sensed_cspace", "known_cspace"}) {
    const Ran ran = run_line({"plan", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml", "--arm", "arm",
                              "--to", "across", "--method", method, "--plot", folder.string(), "-o", "json"});
    ASSERT_EQ(ran.code, ExitCode::kDone) << method << ran.err << ran.out;
    const Json plan = Json::parse(ran.out);
    EXPECT_EQ(plan["status"], "solved");
    EXPECT_EQ(plan["method"], method);
    EXPECT_GT(plan["min_clearance_m"].get<double>(), 0.03) << "the margin";
    EXPECT_GT(plan["path"].size(), 2U) << "an obstacle is on the straight line";
    EXPECT_GT(plan["nodes"].get<int>(), 10) << "known points";
    std::size_t plots = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string svg = content_of(entry.path());
      EXPECT_TRUE(svg.starts_with("<svg"));
      EXPECT_TRUE(svg.ends_with("</svg>\n"));
      EXPECT_EQ(svg.find("nan"), std::string::npos);
      ++plots;
    }
    EXPECT_GT(plots, 10U);
    EXPECT_NE(ran.err.find(std::to_string(plots) + " plots in " + folder.string()), std::string::npos) << ran.err;
    std::filesystem::remove_all(folder);
  }
}

TEST(PlanCommand, SaysWhyThereIsNoPathInCspace) {
  const std::string cell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml";
  // The crate is about the tip at (0.7, −0.1): an arm that senses moves there to detect it.
  const std::string inside = "0.65 -1.6";
  const Ran sensed = run_line({"plan", cell, "--to", inside, "--method", "sensed_cspace", "-o", "json"});
  EXPECT_EQ(sensed.code, ExitCode::kNegative) << sensed.out;
  const Json plan = Json::parse(sensed.out);
  EXPECT_EQ(plan["status"], "stuck");
  EXPECT_NE(plan["reason"].get<std::string>().find("its goal is nearer to a known obstacle"), std::string::npos)
      << plan["reason"];
  const Ran known = run_line({"plan", cell, "--to", inside, "--method", "known_cspace", "-o", "json"});
  EXPECT_EQ(known.code, ExitCode::kNegative) << known.out;
  EXPECT_EQ(Json::parse(known.out)["status"], "goal_invalid");
  const Ran beyond = run_line({"plan", cell, "--to", "9 9", "--method", "sensed_cspace", "-o", "json"});
  EXPECT_EQ(Json::parse(beyond.out)["status"], "goal_invalid") << beyond.out;
  const Ran on_it =
      run_line({"plan", cell, "--from", inside, "--to", "home", "--method", "sensed_cspace", "-o", "json"});
  EXPECT_EQ(Json::parse(on_it.out)["status"], "start_invalid") << on_it.out;
  const Ran six = run_line({"plan", kPlanCell, "--to", "ready", "--method", "sensed_cspace"});
  EXPECT_EQ(six.code, ExitCode::kBadInput);
  EXPECT_NE(six.err.find("--method = sensed_cspace must be given to an arm of two links"), std::string::npos)
      << six.err;
}

TEST(PlanCommand, PlotsTheTreeOfARobotOfTwoJoints) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("tree" + std::to_string(::getpid()) + ".svg");
  for (const std::string method : {"rrt_connect", "rrt", "est", "prm"}) {
    const Ran ran = run_line({"plan", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml", "--to",
                              "across", "--method", method, "--plot", file.string(), "-o", "json"});
    ASSERT_EQ(ran.code, ExitCode::kDone) << method << ran.err << ran.out;
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    const std::string svg = text.str();
    // One circle per node, one for the start, one for the goal.
    std::size_t circles = 0;
    for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) ++circles;
    EXPECT_EQ(circles, Json::parse(ran.out)["nodes"].get<std::size_t>() + 2) << method;
  }
  std::filesystem::remove(file);
}

TEST(PlanCommand, SaysHowADescentEnded) {
  const ScratchFile wall("wall_scene",
                         "world:\n  collision_objects:\n    - id: wall\n      primitives:\n"
                         "        - {type: box, dimensions: [0.1, 4, 0.2]}\n      primitive_poses:\n"
                         "        - {position: [0, 0, 0], orientation: [0, 0, 0, 1]}\n");
  const Ran ran = run_line({"plan", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/mobile_rectangle.yaml", "--to",
                            "across", "--moveit-scene", wall.path(), "--method", "potential_field", "-o", "json"});
  EXPECT_EQ(ran.code, ExitCode::kNegative) << ran.err;
  const Json plan = Json::parse(ran.out);
  EXPECT_EQ(plan["status"], "stuck");
  EXPECT_NE(plan["reason"].get<std::string>().find("local minimum"), std::string::npos) << plan["reason"];
}

TEST(PlanCommand, RejectsAPotentialFieldOfSeveralArms) {
  const Ran ran =
      run_line({"plan", kPlanCell, "--arm", "north", "--arm", "west", "--to", "ready", "--method", "potential_field"});
  EXPECT_EQ(ran.code, ExitCode::kUsage);
  EXPECT_NE(ran.err.find("for one arm, not for 2"), std::string::npos) << ran.err;
}

}  // namespace
}  // namespace hecaton::services::cli
