// A real range sensor: any process may publish its RangeScan.
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

/// A planar arm with one beam from its base along x. The world does not simulate it; the test is the sensor.
class MotionSensor : public MotionCell {
 protected:
  MotionSensor()
      : MotionCell(1, "",
                   "  urdf: " HECATON_SOURCE_DIR
                   "/deploy/cells/urdf/planar_2r.urdf\n"
                   "  limits: {velocity: 1, acceleration: 8}\n"
                   "  method: sensed_cspace\n"
                   "  poses: {home: [-0.8, 0]}\n"
                   "  sensors:\n"
                   "    - {name: eye, link: base, position: [0, 0, 0], direction: [1, 0, 0], simulated: false}\n"),
        scans_(participant_) {}

  void publish(double distance, bool hit) {
    msg::RangeScan scan;
    scan.sensor("arm1/eye");
    scan.arm("arm1");
    scan.link("base");
    scan.sequence_number(++sequence_);
    scan.stamp_ns(std::chrono::steady_clock::now().time_since_epoch().count());
    scan.max_range(1.0);
    scan.rays().resize(1);
    scan.rays()[0].direction_L().x(1.0);
    scan.rays()[0].distance(distance);
    scan.rays()[0].hit(hit);
    (void)scans_.write(scan);
  }

  bus::Writer<msg::RangeScan> scans_;
  std::uint64_t sequence_ = 0;
};

TEST_F(MotionSensor, MakesTheArmAvoidScannedObstacles) {
  start_driver();
  start_planner();
  start_world();
  const std::vector<double> across{0.8, 0.0};
  send(joint_goal("silent", across));
  ASSERT_TRUE(await([&] {
    const msg::GoalStatus* goal = status("silent");
    return goal != nullptr && goal->cause().text().find("sensor eye has sent no scan") != std::string::npos;
  })) << "without its sensor it stays";

  // An obstacle blocks the first link on one side; the other side is free.
  send(joint_goal("barred", across));
  ASSERT_TRUE(await([&] {
    publish(0.3, true);
    const msg::GoalStatus* goal = status("barred");
    return goal != nullptr && goal->state() == msg::GoalState::GOAL_BLOCKED &&
           goal->cause().text().find("the known obstacles leave no path to the goal") != std::string::npos;
  }));
  ASSERT_NE(arm(), nullptr);
  EXPECT_LT(arm()->q()[0], -0.05);

  const std::vector<double> back{-1.0, 0.3};
  send(joint_goal("free", back));
  EXPECT_TRUE(await([&] {
    publish(1.0, false);
    return is("free", msg::GoalState::GOAL_REACHED);
  }));
}

}  // namespace
}  // namespace hecaton::test
