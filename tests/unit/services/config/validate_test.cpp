// The findings of `hecaton check`. The arm is two links of 1 m in a plane, 2 rad/s, 10 rad/s²; numbers by hand.

#include "services/config/validate.hpp"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "services/config/findings.hpp"

namespace hecaton::config {
namespace {

const std::string kReadyCells = std::string(HECATON_SOURCE_DIR) + "/deploy/cells";
const std::string kInlineFile = std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/inline.yaml";

// Dampers without findings: 20 ms at 0.5 m/s are 10 mm, and 0.5 m/s · (0.2 s + 10 ms) = 105 mm.
const std::string kDamper =
    "    damper: {security_distance: 0.02, influence_distance: 0.13, self_influence_distance: 0.13, "
    "convergence_speed: 0.5}\n";

std::string arm(const std::string& name, const std::string& home, const std::string& more = kDamper) {
  std::string text = "  - name: ";
  text.append(name).append("\n    urdf: urdf/planar_2r.urdf\n    tool: {xyz: [1, 0, 0]}\n    poses: {home: ");
  return text.append(home).append("}\n    limits: {acceleration: 10}\n").append(more);
}

const std::string kHead = "name: test\ntasks: {centre: [1.5, 0, 0], radius: 0.2, half_height: 0}\narms:\n";

std::vector<Finding> findings_of(const std::string& text) {
  std::vector<Finding> findings = validate(parse_cell_file(text, kInlineFile));
  // Notes of the model's loader do not matter here.
  std::erase_if(findings, [](const Finding& one) { return one.sentence.find(".urdf: ") != std::string::npos; });
  return findings;
}

void expect_only(const std::string& text, Severity severity, const std::vector<std::string>& pieces) {
  const auto findings = findings_of(text);
  ASSERT_EQ(findings.size(), 1U) << (findings.empty() ? "" : findings.back().sentence);
  EXPECT_EQ(findings[0].severity, severity);
  for (const std::string& piece : pieces) {
    EXPECT_NE(findings[0].sentence.find(piece), std::string::npos)
        << "no '" << piece << "' in: " << findings[0].sentence;
  }
}

TEST(ValidateTest, FindsNothingInASoundCell) {
  const auto findings = findings_of(kHead + arm("left", "[0, 1]"));
  EXPECT_TRUE(findings.empty()) << findings[0].sentence;
}

TEST(ValidateTest, FindsNoErrorInReadyCells) {
  int cells = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kReadyCells)) {
    if (entry.path().extension() != ".yaml") continue;
    ++cells;
    for (const Finding& finding : validate(load_cell_file(entry.path().string()))) {
      EXPECT_NE(finding.severity, Severity::kError) << entry.path() << ": " << finding.sentence;
    }
  }
  EXPECT_GE(cells, 3);
}

TEST(ValidateTest, FindsNoWarningInThreePuma) {
  for (const Finding& finding : validate(load_cell_file(kReadyCells + "/three_puma.yaml"))) {
    EXPECT_EQ(finding.severity, Severity::kNote) << finding.sentence;
  }
}

TEST(ValidateTest, WarnsWhenSecurityDistanceDoesNotCoverLatency) {
  // 10 + 10 ms at 0.5 m/s: 10 mm.
  expect_only(kHead + arm("left", "[0, 1]",
                          "    damper: {security_distance: 0.009, influence_distance: 0.13, "
                          "self_influence_distance: 0.13, convergence_speed: 0.5}\n"),
              Severity::kWarning, {"arms[0].damper.security_distance = 0.009", "at least 0.01 m", "20 ms"});
}

TEST(ValidateTest, WarnsWhenInfluenceDistanceIsTooShortToBrake) {
  // Stops take 2/10 s and a period of 10 ms to begin: 1 m/s · 0.21 s = 0.21 m before 0.03 m. Between links of one arm
  // with a reach of 2 m: before 0.02 m.
  expect_only(kHead + arm("left", "[0, 1]",
                          "    damper: {security_distance: 0.03, influence_distance: 0.2, "
                          "self_influence_distance: 0.23, convergence_speed: 1.0}\n"),
              Severity::kWarning, {"arms[0].damper.influence_distance = 0.2 ", "at least 0.24 m", "210 ms"});
  expect_only(kHead + arm("left", "[0, 1]",
                          "    damper: {security_distance: 0.03, influence_distance: 0.24, "
                          "self_influence_distance: 0.2, convergence_speed: 1.0}\n"),
              Severity::kWarning, {"arms[0].damper.self_influence_distance = 0.2 ", "at least 0.23 m"});
}

// Half of 100 mm between two of eleven beams, and three times 4 mm of noise.
TEST(ValidateTest, WarnsWhenMarginDoesNotCoverBeamSpacing) {
  const auto with = [](const std::string& margin, const std::string& method) {
    return kHead + arm("left", "[0, 1]",
                       kDamper + "    method: " + method + "\n    sensed: {margin: " + margin +
                           "}\n    sensors:\n      - {name: side, link: fore, position: [0, 0.1, 0], to_position: "
                           "[1, 0.1, 0], direction: [0, 1, 0], rays: 11, noise: 0.004}\n");
  };
  expect_only(with("0.05", "sensed_cspace"), Severity::kWarning,
              {"arms[0].sensed.margin = 0.05", "at least 0.062 m", "sensor side", "three times its noise"});
  EXPECT_TRUE(findings_of(with("0.062", "sensed_cspace")).empty());
  EXPECT_TRUE(findings_of(with("0.05", "local")).empty()) << "the method does not use sensors";
}

TEST(ValidateTest, WarnsOfThePublishedMapper) {
  const std::string method = "    method: known_cspace\n    sensed: {mapper: ";
  expect_only(kHead + arm("left", "[0, 1]", kDamper + method + "published}\n"), Severity::kWarning,
              {"arms[0].sensed.mapper = published", "touches an obstacle", "in simulation only"});
  EXPECT_TRUE(findings_of(kHead + arm("left", "[0, 1]", kDamper + method + "exact}\n")).empty());
}

TEST(ValidateTest, FindsNoMarginWarningInReadyCells) {
  for (const char* cell : {"planar_2r", "puma_sensed"}) {
    for (const Finding& finding : validate(load_cell_file(kReadyCells + "/" + cell + ".yaml"))) {
      EXPECT_EQ(finding.sentence.find("sensed.margin"), std::string::npos) << finding.sentence;
    }
  }
}

TEST(ValidateTest, WarnsWhenPosesAreTooNearToStaticObstacles) {
  // The upper arm is 0.08 m wide, the wall begins at y = −0.05.
  expect_only(
      kHead + arm("left", "[0, 1]") +
          "obstacles:\n  - {name: wall, shapes: [{type: box, size: [0.2, 0.1, 1]}], pose: {xyz: [0.5, -0.1, 0]}}\n",
      Severity::kWarning, {"arms[0].poses.home", "left/upper", "wall", "10 mm apart", "20 mm"});
}

TEST(ValidateTest, WarnsWhenStartsAreTooNear) {
  // Stretched arms end 1.9 m from their bases: 3.81 − 2 · 1.9 = 0.01 m between them.
  expect_only("name: test\ntasks: {centre: [1.905, 0, 0], radius: 0.05, half_height: 0}\narms:\n" +
                  arm("left", "[0, 0]") + arm("right", "[0, 0]") +
                  "    base: {xyz: [3.81, 0, 0], rpy: [0, 0, 3.141592653589793]}\n",
              Severity::kWarning, {"arms[1].start", "right/fore", "left/fore", "10 mm apart", "20 mm"});
}

TEST(ValidateTest, WarnsWhenStopsAreTooNear) {
  // The same at a stop; at the start one points along y, the other against it.
  const std::string poses = "[1.5, 0], out: [0, 0]";
  expect_only("name: test\ntasks: {pose_sequence: [home, out]}\narms:\n" + arm("left", poses) + arm("right", poses) +
                  "    base: {xyz: [3.81, 0, 0], rpy: [0, 0, 3.141592653589793]}\n",
              Severity::kWarning, {"tasks.pose_sequence[1] = out", "right/fore", "left/fore", "10 mm apart", "20 mm"});
}

TEST(ValidateTest, WarnsWhenObstaclesPassThroughBases) {
  // A ball of radius 0.1 moves to the axis of the base, a cylinder of radius 0.1 and height 0.2. The overlap is 0.2 m
  // in either direction.
  expect_only(kHead + arm("left", "[0, 1]") +
                  "obstacles:\n  - name: ball\n    shapes: [{type: sphere, radius: 0.1}]\n    pose: {xyz: [-1, 0, 0]}\n"
                  "    motion: {type: sine, direction: [1, 0, 0], amplitude: 1, period: 6s}\n",
              Severity::kWarning, {"obstacles[0].motion", "left/base", "ball", "overlap by 200 mm"});
}

TEST(ValidateTest, WarnsWhenObstaclesAreFasterThanArms) {
  // The tool gets to 2 · 2 m/s + 2 · 1 m/s = 6 m/s.
  expect_only(kHead + arm("left", "[0, 1]") +
                  "obstacles:\n  - name: train\n    shapes: [{type: sphere, radius: 0.1}]\n    pose: {xyz: [9, 9, 0]}\n"
                  "    motion: {type: conveyor, direction: [1, 0, 0], speed: 7, length: 20}\n",
              Severity::kWarning, {"obstacles[0].motion", "7 m/s", "an arm's tool"});
}

TEST(ValidateTest, WarnsWhenObstaclesAccelerateMoreThanArmsAssume) {
  // 2 rad/s at 1 m: 4 m/s².
  const std::string ball =
      "obstacles:\n  - name: ball\n    shapes: [{type: sphere, radius: 0.1}]\n    pose: {xyz: [10, 9, 0]}\n"
      "    motion: {type: circle, centre: [9, 9, 0], axis: [0, 0, 1], angular_speed: 2}\n";
  expect_only(kHead + arm("left", "[0, 1]") + ball, Severity::kWarning,
              {"obstacles[0].motion", "up to 4 m/s²", "arms[0].acceleration_of_obstacles = 2"});
  EXPECT_TRUE(
      findings_of(kHead + arm("left", "[0, 1]", kDamper + "    acceleration_of_obstacles: 4\n") + ball).empty());
}

TEST(ValidateTest, WarnsWhenObstaclesJumpWithinReach) {
  const auto conveyor = [](const std::string& x) {
    return "obstacles:\n  - name: train\n    shapes: [{type: sphere, radius: 0.1}]\n    pose: {xyz: [" + x +
           ", 1, 0]}\n    motion: {type: conveyor, direction: [1, 0, 0], speed: 0.3, length: 2}\n";
  };
  expect_only(kHead + arm("left", "[0, 1]") + conveyor("-0.5"), Severity::kWarning,
              {"obstacles[0].motion starts again at (-0.5, 1, 0)", "reach of arms[0]"});
  EXPECT_TRUE(findings_of(kHead + arm("left", "[0, 1]") + conveyor("-4")).empty());
}

TEST(ValidateTest, WarnsWhenObstaclesTurnAtOnceWithinReach) {
  const auto comet = [](const std::string& speed, const std::string& end) {
    return "obstacles:\n  - name: comet\n    shapes: [{type: sphere, radius: 0.1}]\n    motion: {type: waypoints, "
           "speed: " +
           speed + ", loop: false, poses: [{xyz: [-4, 1, 0]}, {xyz: [" + end + ", 1, 0]}]}\n";
  };
  expect_only(kHead + arm("left", "[0, 1]") + comet("0.4", "0.5"), Severity::kWarning,
              {"obstacles[0].motion changes its velocity by 0.8 m/s at once at (0.5, 1, 0)", "reach of arms[0]"});
  EXPECT_TRUE(findings_of(kHead + arm("left", "[0, 1]") + comet("0.4", "4")).empty());
  EXPECT_TRUE(findings_of(kHead + arm("left", "[0, 1]") + comet("0.04", "0.5")).empty())
      << "the change of velocity is small";
}

TEST(ValidateTest, ReportsAnErrorWhenTheTaskAreaIsOutOfReach) {
  expect_only("name: test\ntasks: {centre: [5, 0, 0], radius: 0.2, half_height: 0}\narms:\n" + arm("left", "[0, 1]"),
              Severity::kError, {"tasks", "arms[0] (left)", "no part"});
}

TEST(ValidateTest, CountsPointsOfTheTaskAreaOutOfReach) {
  // The disc is around (2, 0), the arm reaches 2 m. It reaches the centre, and three points of each ring: those at
  // 135°, 180° and 225°. At 90° and 270° the distance is √(4 + r²) > 2. Seven points at each of three equal heights
  // make 21 of 51, less than half.
  expect_only(
      "name: test\ntasks: {centre: [1.9995, 0, 0], radius: 0.2, half_height: 0}\narms:\n" + arm("left", "[0, 1]"),
      Severity::kWarning, {"arms[0] (left)", "21 of 51"});
}

TEST(ValidateTest, NotesMissingTasksAndStandbys) {
  const auto open = findings_of("name: test\narms:\n" + arm("left", "[0, 1]"));
  EXPECT_TRUE(std::any_of(open.begin(), open.end(), [](const Finding& one) {
    return one.severity == Severity::kNote && one.sentence.find("tasks is missing: goals are drawn") == 0;
  }));
  expect_only(
      "name: test\nsecurity: {keystore: keys}\nhosts: {a: 10.0.0.1, b: 10.0.0.2}\nworld: {host: a}\n"
      "supervision: {host: a, standby_host: b}\ntasks: {centre: [1.5, 0, 0], radius: 0.2, half_height: 0}\narms:\n" +
          arm("left", "[0, 1]") + "    host: a\n",
      Severity::kNote, {"arms[0].standby_host is missing"});
}

TEST(ValidateTest, WarnsOfAnOpenCellThatSpansHosts) {
  expect_only(
      "name: test\nhosts: {a: 10.0.0.1, b: 10.0.0.2}\nworld: {host: a}\nsupervision: {host: a, standby_host: b}\n"
      "tasks: {centre: [1.5, 0, 0], radius: 0.2, half_height: 0}\narms:\n" +
          arm("left", "[0, 1]") + "    host: a\n    standby_host: b\n",
      Severity::kWarning, {"the cell spans hosts and is open", "security.keystore locks it"});
}

TEST(ValidateTest, WarnsOfOneDomainForTheCellAndRos2) {
  const auto with_domain = [](const std::string& domain) {
    return "name: test\nros2: {domain: " + domain +
           "}\ntasks: {centre: [1.5, 0, 0], radius: 0.2, half_height: 0}\narms:\n" + arm("left", "[0, 1]");
  };
  expect_only(with_domain("42"), Severity::kWarning, {"ros2.domain and network.domain are 42", "choose another"});
  EXPECT_TRUE(findings_of(with_domain("7")).empty());
}

// A cell with URDF and base alone has to work, and tells once what it guesses.
TEST(ValidateTest, NotesEachGuessOnceInACellOfUrdfAndBase) {
  const CellFile file = parse_cell_file(
      "name: test\narms:\n  - {name: left, urdf: urdf/planar_2r.urdf, tool: {xyz: [1, 0, 0]}}\n"
      "  - {name: right, urdf: urdf/planar_2r.urdf, tool: {xyz: [1, 0, 0]}, base: {xyz: [2.5, 0, 0]}}\n",
      kInlineFile);
  int guesses = 0;
  for (const Finding& finding : validate(file)) {
    EXPECT_EQ(finding.severity, Severity::kNote) << finding.sentence;
    for (const char* key : {"tasks is missing", "poses.home of arms left, right is missing",
                            "limits.acceleration of arms left, right is missing"}) {
      guesses += finding.sentence.starts_with(key) ? 1 : 0;
    }
  }
  EXPECT_EQ(guesses, 3);
  for (const planner::PlannedArm& planned : file.cell.arms) {
    EXPECT_EQ(planned.start, planned.arm.home());
    EXPECT_TRUE(planned.arm.limits.acceleration.isApprox(planned.arm.limits.velocity / planner::kAssumedRunUp));
  }
}

TEST(ValidateTest, SortsErrorsFirst) {
  const auto findings =
      findings_of("name: test\ntasks: {centre: [5, 0, 0], radius: 0.2}\narms:\n" +
                  arm("left", "[0, 1]", "    damper: {security_distance: 0.001, convergence_speed: 0.5}\n"));
  ASSERT_GE(findings.size(), 2U);
  EXPECT_EQ(findings.front().severity, Severity::kError);
  EXPECT_TRUE(std::is_sorted(findings.begin(), findings.end(),
                             [](const Finding& a, const Finding& b) { return a.severity > b.severity; }));
}

TEST(TopSpeedTest, MatchesAStretchedPlanarArm) {
  const CellFile file = parse_cell_file(kHead + arm("left", "[0, 1]"), kInlineFile);
  // ‖v‖² = (2·1)² + (4·1)² + 2·2·4·cos q₂ at full speed: 6 m/s when stretched; 300 samples come near that.
  const double speed = top_tool_speed(file.cell.arms[0].arm);
  EXPECT_LE(speed, 6.0 + 1e-9);
  EXPECT_GE(speed, 5.95);
}

}  // namespace
}  // namespace hecaton::config
