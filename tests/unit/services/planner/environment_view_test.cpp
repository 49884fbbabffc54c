#include "services/planner/environment_view.hpp"

#include <gtest/gtest.h>

#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

msg::ObstacleShapes shapes(const std::string& name, double radius = 0.1, const std::string& attached_to = "") {
  world::Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes.push_back({world::Sphere{radius}});
  if (!attached_to.empty()) obstacle.attachment = world::Attachment{attached_to};
  msg::ObstacleShapes message;
  message.name(name);
  message.obstacle(messages::to_message(obstacle));
  return message;
}

msg::ObstacleStates states(std::uint64_t sequence, const std::vector<std::string>& names, double x = 0.0) {
  msg::ObstacleStates message;
  message.sequence_number(sequence);
  message.stamp_ns(static_cast<std::int64_t>(sequence) * 20'000'000);  // one every 20 ms
  for (const std::string& name : names) {
    msg::ObstacleState& state = message.states().emplace_back();
    state.name(name);
    state.X_WO().qw(1.0);
    state.X_WO().position().x(x);
  }
  return message;
}

class ObstacleViewTest : public testing::Test {
 protected:
  bool receive(const msg::ObstacleStates& message, bus::EndpointId writer = {}) {
    EXPECT_EQ(view_.apply(message, writer, now_), std::nullopt);
    return view_.join();
  }
  std::vector<std::string> names() const {
    std::vector<std::string> list;
    for (const auto& obstacle : *view_.obstacles()) list.push_back(obstacle.name);
    return list;
  }
  double x() { return view_.states(now_)[0].X_WO.translation().x(); }

  ObstacleView view_{{"arm1", "arm2"}};
  ObstacleView::Clock::time_point now_{10s};
};

TEST_F(ObstacleViewTest, KnowsAnEmptyWorldAfterItsFirstMessage) {
  EXPECT_FALSE(view_.known());
  EXPECT_EQ(view_.missing(), "no message of the world service has been received");
  EXPECT_TRUE(receive(states(1, {})));
  EXPECT_TRUE(view_.known());
  EXPECT_EQ(view_.missing(), "");
  EXPECT_FALSE(receive(states(2, {}))) << "the same list";
}

TEST_F(ObstacleViewTest, HasTheOrderOfTheStates) {
  EXPECT_EQ(view_.apply(shapes("a"), {}), std::nullopt);
  EXPECT_EQ(view_.apply(shapes("b"), {}), std::nullopt);
  EXPECT_TRUE(receive(states(1, {"b", "a"})));
  EXPECT_EQ(names(), (std::vector<std::string>{"b", "a"}));
  EXPECT_TRUE(receive(states(2, {"a", "b"})));
  EXPECT_EQ(names(), (std::vector<std::string>{"a", "b"}));
}

TEST_F(ObstacleViewTest, KeepsOldStatesUntilAllShapesAreKnown) {
  EXPECT_EQ(view_.apply(shapes("a"), {}), std::nullopt);
  ASSERT_TRUE(receive(states(1, {"a"}, 0.5)));
  now_ += 20ms;
  EXPECT_FALSE(receive(states(2, {"a", "b"}, 0.7)));
  EXPECT_EQ(view_.missing(), "the shape of obstacle b is not known yet");
  EXPECT_EQ(x(), 0.5);
  EXPECT_DOUBLE_EQ(view_.states(now_)[0].age, 0.02);
  EXPECT_EQ(view_.apply(shapes("b"), {}), std::nullopt);
  EXPECT_TRUE(view_.join()) << "the waiting states are joined";
  EXPECT_EQ(x(), 0.7);
  EXPECT_DOUBLE_EQ(view_.age(now_), 0.0);
}

TEST_F(ObstacleViewTest, KeepsAWithdrawnShapeWhileStatesNameIt) {
  EXPECT_EQ(view_.apply(shapes("a"), {}), std::nullopt);
  EXPECT_EQ(view_.apply(shapes("b"), {}), std::nullopt);
  ASSERT_TRUE(receive(states(1, {"a", "b"})));
  view_.withdraw("b", {});
  EXPECT_FALSE(receive(states(2, {"a", "b"}))) << "sent before the removal";
  EXPECT_TRUE(receive(states(3, {"a"})));
  EXPECT_EQ(names(), (std::vector<std::string>{"a"}));
  EXPECT_FALSE(receive(states(4, {"a", "b"}))) << "its shape is now unknown";
  EXPECT_EQ(view_.missing(), "the shape of obstacle b is not known yet");
}

TEST_F(ObstacleViewTest, ReportsAChangeOfAShape) {
  EXPECT_EQ(view_.apply(shapes("a"), {}), std::nullopt);
  ASSERT_TRUE(receive(states(1, {"a"})));
  EXPECT_EQ(view_.apply(shapes("a", 0.1, "arm2"), {}), std::nullopt);
  EXPECT_TRUE(view_.join());
  ASSERT_TRUE(view_.obstacles()->front().attachment);
  EXPECT_EQ(view_.obstacles()->front().attachment->arm, "arm2");
}

TEST_F(ObstacleViewTest, IgnoresDescriptionsOfParticipantsThatSendNoStates) {
  EXPECT_EQ(view_.apply(shapes("a"), {}), std::nullopt);
  ASSERT_TRUE(receive(states(1, {"a"})));
  for (std::uint8_t intruder = 1; intruder < 9; ++intruder) {
    bus::EndpointId id;
    id.bytes[0] = intruder;
    EXPECT_EQ(view_.apply(shapes("a", 2.0), id), std::nullopt);
    view_.withdraw("a", id);
  }
  EXPECT_FALSE(receive(states(2, {"a"}))) << "the same obstacles";
  EXPECT_EQ(names(), std::vector<std::string>{"a"});
}

TEST_F(ObstacleViewTest, DropsOldStatesButNotThoseOfARestartedWorld) {
  EXPECT_EQ(view_.apply(shapes("a"), {}), std::nullopt);
  ASSERT_TRUE(receive(states(7, {"a"}, 0.7)));
  receive(states(6, {"a"}, 0.6));
  EXPECT_EQ(x(), 0.7);
  bus::EndpointId restarted;
  restarted.bytes[0] = 1;
  EXPECT_EQ(view_.apply(shapes("a"), restarted), std::nullopt);
  receive(states(1, {"a"}, 0.1), restarted);
  EXPECT_EQ(x(), 0.1);
}

TEST_F(ObstacleViewTest, RejectsInvalidMessagesWithASentence) {
  EXPECT_EQ(view_.apply(shapes("a", 0.1, "arm9"), {}), "obstacle \"a\": attached_to = arm9 must be an arm of the cell");
  EXPECT_NE(view_.apply(shapes("a", -1.0), {}), std::nullopt);
  msg::ObstacleStates bad = states(1, {"a"});
  bad.states()[0].X_WO().qw(0.0);
  EXPECT_NE(view_.apply(bad, {}, now_), std::nullopt);
  EXPECT_FALSE(view_.join());
}

class SensorViewTest : public testing::Test {
 protected:
  static planner::PlannedArm arm() {
    auto model = std::make_shared<planner::RobotModel>();
    model->links.resize(2);
    model->links[0].name = "base";
    model->links[1].name = "fore";
    planner::PlannedArm planned;
    planned.arm.name = "arm1";
    planned.arm.model = model;
    planner::RangeSensor sensor;
    sensor.name = "side";
    sensor.link = 1;
    sensor.rays.resize(2);
    sensor.period = 0.02;
    planned.sensors = {sensor};
    return planned;
  }

  msg::RangeScan scan(std::uint64_t sequence) {
    planner::RangeScan values;
    values.readings = {{{}, 0.3, true}, {{}, 0.5, false}};
    msg::RangeScan message = messages::to_message(values, arm().sensors[0]);
    message.sensor("arm1/side");
    message.arm("arm1");
    message.link("fore");
    message.sequence_number(sequence);
    message.stamp_ns(static_cast<std::int64_t>(sequence) * 20'000'000);
    return message;
  }

  std::optional<planner::RangeScan> take(const msg::RangeScan& message) {
    error_.reset();
    return view_.take(message, {}, now_, own_, error_);
  }

  SensorView::Clock::time_point now_{10s};
  ArmView::ReceivedState own_ = [] {
    ArmView::ReceivedState state;
    state.q = Eigen::Vector2d(1.0, 2.0);
    state.qd = Eigen::Vector2d(0.5, 0.0);
    state.at = SensorView::Clock::time_point(10s - 4ms);
    return state;
  }();
  SensorView view_{arm()};
  std::optional<std::string> error_;
};

TEST_F(SensorViewTest, ExtrapolatesTheConfigurationToTheTimeOfTheScan) {
  const auto taken = take(scan(1));
  ASSERT_TRUE(taken.has_value()) << error_.value_or("");
  EXPECT_EQ(taken->sensor, 0);
  EXPECT_EQ(taken->link, 1);
  EXPECT_NEAR(taken->q[0], 1.0 + 0.5 * 0.004, 1e-12);  // 4 ms after the arm's last state
  ASSERT_EQ(taken->readings.size(), 2U);
  EXPECT_TRUE(taken->readings[0].hit);
  EXPECT_DOUBLE_EQ(taken->readings[0].distance, 0.3);
  EXPECT_FALSE(taken->readings[1].hit);
}

TEST_F(SensorViewTest, DropsOldScansAndScansOfOtherArms) {
  ASSERT_TRUE(take(scan(2)).has_value());
  EXPECT_FALSE(take(scan(2)).has_value());
  EXPECT_FALSE(take(scan(1)).has_value());
  msg::RangeScan other = scan(3);
  other.arm("arm2");
  EXPECT_FALSE(take(other).has_value());
  EXPECT_EQ(error_, std::nullopt);
}

TEST_F(SensorViewTest, RejectsInvalidScansWithASentence) {
  msg::RangeScan unknown = scan(1);
  unknown.sensor("arm1/nose");
  EXPECT_FALSE(take(unknown).has_value());
  EXPECT_EQ(error_, "RangeScan: sensor = arm1/nose must be a sensor of arm arm1 in the cell file");
  msg::RangeScan link = scan(1);
  link.link("base");
  EXPECT_FALSE(take(link).has_value());
  EXPECT_EQ(error_, "RangeScan \"arm1/side\": link = base must be fore");
  msg::RangeScan direction = scan(1);
  direction.rays()[0].direction_L().x(2.0);
  EXPECT_FALSE(take(direction).has_value());
  EXPECT_NE(error_.value().find("direction_L must be a unit vector"), std::string::npos) << error_.value_or("");
  msg::RangeScan many = scan(1);
  many.rays().resize(5000);
  EXPECT_FALSE(take(many).has_value());
  EXPECT_NE(error_.value().find("5000 rays must be 4096 at most"), std::string::npos) << error_.value_or("");
  msg::RangeScan negative = scan(1);
  negative.rays()[0].distance(-0.1);
  EXPECT_FALSE(take(negative).has_value());
  EXPECT_NE(error_.value().find("distance"), std::string::npos) << error_.value_or("");
}

TEST_F(SensorViewTest, NamesASilentSensor) {
  EXPECT_EQ(view_.silent(now_, 0.25).value().text(), "sensor side has sent no scan");
  ASSERT_TRUE(take(scan(1)).has_value());
  EXPECT_FALSE(view_.silent(now_ + 200ms, 0.25).has_value());
  EXPECT_EQ(view_.silent(now_ + 300ms, 0.25).value().text(), "sensor side sends no scans");
}

}  // namespace
}  // namespace hecaton::services
