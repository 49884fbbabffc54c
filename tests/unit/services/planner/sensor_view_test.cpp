#include "services/planner/sensor_view.hpp"

#include <gtest/gtest.h>

#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

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
    complaint_.reset();
    return view_.take(message, {}, now_, own_, complaint_);
  }

  SensorView::Clock::time_point now_{10s};
  ArmView::Heard own_ = [] {
    ArmView::Heard heard;
    heard.q = Eigen::Vector2d(1.0, 2.0);
    heard.qd = Eigen::Vector2d(0.5, 0.0);
    heard.at = SensorView::Clock::time_point(10s - 4ms);
    return heard;
  }();
  SensorView view_{arm()};
  std::optional<std::string> complaint_;
};

TEST_F(SensorViewTest, PutsAScanWhereTheArmWasThen) {
  const auto taken = take(scan(1));
  ASSERT_TRUE(taken.has_value()) << complaint_.value_or("");
  EXPECT_EQ(taken->sensor, 0);
  EXPECT_EQ(taken->link, 1);
  EXPECT_NEAR(taken->q[0], 1.0 + 0.5 * 0.004, 1e-12);  // 4 ms after the arm's last state
  ASSERT_EQ(taken->readings.size(), 2U);
  EXPECT_TRUE(taken->readings[0].hit);
  EXPECT_DOUBLE_EQ(taken->readings[0].distance, 0.3);
  EXPECT_FALSE(taken->readings[1].hit);
}

TEST_F(SensorViewTest, DropsWhatWasOvertakenOrIsAnotherArms) {
  ASSERT_TRUE(take(scan(2)).has_value());
  EXPECT_FALSE(take(scan(2)).has_value());
  EXPECT_FALSE(take(scan(1)).has_value());
  msg::RangeScan other = scan(3);
  other.arm("arm2");
  EXPECT_FALSE(take(other).has_value());
  EXPECT_EQ(complaint_, std::nullopt);
}

TEST_F(SensorViewTest, SaysWhatIsWrongWithAMessage) {
  msg::RangeScan unknown = scan(1);
  unknown.sensor("arm1/nose");
  EXPECT_FALSE(take(unknown).has_value());
  EXPECT_EQ(complaint_, "RangeScan: sensor = arm1/nose must be one that the cell file gives arm arm1");
  msg::RangeScan link = scan(1);
  link.link("base");
  EXPECT_FALSE(take(link).has_value());
  EXPECT_EQ(complaint_, "RangeScan \"arm1/side\": link = base must be fore");
  msg::RangeScan direction = scan(1);
  direction.rays()[0].direction_L().x(2.0);
  EXPECT_FALSE(take(direction).has_value());
  EXPECT_NE(complaint_.value().find("direction_L must be a unit vector"), std::string::npos) << complaint_.value_or("");
  msg::RangeScan many = scan(1);
  many.rays().resize(5000);
  EXPECT_FALSE(take(many).has_value());
  EXPECT_NE(complaint_.value().find("5000 rays must be 4096 at most"), std::string::npos) << complaint_.value_or("");
  msg::RangeScan negative = scan(1);
  negative.rays()[0].distance(-0.1);
  EXPECT_FALSE(take(negative).has_value());
  EXPECT_NE(complaint_.value().find("distance"), std::string::npos) << complaint_.value_or("");
}

TEST_F(SensorViewTest, KnowsWhoIsSilent) {
  EXPECT_EQ(view_.silent(now_, 0.25).value().text(), "sensor side was never heard");
  ASSERT_TRUE(take(scan(1)).has_value());
  EXPECT_FALSE(view_.silent(now_ + 200ms, 0.25).has_value());
  EXPECT_EQ(view_.silent(now_ + 300ms, 0.25).value().text(), "sensor side is silent");
}

}  // namespace
}  // namespace hecaton::services
