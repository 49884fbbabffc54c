#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "planner/model/kinematics.hpp"
#include "services/agent/service_plan.hpp"
#include "services/bus/endpoint.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/view/cell_json.hpp"
#include "services/view/view_service.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using test::WebSocketClient;
using view::Json;

const std::string kCells = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/";

// --- the cell file

std::string one_arm(const std::string& view, const std::string& urdf = kCells + "urdf/puma560.urdf") {
  return "name: one\n" + view + "arms:\n  - {name: arm1, urdf: " + urdf + ", allow_bare_links: true}\n";
}

std::string error_of(const std::string& view) {
  try {
    static_cast<void>(config::parse_cell_file(one_arm(view), "cell.yaml"));
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ViewInCellFile, HasDefaults) {
  EXPECT_FALSE(config::parse_cell_file(one_arm(""), "cell.yaml").view);
  const auto file = config::parse_cell_file(one_arm("view: {}\n"), "cell.yaml");
  ASSERT_TRUE(file.view);
  EXPECT_EQ(file.view->host, "localhost");
  EXPECT_EQ(config::view_url(*file.view, 42), "http://127.0.0.1:8042/");
  const auto open = config::parse_cell_file(one_arm("view: {listen: 0.0.0.0, port: 80}\n"), "cell.yaml");
  EXPECT_EQ(config::view_url(*open.view, 42), "https://localhost:80/");
}

TEST(ViewInCellFile, RefusesBadAddressesAndPorts) {
  EXPECT_EQ(error_of("view: {listen: everywhere}\n"),
            "cell.yaml: view.listen = everywhere must be an IPv4 address of the host: 127.0.0.1 for this host alone, "
            "0.0.0.0 for all of its networks");
  EXPECT_EQ(error_of("view: {port: 70000}\n"), "cell.yaml: view.port = 70000 must be a whole number from 1 to 65535");
  EXPECT_NE(error_of("view: {adress: 127.0.0.1}\n").find("view.adress"), std::string::npos);
}

TEST(ViewInCellFile, RefusesACertificateWithoutItsKey) {
  EXPECT_EQ(error_of("view: {certificate: page.pem}\n"),
            "cell.yaml: view.key = none must be the file of the private key of `certificate`");
  EXPECT_EQ(error_of("view: {key: page-key.pem}\n"),
            "cell.yaml: view.certificate = none must be the file of the certificate of `key`");
}

TEST(ViewInCellFile, MakesTheAgentStartIt) {
  const auto services = plan_services(config::parse_cell_file(one_arm("view: {}\n"), "cell.yaml"), "localhost");
  EXPECT_EQ(services.back().program, "hecaton-view");
  EXPECT_EQ(services.back().node, "view");
  const auto without = plan_services(config::parse_cell_file(one_arm(""), "cell.yaml"), "localhost");
  EXPECT_EQ(without.size() + 1, services.size());
}

// --- robots with meshes

constexpr const char* kTriangle =
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid "
    "s\n";
constexpr const char* kUrdf = R"(<robot name="r"><link name="base"/>
  <link name="tip"><visual><geometry><mesh filename="package://arms/meshes/tip &amp; more.stl"/></geometry></visual>
    <visual><geometry><mesh filename='missing.stl'/></geometry></visual>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)";

TEST(ArmDrawingTest, ServesTheMeshesOfTheUrdfAndNothingElse) {
  const test::TemporaryFolder folder;
  folder.write("arms/meshes/tip & more.stl", kTriangle);
  folder.write("arms/meshes/skin.png", "png");
  folder.write("arms/secret.txt", "secret");
  const std::string urdf = folder.write("arms/urdf/r.urdf", kUrdf);
  const view::Drawings drawings(config::parse_cell_file(one_arm("", urdf), folder.path("cell.yaml")));
  ASSERT_EQ(drawings.arms().size(), 1U);
  const view::ArmDrawing& arm = drawings.arms().front();
  EXPECT_TRUE(arm.has_visuals);
  EXPECT_EQ(arm.url, "/robots/0.urdf");
  EXPECT_NE(arm.urdf.find("filename=\"/meshes/0/tip___more.stl\""), std::string::npos) << arm.urdf;
  EXPECT_NE(arm.urdf.find("filename=''"), std::string::npos) << "a mesh that does not exist";
  EXPECT_NE(arm.note.find("missing.stl"), std::string::npos) << arm.note;
  ASSERT_TRUE(drawings.mesh("/meshes/0/tip___more.stl"));
  EXPECT_TRUE(std::filesystem::exists(*drawings.mesh("/meshes/0/tip___more.stl")));
  EXPECT_TRUE(drawings.mesh("/meshes/0/skin.png"));
  for (const char* path :
       {"/meshes/0/../secret.txt", "/meshes/0/../../x.png", "/meshes/0/secret.txt", "/meshes/0//x.png",
        "/meshes/1/tip___more.stl", "/meshes/", "/meshes/0", "/meshes/-1/a.png", "/etc/passwd"}) {
    EXPECT_FALSE(drawings.mesh(path)) << path;
  }
}

TEST(CellJson, HasTheLinksAndShapesOfEachArm) {
  const config::CellFile file = config::load_cell_file(kCells + "three_puma.yaml");
  const view::Drawings drawings(file);
  const Json cell = view::cell_json(file, drawings.arms());
  ASSERT_EQ(cell.at("arms").size(), 3U);
  const Json& north = cell.at("arms")[0];
  const planner::Arm& arm = file.cell.arms[0].arm;
  EXPECT_EQ(north.at("links").size(), arm.model->links.size());
  EXPECT_EQ(north.at("shapes").size(), arm.model->geometry.size());
  EXPECT_EQ(north.at("joints").size(), 6U);
  EXPECT_EQ(north.at("security_distance"), 0.03);
  EXPECT_TRUE(north.at("urdf").is_null()) << "it has no visual elements";
  EXPECT_EQ(north.at("start").size(), 6U);
}

// --- a cell on the bus

/// What a driver, a planner, a world and a supervisor publish, and a view of it.
class LiveViewTest : public testing::Test {
 protected:
  LiveViewTest() : file_(config::load_cell_file(kCells + "three_puma.yaml")) {
    ServiceOptions options;
    options.domain = domain_.number();
    config::View address;
    address.host = "localhost";
    address.port = 0;
    view_.emplace(file_, options, address, ViewOrders{}, std::vector<std::string>{}, shutdown_);
    bus::ParticipantOptions participant;
    participant.partition = file_.cell.name;
    participant_.emplace(domain_.number(), "test", participant);
    thread_ = std::thread([this] { view_->run(); });
    writers_.emplace(*participant_);
  }
  ~LiveViewTest() override {
    shutdown_.request();
    thread_.join();
  }

  struct Writers {
    explicit Writers(bus::Participant& participant)
        : state(participant),
          goal(participant),
          mode(participant),
          fault(participant),
          heartbeat(participant),
          shapes(participant),
          obstacles(participant),
          tool(participant),
          motion(participant) {}
    bus::Writer<msg::ArmState> state;
    bus::Writer<msg::GoalStatus> goal;
    bus::Writer<msg::CellMode> mode;
    bus::Writer<msg::Fault> fault;
    bus::Writer<msg::Heartbeat> heartbeat;
    bus::Writer<msg::ObstacleShapes> shapes;
    bus::Writer<msg::ObstacleStates> obstacles;
    bus::Writer<msg::ToolState> tool;
    bus::Writer<msg::PlannedMotion> motion;
  };

  [[nodiscard]] std::uint16_t port() const {
    // "http://127.0.0.1:PORT/"
    const std::string url = view_->url();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }

  void publish_mode() {
    msg::CellMode mode;
    mode.term(1);
    mode.sequence_number(++sequence_);
    mode.node("supervisor");
    mode.mode(msg::Mode::MODE_RUN);
    ASSERT_TRUE(writers_->mode.write(mode));
  }
  void publish_state(double q) {
    msg::ArmState state;
    state.arm("north");
    state.mode(msg::ArmMode::ARM_RUNNING);
    state.sequence_number(++sequence_);
    state.q(std::vector<double>(6, q));
    state.qd(std::vector<double>(6, 0.0));
    ASSERT_TRUE(writers_->state.write(state));
  }
  void publish_heartbeats() {
    for (const char* node : {"driver/north", "planner/north", "world"}) {
      msg::Heartbeat heartbeat;
      heartbeat.node(node);
      heartbeat.host("localhost");
      heartbeat.state(msg::NodeState::NODE_RUNNING);
      heartbeat.sequence_number(++sequence_);
      ASSERT_TRUE(writers_->heartbeat.write(heartbeat));
    }
  }
  void publish_goal(msg::GoalState state) {
    msg::GoalStatus goal;
    goal.arm("north");
    goal.goal("g1");
    goal.term(1);
    goal.sequence_number(++sequence_);
    goal.state(state);
    goal.cause(make_cause(msg::CauseKind::CAUSE_PATH_BLOCKED, "west", "no way for now"));
    goal.has_binding(true);
    goal.binding_own("north/wrist");
    goal.binding_other("west/forearm");
    goal.binding_distance(0.031);
    goal.q_goal(std::vector<double>(6, 0.5));
    ASSERT_TRUE(writers_->goal.write(goal));
  }
  static Json arm(const Json& status, const std::string& name) {
    for (const Json& one : status.at("arms")) {
      if (one.at("name") == name) return one;
    }
    return nullptr;
  }

  test::FreeDomain domain_;
  ShutdownSignal shutdown_;
  config::CellFile file_;
  std::optional<ViewService> view_;
  std::optional<bus::Participant> participant_;
  std::thread thread_;
  std::optional<Writers> writers_;
  std::uint64_t sequence_ = 0;
};

TEST_F(LiveViewTest, ShowsStatesReasonsAndFaultsOfARunningCell) {
  WebSocketClient page(port());
  const Json cell = page.wait_for("cell", [](const Json&) { return true; });
  EXPECT_EQ(cell.at("name"), "three_puma");

  ASSERT_TRUE(writers_->state.wait_matched(1, 20s));
  ASSERT_TRUE(writers_->heartbeat.wait_matched(1, 20s));
  ASSERT_TRUE(writers_->goal.wait_matched(1, 20s));
  ASSERT_TRUE(writers_->mode.wait_matched(1, 20s));
  publish_mode();
  publish_goal(msg::GoalState::GOAL_BLOCKED);
  const Json frame = page.wait_for("frame", [&](const Json& message) {
    publish_state(0.25);
    publish_heartbeats();
    return !message.at("arms")[0][0].is_null();
  });
  EXPECT_EQ(frame.at("arms")[0][1], Json(std::vector<double>(6, 0.25)));
  EXPECT_GT(frame.at("arms")[0][2].get<std::uint64_t>(), 0U) << "the number of the state";
  EXPECT_TRUE(frame.at("arms")[1][0].is_null()) << "west has sent nothing";

  const Json status = page.wait_for("status", [&](const Json& message) {
    publish_mode();  // best-effort: the first one may have come before its reader was matched
    publish_state(0.25);
    publish_heartbeats();
    const Json waiting = arm(message, "north").at("waiting");
    return waiting.is_object() && waiting.at("kind") == "path_blocked";
  });
  const Json north = arm(status, "north");
  EXPECT_EQ(north.at("waiting").at("text"), "blocked: no way for now (north/wrist – west/forearm, 31 mm)")
      << "as `hecaton status` says it";
  EXPECT_EQ(north.at("goal").at("binding").at("distance"), 0.031);
  EXPECT_EQ(north.at("goal").at("q").size(), 6U);
  EXPECT_EQ(status.at("mode"), "run");
  EXPECT_GE(status.at("mode_age").get<double>(), 0.0);
  EXPECT_TRUE(north.at("tool").is_null()) << "no gripper was heard";

  msg::ToolState tool;
  tool.arm("north");
  tool.sequence_number(1);
  tool.has_gripper(true);
  tool.width(0.04);
  tool.holding("crate");
  ASSERT_TRUE(writers_->tool.write(tool));
  const Json gripper = page.wait_for("status", [&](const Json& message) {
    publish_state(0.25);
    return !arm(message, "north").at("tool").is_null();
  });
  EXPECT_EQ(arm(gripper, "north").at("tool"), (Json{{"moving", false}, {"width", 0.04}, {"holding", "crate"}}));

  msg::Fault fault;
  fault.id("f1");
  fault.term(1);
  fault.sequence_number(1);
  fault.severity(msg::Severity::SEVERITY_ERROR);
  fault.cause(make_cause(msg::CauseKind::CAUSE_NODE_SILENT, "driver/north", "driver/north is silent"));
  ASSERT_TRUE(writers_->fault.wait_matched(1, 20s));
  ASSERT_TRUE(writers_->fault.write(fault));
  const Json faulty = page.wait_for("status", [](const Json& message) { return !message.at("faults").empty(); });
  EXPECT_EQ(faulty.at("faults")[0].at("kind"), "node_silent");
  EXPECT_TRUE(faulty.at("faults")[0].at("duration").is_null()) << "open";
  EXPECT_EQ(arm(faulty, "north").at("waiting").at("kind"), "node_silent");
}

TEST_F(LiveViewTest, AgesGrowWhenStatesCease) {
  WebSocketClient page(port());
  ASSERT_TRUE(writers_->state.wait_matched(1, 20s));
  static_cast<void>(page.wait_for("frame", [&](const Json& message) {
    publish_state(0.25);
    return !message.at("arms")[0][0].is_null();
  }));
  const auto next_age = [&] {
    return page.wait_for("frame", [](const Json&) { return true; }).at("arms")[0][0].get<double>();
  };
  for (int i = 0; i < 3; ++i) static_cast<void>(next_age());  // the last state may still be on its way
  double before = next_age();
  for (int i = 0; i < 5; ++i) {
    const double age = next_age();
    EXPECT_GT(age, before);
    before = age;
  }
}

TEST_F(LiveViewTest, HasTheWayOfTheToolUntilThePlannerIsSilent) {
  WebSocketClient page(port());
  ASSERT_TRUE(writers_->state.wait_matched(1, 20s));
  ASSERT_TRUE(writers_->heartbeat.wait_matched(1, 20s));
  ASSERT_TRUE(writers_->motion.wait_matched(1, 20s));
  msg::PlannedMotion motion;
  motion.arm("north");
  motion.node("planner/north");
  const std::vector<double> target{0.5, 0.25, 0.25, 0.25, 0.25, 0.25};
  motion.way(target);
  motion.foreseen(std::vector<double>(12, 0.3));
  motion.foreseen_period(1000.0);
  ASSERT_TRUE(writers_->motion.write(motion));
  const Json shown = page.wait_for("motions", [&](const Json& message) {
    publish_state(0.25);
    publish_heartbeats();
    return !message.at("arms")[0].at("way").empty();
  });
  const auto tool_at = [&](const std::vector<double>& q) {
    const planner::Arm& arm = file_.cell.arms[0].arm;
    planner::Kinematics kinematics;
    planner::forward_kinematics(*arm.model, arm.X_WB, Eigen::Map<const Eigen::VectorXd>(q.data(), 6), kinematics);
    return kinematics.X_WT.translation().eval();
  };
  const auto expect_at = [](const Json& point, const Eigen::Vector3d& p_W) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(point[k].get<double>(), p_W[k], 1e-4);
  };
  const Json& way = shown.at("arms")[0].at("way");
  EXPECT_GT(way.size(), 3U) << "a tool moves on a curve";
  expect_at(way.front(), tool_at(std::vector<double>(6, 0.25)));
  expect_at(way.back(), tool_at(target));
  const Json& foreseen = shown.at("arms")[0].at("foreseen");
  EXPECT_EQ(foreseen.size(), 3U) << "the measured position, and both points";
  expect_at(foreseen.back(), tool_at(std::vector<double>(6, 0.3)));
  EXPECT_TRUE(shown.at("arms")[1].at("way").empty());

  static_cast<void>(page.wait_for("motions", [&](const Json& message) {
    publish_state(0.25);
    return message.at("arms")[0].at("way").empty();
  }));
}

TEST_F(LiveViewTest, FollowsObstaclesThatComeAndGo) {
  WebSocketClient page(port());
  ASSERT_TRUE(writers_->shapes.wait_matched(1, 20s));
  msg::ObstacleShapes shapes;
  shapes.name("crate");
  shapes.obstacle().name("crate");
  shapes.obstacle().shapes().resize(1);
  shapes.obstacle().shapes()[0].kind(msg::ShapeKind::SHAPE_BOX);
  msg::Vec3 half;
  half.x(0.1);
  half.y(0.2);
  half.z(0.3);
  shapes.obstacle().shapes()[0].dimensions(half);
  ASSERT_TRUE(writers_->shapes.write(shapes));
  const Json added = page.wait_for("obstacles", [](const Json& message) { return !message.at("obstacles").empty(); });
  EXPECT_EQ(added.at("obstacles")[0].at("name"), "crate");
  EXPECT_EQ(added.at("obstacles")[0].at("shapes")[0].at("size"), Json({0.2, 0.4, 0.6}));
  ASSERT_TRUE(writers_->shapes.retire(shapes));
  static_cast<void>(page.wait_for("obstacles", [](const Json& message) { return message.at("obstacles").empty(); }));
}

TEST_F(LiveViewTest, ServesThePage) {
  const auto answer = test::request(port(), "/");
  EXPECT_EQ(answer.result(), test::http::status::ok);
  EXPECT_NE(answer.body().size(), 0U);
}

}  // namespace
}  // namespace hecaton::services
