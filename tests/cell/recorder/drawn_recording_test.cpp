/// What the page draws of a recording whose messages this test has made: arms by meshes that are in the recording only,
/// the pair of bodies that bounds a motion, rollouts, plots, and the scene from each side.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/planner.h>

#include "services/bus/recorded_sample.hpp"
#include "services/recorder/recorder.hpp"
#include "tests/cell/cli/process.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using namespace services;

constexpr int kJoints = 6;
constexpr double kLength = 6.0;  ///< of the recording [s]

/// A box as ASCII STL, in millimetres.
std::string stl_box(std::array<double, 3> centre, std::array<double, 3> size) {
  std::string text = "solid box\n";
  const auto corner = [&](int bits) {
    std::string line = "vertex";
    for (int axis = 0; axis < 3; ++axis) {
      const double side = (bits >> axis & 1) != 0 ? 0.5 : -0.5;
      line += " " + std::to_string(1000.0 * (centre[axis] + side * size[axis]));
    }
    return line + "\n";
  };
  struct Face {
    const char* normal;
    std::array<int, 4> corners;  ///< of two triangles: a, b, c and c, b, d
  };
  const std::array<Face, 6> faces{{{"0 0 -1", {0, 2, 1, 3}},
                                   {"0 0 1", {4, 5, 6, 7}},
                                   {"0 -1 0", {0, 1, 4, 5}},
                                   {"0 1 0", {2, 6, 3, 7}},
                                   {"-1 0 0", {0, 4, 2, 6}},
                                   {"1 0 0", {1, 3, 5, 7}}}};
  for (const auto& [normal, corners] : faces) {
    const auto& [a, b, c, d] = corners;
    for (const auto& triangle : {std::array{a, b, c}, std::array{c, b, d}}) {
      text += std::string("facet normal ") + normal + "\nouter loop\n";
      for (const int bits : triangle) text += corner(bits);
      text += "endloop\nendfacet\n";
    }
  }
  return text + "endsolid box\n";
}

/// A cube of half a metre around the axis of its link, with a material of its own.
constexpr const char* kObj = R"(mtllib cube.mtl
v -0.2 -0.2 -0.2
v 0.2 -0.2 -0.2
v 0.2 0.2 -0.2
v -0.2 0.2 -0.2
v -0.2 -0.2 0.2
v 0.2 -0.2 0.2
v 0.2 0.2 0.2
v -0.2 0.2 0.2
usemtl green
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
)";

class DrawnRecording : public testing::Test {
 protected:
  void SetUp() override {
    const TemporaryFolder cell;
    config::CellFile file = config::load_cell_file(write_cell(cell));
    recorder::Recording recording({.path = path_}, recorder::attachments_of(file), unix_ns(0.0));
    for (int i = 0; i <= static_cast<int>(kLength * 50.0); ++i) {
      const double time = i / 50.0;
      for (const char* arm : {"north", "west"}) write(recording, state_of(arm, time), time);
      if (i % 5 != 0) continue;
      write(recording, heartbeat(time), time);
      write(recording, mode(), time);
      write(recording, goal(), time);
      write(recording, motion(time), time);
    }
    recording.close();
  }

  /// The robot of `north` has visual elements: two meshes, and two files that are none.
  static std::string write_cell(const TemporaryFolder& cell) {
    const std::string urdf_path = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";
    std::ifstream stream(urdf_path);
    const std::string plain{std::istreambuf_iterator<char>(stream), {}};
    std::string meshed = plain;
    const auto add = [&](const std::string& link, const std::string& mesh, const std::string& material) {
      const std::string begin = "<link name=\"" + link + "\">";
      const std::size_t at = meshed.find(begin);
      ASSERT_NE(at, std::string::npos) << link;
      meshed.insert(at + begin.size(), "<visual><geometry><mesh " + mesh + "/></geometry>" + material + "</visual>");
    };
    add("upper_arm", R"(filename="meshes/upper.stl" scale="0.001 0.001 0.001")",
        R"(<material name="magenta"><color rgba="0.9 0.1 0.9 1"/></material>)");
    add("base_link", R"(filename="meshes/cube.obj")", "");
    add("forearm", R"(filename="meshes/broken.stl")", "");
    add("shoulder", R"(filename="meshes/broken.dae")", "");
    cell.write("plain.urdf", plain);
    cell.write("meshed.urdf", meshed);
    cell.write("meshes/upper.stl", stl_box({0.2159, 0.0, 0.19}, {0.55, 0.2, 0.2}));
    cell.write("meshes/cube.obj", kObj);
    cell.write("meshes/cube.mtl", "newmtl green\nKd 0.1 0.8 0.1\n");
    cell.write("meshes/broken.stl", std::string(200, '\xFF'));
    cell.write("meshes/broken.dae", "<COLLADA><asset>");
    return cell.write("cell.yaml",
                      "name: drawn\n"
                      "defaults: {poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}, start: home}\n"
                      "arms:\n"
                      "  - {name: north, urdf: meshed.urdf}\n"
                      "  - {name: west, urdf: plain.urdf, base: {xyz: [0, 1.6, 0]}}\n");
  }

  static std::uint64_t unix_ns(double time) {
    return 1'700'000'000'000'000'000U + static_cast<std::uint64_t>(std::llround(time * 1e9));
  }
  template <class T>
  void write(recorder::Recording& recording, const T& message, double time) {
    recorder::RecordedSample recorded;
    const auto is_topic = [](const bus::TopicInfo& topic) { return topic.name == bus::Topic<T>::kInfo.name; };
    const auto topic = std::find_if(bus::kTopics.begin(), bus::kTopics.end(), is_topic);
    recorded.sample.topic = static_cast<std::size_t>(topic - bus::kTopics.begin());
    recorded.sample.key = bus::key_of(message);
    recorded.sample.writer.bytes[0] = static_cast<std::uint8_t>(1 + recorded.sample.topic);
    recorded.sample.number = ++number_;
    recorded.sample.bytes = bus::encode_recorded(message);
    ASSERT_FALSE(recorded.sample.bytes.empty());
    recorded.log_time = unix_ns(time);
    recording.write(std::move(recorded));
  }

  /// `north` turns about its first axis; `west` bends its elbow.
  static std::vector<double> q_of(const std::string& arm, double time) {
    std::vector<double> q{0.0, -1.0, 2.6, 0.0, 0.6, 0.0};
    (arm == "north" ? q[0] : q[2]) += arm == "north" ? -1.5 + 0.5 * time : 0.1 * time;
    return q;
  }
  msg::ArmState state_of(const std::string& arm, double time) {
    msg::ArmState state;
    state.arm(arm);
    state.sequence_number(++number_);
    state.mode(msg::ArmMode::ARM_RUNNING);
    state.q(q_of(arm, time));
    state.qd(std::vector<double>(kJoints, 0.0));
    state.qd()[0] = 0.5;
    state.planner("planner/" + arm);
    return state;
  }
  msg::Heartbeat heartbeat(double time) {
    msg::Heartbeat heartbeat;
    heartbeat.node("planner/north");
    heartbeat.kind(msg::NodeKind::NODE_PLANNER);
    heartbeat.subject("north");
    heartbeat.state(msg::NodeState::NODE_RUNNING);
    heartbeat.sequence_number(++number_);
    heartbeat.tick_p99_us(100.0 + 20.0 * time);
    heartbeat.oldest_input("ArmState/west");
    heartbeat.oldest_input_age(0.004 + 0.001 * time);
    return heartbeat;
  }
  static msg::CellMode mode() {
    msg::CellMode mode;
    mode.term(1);
    mode.node("supervisor");
    mode.mode(msg::Mode::MODE_RUN);
    return mode;
  }
  msg::GoalStatus goal() {
    msg::GoalStatus status;
    status.arm("north");
    status.goal("g1");
    status.term(1);
    status.sequence_number(++number_);
    status.node("planner/north");
    status.state(msg::GoalState::GOAL_ACTIVE);
    status.q_goal(q_of("north", kLength));
    status.has_binding(true);
    status.binding_own("north/forearm");
    status.binding_other("west/forearm");
    status.binding_distance(0.137);
    return status;
  }
  static msg::PlannedMotion motion(double time) {
    msg::PlannedMotion motion;
    motion.arm("north");
    motion.node("planner/north");
    motion.way(q_of("north", kLength));
    std::vector<double> foreseen;
    for (const double ahead : {0.5, 1.0}) {
      std::vector<double> q = q_of("north", time + ahead);
      q[1] -= 0.2 * ahead;
      foreseen.insert(foreseen.end(), q.begin(), q.end());
    }
    motion.foreseen(foreseen);
    motion.foreseen_period(0.5);
    return motion;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.path("run.mcap");
  std::uint64_t number_ = 0;
};

TEST_F(DrawnRecording, ShowsMeshesPairsRolloutsAndPlotsInABrowser) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  Process server({std::string(HECATON_BIN_DIR) + "/hecaton", "replay", path_});
  ASSERT_TRUE(server.wait_for_output("\n")) << server.err();
  const std::string url = server.out().substr(0, server.out().find('\n'));
  const char* pictures = std::getenv("HECATON_PICTURES");
  Process test({node, page + "/test/drawn.mjs", url, browser,
                std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf",
                pictures == nullptr ? "" : std::string(pictures) + "/drawn.png"});
  EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
  std::printf("%s", test.out().c_str());
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
}

}  // namespace
}  // namespace hecaton::test
