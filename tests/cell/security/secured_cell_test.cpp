/// A cell with keys: it works, and participants without the right keys see nothing and move nothing.

#include <filesystem>
#include <fstream>
#include <optional>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/recorder.h>

#include "services/bus/endpoint.hpp"
#include "services/security/keystore.hpp"
#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::test {
namespace {

using services::Role;

class SecuredCell : public LiveCell {
 protected:
  void SetUp() override {
    write_cell(cell_file(), "security: {keystore: keys}\n");
    write_cell(open_file(), "");
    services::create_keystore(keystore(), std::chrono::days(2));
    const Ran keys = run({"keystore", "add", keystore().string(), "--for", cell_file(), "--days", "1"});
    ASSERT_EQ(keys.code, 0) << keys.err;
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path() / "cell.yaml"; }
  [[nodiscard]] std::string open_file() const { return folder_.path() / "open.yaml"; }
  [[nodiscard]] std::filesystem::path keystore() const { return folder_.path() / "keys"; }
  [[nodiscard]] std::filesystem::path identity(Role role) const {
    const bool of_people = role == Role::kOperator || role == Role::kViewer;
    return services::enclave_folder(keystore(), of_people ? services::kPeople : "localhost", role);
  }

  static void write_cell(const std::string& path, const std::string& security) {
    std::ofstream(path)
        << "name: secured\n"
        << security
        // Encryption on a busy machine of two processors: a cell of a lower rate.
        << "timing: {control_period: 20ms, driver_period: 4ms, world_period: 20ms, command_timeout: 400ms}\n"
           "supervision: {heartbeat_deadline: 250ms, host_lease: 1s}\n"
           "defaults: {robot: ur5e}\n"
           "arms:\n"
           "  - {name: north, base: {xyz: [0, 0.8, 0]}}\n"
           "  - {name: south, base: {xyz: [0, -0.8, 0]}}\n";
  }
  [[nodiscard]] Ran run_with(const std::string& file, std::vector<std::string> words) const {
    words.insert(words.end(), {"--cell", file});
    return run(std::move(words));
  }
  void reach(const std::string& arm, const std::string& named) const {
    const Ran ran = run_with(cell_file(), {"goal", arm, "--named", named, "--wait", "--time-limit", "60s"});
    EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
  }
  [[nodiscard]] bus::Participant participant(const std::string& name, std::optional<Role> role) const {
    bus::ParticipantOptions options;
    options.partition = "secured";
    if (role) options.identity = identity(*role);
    return {domain_.number(), name, options};
  }

  TemporaryFolder folder_;
};

/// The same cell without keys.
class OpenCell : public SecuredCell {
 protected:
  [[nodiscard]] std::string cell_file() const override { return open_file(); }
};

// What the keys prevent.
TEST_F(OpenCell, ShowsItsStatesToAnyParticipantAndTakesItsGoals) {
  bus::Participant intruder = participant("intruder", std::nullopt);
  bus::Reader<msg::ArmState> stolen(intruder);
  bus::Reader<msg::GoalStatus> statuses(intruder);
  bus::Writer<msg::Goal> goals(intruder);
  ASSERT_TRUE(goals.wait_matched(1, kPatience));
  msg::Goal goal;
  goal.arm("north");
  goal.goal("of an intruder");
  goal.kind(msg::GoalKind::GOAL_NAMED);
  goal.named("ready");
  ASSERT_TRUE(goals.write(goal));
  bool reached = false;
  const auto until = bus::Clock::now() + kPatience;
  while (!reached && bus::Clock::now() < until) {
    static_cast<void>(statuses.wait_for_data(std::chrono::seconds(1)));
    for (const auto& sample : statuses.take()) {
      reached |= sample.value.goal() == goal.goal() && sample.value.state() == msg::GoalState::GOAL_REACHED;
    }
  }
  EXPECT_TRUE(reached);
  EXPECT_FALSE(stolen.take().empty());
}

TEST_F(SecuredCell, ServesOnlyParticipantsWithItsKeys) {
  reach("north", "ready");
  reach("south", "ready");

  const Ran open = run_hecaton({"status", "--cell", open_file(), "--domain", domain(), "--connect-timeout", "3s"});
  EXPECT_EQ(open.code, 5) << open.out << open.err;
  EXPECT_NE(open.err.find("of another cell, or of one with keys"), std::string::npos) << open.err;

  // An open intruder matches no endpoint, while a viewer with keys sees all states.
  bus::Participant intruder = participant("intruder", std::nullopt);
  bus::Writer<msg::CellMode> modes(intruder);
  bus::Writer<msg::ArmCommand> commands(intruder);
  bus::Writer<msg::Goal> goals(intruder);
  bus::Reader<msg::ArmState> stolen(intruder);
  bus::Participant viewer = participant("viewer", Role::kViewer);
  bus::Reader<msg::ArmState> seen(viewer);
  const auto until = bus::Clock::now() + kPatience;
  int states = 0;
  while (states < 500 && bus::Clock::now() < until) {
    static_cast<void>(seen.wait_for_data(std::chrono::seconds(1)));
    for (const auto& sample : seen.take()) states += sample.disposed ? 0 : 1;
    msg::CellMode stop;
    stop.term(2);
    stop.mode(msg::Mode::MODE_STOP);
    static_cast<void>(modes.write(stop));
  }
  EXPECT_GE(states, 500);
  EXPECT_EQ(modes.matched(), 0);
  EXPECT_EQ(commands.matched(), 0);
  EXPECT_EQ(goals.matched(), 0);
  EXPECT_EQ(stolen.matched(), 0);
  EXPECT_TRUE(stolen.take().empty());
  reach("north", "home");

  // Its keys expire within the lead time.
  const Ran status = run_with(cell_file(), {"status", "-o", "json"});
  ASSERT_EQ(status.code, 0) << status.err;
  const Json fault = entry(Json::parse(status.out).at("faults"), "kind", "certificate_expires");
  ASSERT_FALSE(fault.is_null()) << status.out;
  EXPECT_EQ(fault.at("severity"), "warning");
  EXPECT_EQ(fault.at("subject"), "localhost");

  // A viewer gives no goals and no orders to recorders, an operator no commands.
  EXPECT_THROW(bus::Writer<msg::Goal>{viewer}, std::runtime_error);
  EXPECT_THROW(bus::Writer<msg::RecorderRequest> orders(viewer), std::runtime_error);
  bus::Participant operator_ = participant("operator", Role::kOperator);
  EXPECT_THROW(bus::Writer<msg::ArmCommand> forged(operator_), std::runtime_error);
  EXPECT_NO_THROW(bus::Writer<msg::Goal>{operator_});
}

TEST_F(SecuredCell, SavesARecordingByOrderOfAnOperator) {
  Process recorder({std::string(HECATON_BIN_DIR) + "/hecaton", "record", cell_file(), "--domain", domain(), "--keep",
                    "10s", "-o", folder_.path("run.mcap")});
  ASSERT_TRUE(recorder.wait_for_message("recording cell")) << recorder.err();
  const Ran saved = run_with(cell_file(), {"record", "--save"});
  EXPECT_EQ(saved.code, 0) << saved.err;
  EXPECT_NE(saved.out.find(folder_.path("run-0")), std::string::npos) << saved.out;
  EXPECT_TRUE(recorder.wait_for_message("saved what is kept: a person ordered it")) << recorder.err();
  recorder.signal(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
}

TEST_F(SecuredCell, TakesOrdersOfAPageThroughTheIdentityOfAnOperator) {
  const auto start_view = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{
        std::string(HECATON_BIN_DIR) + "/hecaton", "view", cell_file(), "--domain", domain(), "--port", "0"};
    words.insert(words.end(), options.begin(), options.end());
    return std::make_unique<Process>(words);
  };
  const auto port_of = [](const std::string& address) {
    return static_cast<std::uint16_t>(std::stoi(address.substr(address.find(':', 7) + 1)));
  };
  const auto answer = [](WebSocketClient& page, Json message) {
    message["id"] = 4;
    page.write(message.dump());
    // The first answer to a goal is that it was sent.
    return page.wait_for("reply", [](const Json& reply) { return reply.at("id") == 4 && reply.at("final") == true; });
  };
  {
    const auto view = start_view({"--control"});
    ASSERT_TRUE(view->wait_for_output("\n")) << view->err();
    const std::string address = view->out().substr(0, view->out().find('\n'));
    WebSocketClient page(port_of(address), "http://localhost");
    page.wait_for("frame", [](const Json& frame) { return !frame.at("arms")[0][0].is_null(); });
    EXPECT_TRUE(answer(page, {{"op", "take"}, {"token", address.substr(address.find('=') + 1)}}).at("done"));
    const Json reached = answer(page, {{"op", "goal"}, {"arm", "north"}, {"named", "ready"}});
    EXPECT_TRUE(reached.at("done")) << reached;
    page.write(Json{{"op", "preview"}, {"id", -1}, {"arm", "north"}, {"pose", {0, 0.8, 90.0, 0, 0, 0, 1}}}.dump());
    EXPECT_EQ(page.wait_for("preview", [](const Json&) { return true; }).at("verdict"), "unreachable");
    const Json held = answer(page, {{"op", "hold"}});
    EXPECT_TRUE(held.at("done")) << held;
    EXPECT_EQ(Json::parse(run_with(cell_file(), {"status", "-o", "json"}).out).at("mode"), "hold");
    view->signal(SIGINT);
    EXPECT_EQ(view->wait(), 0) << view->err();
  }
  EXPECT_EQ(run_with(cell_file(), {"resume"}).code, 0);

  // A machine without that identity shows the cell, and says why it gives no orders.
  std::filesystem::rename(identity(Role::kOperator), folder_.path() / "away");
  {
    const auto view = start_view({"--control"});
    EXPECT_EQ(view->wait(), 3) << view->err();
    EXPECT_NE(view->err().find("identity of the role operator"), std::string::npos) << view->err();
  }
  const auto view = start_view({});
  ASSERT_TRUE(view->wait_for_output("\n")) << view->err();
  WebSocketClient page(port_of(view->out()), "http://localhost");
  const Json control = page.wait_for("control", [](const Json&) { return true; });
  EXPECT_FALSE(control.at("stop"));
  EXPECT_NE(control.at("refusal").get<std::string>().find("operator"), std::string::npos);
  EXPECT_FALSE(answer(page, {{"op", "stop"}}).at("done"));
  page.wait_for("frame", [](const Json& frame) { return !frame.at("arms")[0][0].is_null(); });
  view->signal(SIGINT);
  EXPECT_EQ(view->wait(), 0) << view->err();
  std::filesystem::rename(folder_.path() / "away", identity(Role::kOperator));
}

TEST_F(SecuredCell, RestartsAProcessWithItsKeys) {
  reach("north", "ready");
  pid_t planner = 0;
  for (const auto until = bus::Clock::now() + kPatience; planner == 0 && bus::Clock::now() < until;) {
    const Ran status = run_with(cell_file(), {"status", "-o", "json"});
    ASSERT_EQ(status.code, 0) << status.err;
    const Json planner_node = entry(Json::parse(status.out).at("nodes"), "node", "planner/north");
    if (!planner_node.is_null()) planner = planner_node.at("pid").get<pid_t>();
  }
  ASSERT_GT(planner, 0);
  ASSERT_EQ(::kill(planner, SIGKILL), 0);
  reach("north", "home");
}

}  // namespace
}  // namespace hecaton::test
