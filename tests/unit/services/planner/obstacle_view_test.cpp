#include "services/planner/obstacle_view.hpp"

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

class View : public testing::Test {
 protected:
  bool hear(const msg::ObstacleStates& message, bus::EndpointId writer = {}) {
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

TEST_F(View, AnEmptyWorldIsKnownOnceItWasHeard) {
  EXPECT_FALSE(view_.known());
  EXPECT_EQ(view_.missing(), "no world was heard yet");
  EXPECT_TRUE(hear(states(1, {})));
  EXPECT_TRUE(view_.known());
  EXPECT_EQ(view_.missing(), "");
  EXPECT_FALSE(hear(states(2, {}))) << "the same list";
}

TEST_F(View, FollowsTheOrderOfTheStates) {
  EXPECT_EQ(view_.apply(shapes("a")), std::nullopt);
  EXPECT_EQ(view_.apply(shapes("b")), std::nullopt);
  EXPECT_TRUE(hear(states(1, {"b", "a"})));
  EXPECT_EQ(names(), (std::vector<std::string>{"b", "a"}));
  EXPECT_TRUE(hear(states(2, {"a", "b"})));
  EXPECT_EQ(names(), (std::vector<std::string>{"a", "b"}));
}

TEST_F(View, StatesOfUnknownShapesWaitAndTheOldOnesAge) {
  EXPECT_EQ(view_.apply(shapes("a")), std::nullopt);
  ASSERT_TRUE(hear(states(1, {"a"}, 0.5)));
  now_ += 20ms;
  EXPECT_FALSE(hear(states(2, {"a", "b"}, 0.7)));
  EXPECT_EQ(view_.missing(), "the shape of obstacle b is not known yet");
  EXPECT_EQ(x(), 0.5);
  EXPECT_DOUBLE_EQ(view_.states(now_)[0].age, 0.02);
  EXPECT_EQ(view_.apply(shapes("b")), std::nullopt);
  EXPECT_TRUE(view_.join()) << "the waiting states are taken up";
  EXPECT_EQ(x(), 0.7);
  EXPECT_DOUBLE_EQ(view_.age(now_), 0.0);
}

TEST_F(View, AWithdrawnShapeServesUntilTheStatesDropIt) {
  EXPECT_EQ(view_.apply(shapes("a")), std::nullopt);
  EXPECT_EQ(view_.apply(shapes("b")), std::nullopt);
  ASSERT_TRUE(hear(states(1, {"a", "b"})));
  view_.withdraw("b");
  EXPECT_FALSE(hear(states(2, {"a", "b"}))) << "sent before the removal";
  EXPECT_TRUE(hear(states(3, {"a"})));
  EXPECT_EQ(names(), (std::vector<std::string>{"a"}));
  EXPECT_FALSE(hear(states(4, {"a", "b"}))) << "now it is unknown";
  EXPECT_EQ(view_.missing(), "the shape of obstacle b is not known yet");
}

TEST_F(View, AnEditedShapeIsAnotherList) {
  EXPECT_EQ(view_.apply(shapes("a")), std::nullopt);
  ASSERT_TRUE(hear(states(1, {"a"})));
  EXPECT_EQ(view_.apply(shapes("a", 0.1, "arm2")), std::nullopt);
  EXPECT_TRUE(view_.join());
  ASSERT_TRUE(view_.obstacles()->front().attachment);
  EXPECT_EQ(view_.obstacles()->front().attachment->arm, "arm2");
}

TEST_F(View, OvertakenStatesAreDroppedButNotThoseOfANewWorld) {
  EXPECT_EQ(view_.apply(shapes("a")), std::nullopt);
  ASSERT_TRUE(hear(states(7, {"a"}, 0.7)));
  hear(states(6, {"a"}, 0.6));
  EXPECT_EQ(x(), 0.7);
  bus::EndpointId restarted;
  restarted.bytes[0] = 1;
  hear(states(1, {"a"}, 0.1), restarted);
  EXPECT_EQ(x(), 0.1);
}

TEST_F(View, UnusableMessagesAreRefusedWithASentence) {
  EXPECT_EQ(view_.apply(shapes("a", 0.1, "arm9")), "obstacle \"a\": attached_to = arm9 must be an arm of the cell");
  EXPECT_NE(view_.apply(shapes("a", -1.0)), std::nullopt);
  msg::ObstacleStates bad = states(1, {"a"});
  bad.states()[0].X_WO().qw(0.0);
  EXPECT_NE(view_.apply(bad, {}, now_), std::nullopt);
  EXPECT_FALSE(view_.join());
}

}  // namespace
}  // namespace hecaton::services
