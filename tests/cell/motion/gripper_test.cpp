// A simulated gripper with real planner, driver and world: it takes a crate, carries it, survives its driver, and puts
// it down.
#include "tests/cell/motion/motion_cell.hpp"
#include "tests/support/gripper_cell.hpp"

namespace hecaton::test {
namespace {

/// The robot description, in a folder that lasts as long as the tests.
const std::string& slides() {
  static const TemporaryFolder folder;
  static const std::string path = [] {
    std::string file = (folder.path() / "slides.urdf").string();
    std::ofstream(file) << gripper_urdf();
    return file;
  }();
  return path;
}

class Gripper : public MotionCell {
 protected:
  Gripper()
      : MotionCell(1,
                   "  - name: crate\n"
                   "    shapes: [{type: box, size: [0.04, 0.04, 0.04]}]\n"
                   "    pose: {xyz: [0.3, 0, 0.3]}\n",
                   "  urdf: " + slides() +
                       "\n"
                       "  tool_link: hand\n"
                       "  tool: {xyz: [0, 0, -0.08]}\n"
                       "  joints: {grip: [0, 0.05]}\n"
                       "  gripper: {joint: grip, closed: 0, opened: 0.05, width: 0.1, speed: 0.1}\n"
                       "  signals: {part: digital_input, lamp: digital_output}\n"
                       "  limits: {velocity: 0.4, acceleration: 4}\n"
                       "  damper: {security_distance: 0.004, influence_distance: 0.02}\n"
                       "  poses: {home: [0, 0, 0.7]}\n"),
        orders_(participant_),
        answers_(participant_, &mailbox_),
        tools_(participant_, &mailbox_) {}

  void reach(const std::string& goal, const std::vector<double>& q) {
    send(joint_goal(goal, q));
    EXPECT_TRUE(await([&] { return is(goal, msg::GoalState::GOAL_REACHED); }))
        << goal << ": " << (status(goal) == nullptr ? "no status" : status(goal)->cause().text());
  }
  msg::DeviceReply order(msg::DeviceRequest request) {
    request.client("test");
    request.request_id(++number_);
    request.arm("arm1");
    std::optional<msg::DeviceReply> reply;
    auto again = bus::Clock::now();
    EXPECT_TRUE(await([&] {
      if (bus::Clock::now() >= again) {
        static_cast<void>(orders_.write(request));
        again = bus::Clock::now() + 500ms;
      }
      for (const auto& sample : answers_.take()) {
        if (sample.value.request_id() == number_) reply = sample.value;
      }
      return reply.has_value();
    }));
    return reply.value_or(msg::DeviceReply());
  }
  msg::DeviceReply order(msg::DeviceOrder what) {
    msg::DeviceRequest request;
    request.order(what);
    return order(std::move(request));
  }
  [[nodiscard]] msg::ToolState tool() {
    const auto* sample = tools_.latest("arm1");
    return sample == nullptr ? msg::ToolState() : sample->value;
  }
  [[nodiscard]] std::string carrier() {
    const auto* sample = shapes_.latest("crate");
    return sample == nullptr ? "?" : sample->value.obstacle().attached_to();
  }

  bus::Writer<msg::DeviceRequest> orders_;
  bus::Reader<msg::DeviceReply> answers_;
  bus::Reader<msg::ToolState> tools_;
  std::uint64_t number_ = 0;
};

TEST_F(Gripper, TakesACrateCarriesItAndPutsItDown) {
  const TemporaryFolder kept;
  const std::string checkpoint = (kept.path() / "driver").string();
  bus::Reader<msg::ObstacleStates> places(participant_, &mailbox_);
  const auto crate_y = [&] {
    const auto& newest = places.latest();
    if (newest.empty()) return 1e9;
    for (const auto& state : newest.begin()->second.value.states()) {
      if (state.name() == "crate") return state.X_WO().position().y();
    }
    return 1e9;
  };
  start_world();
  ChildProcess& driver = start_driver("arm1", checkpoint);
  start_planner("arm1");
  ASSERT_TRUE(await([&] { return arm() != nullptr && arm()->mode() == msg::ArmMode::ARM_RUNNING; }));
  EXPECT_EQ(arm()->outside_lower(), (std::vector<double>{0.05}));

  // With the fingers anywhere in their range the crate would be in their way.
  reach("at crate", {0.3, 0, 0.38});
  const msg::DeviceReply closed = order(msg::DeviceOrder::DEVICE_CLOSE_TOOL);
  ASSERT_TRUE(closed.done()) << closed.cause().text();
  EXPECT_TRUE(await([&] { return tool().holding() == "crate"; }));
  EXPECT_EQ(carrier(), "arm1");
  EXPECT_TRUE(await([&] { return std::abs(tool().width() - 0.04) < 2e-3; })) << tool().width();

  reach("away", {0.3, 0.3, 0.6});
  EXPECT_TRUE(await([&] { return std::abs(crate_y() - 0.3) < 5e-3; })) << crate_y();

  // The driver dies: the gripper keeps what it holds, and nothing is ordered again.
  driver.signal(SIGKILL);
  ASSERT_TRUE(driver.wait(kLimit).ended);
  const auto before = tool().sequence_number();
  start_driver("arm1", checkpoint);
  ASSERT_TRUE(await([&] { return tool().sequence_number() != before && tool().holding() == "crate"; }));
  reach("back", {0.3, 0, 0.6});
  EXPECT_EQ(carrier(), "arm1");
  EXPECT_NEAR(tool().width(), 0.04, 2e-3);

  const msg::DeviceReply opened = order(msg::DeviceOrder::DEVICE_OPEN_TOOL);
  ASSERT_TRUE(opened.done()) << opened.cause().text();
  EXPECT_TRUE(await([&] { return carrier().empty(); })) << carrier();
  EXPECT_NEAR(crate_y(), 0.0, 5e-3) << "it stays where it was released";
  reach("home", {0, 0, 0.7});
  const auto& reports = reports_.latest();
  ASSERT_FALSE(reports.empty());
  const msg::ContactReport& report = reports.begin()->second.value;
  EXPECT_EQ(report.contacts(), 0U) << report.smallest().a() << " " << report.smallest().b();
}

TEST_F(Gripper, MovesOnlyForAnArmThatStands) {
  start_all();
  send(joint_goal("far", {0.4, 0.4, 0.7}));
  ASSERT_TRUE(await([&] { return moves(); }));
  const msg::DeviceReply moving = order(msg::DeviceOrder::DEVICE_CLOSE_TOOL);
  EXPECT_FALSE(moving.done());
  EXPECT_EQ(moving.cause().text(), "arm arm1: it moves: wait until it stands");
  ASSERT_TRUE(await([&] { return is("far", msg::GoalState::GOAL_REACHED); }));
  msg::DeviceRequest lamp;
  lamp.order(msg::DeviceOrder::DEVICE_SET_SIGNAL);
  lamp.name("lamp");
  lamp.value(1.0);
  EXPECT_TRUE(order(lamp).done());
  EXPECT_TRUE(await([&] { return tool().signals().size() == 2 && tool().signals()[0].value() == 1.0; }));
}

}  // namespace
}  // namespace hecaton::test
