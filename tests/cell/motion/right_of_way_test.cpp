// The right of way between two planners that communicate over DDS only
// (docs/explanation/0007-right-of-way.md).
#include <algorithm>

#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

// The forearms are level and point past each other. Each must sweep through the place between the bases, where they
// meet head-on.
const std::vector<double> kFrom1{0.6, -0.6, 2.6, 0, 0.6, 0};
const std::vector<double> kTo1{2.5, -0.6, 2.6, 0, 0.6, 0};
const std::vector<double> kFrom2{-2.5, -0.6, 2.6, 0, 0.6, 0};
const std::vector<double> kTo2{-0.6, -0.6, 2.6, 0, 0.6, 0};

class MotionRightOfWay : public MotionCell {
 protected:
  // Without lookahead, and with a short delay before a blocked arm requests the right of way.
  MotionRightOfWay()
      : MotionCell(2, "",
                   "  rollout: {candidates: 0}\n  yielding: {yield_request_delay: 1s}\n"
                   "  damper: {influence_distance: 0.12, security_distance: 0.02, convergence_speed: 1}\n") {}

  void go(const std::string& goal, const std::vector<double>& q, const std::string& arm) {
    send(joint_goal(goal, q, arm));
  }
  [[nodiscard]] bool arrived(const std::string& goal, const std::string& arm) const {
    return is(goal, msg::GoalState::GOAL_REACHED, arm);
  }
  /// The arm yielded to `other` on its way to `goal`, as its goal statuses say.
  [[nodiscard]] bool yielded(const std::string& goal, const std::string& other) const {
    return std::any_of(statuses(goal).begin(), statuses(goal).end(), [&](const msg::GoalStatus& status) {
      return status.recovery_action() == "yields to arm " + other && status.blocked_duration() > 0.0;
    });
  }
  [[nodiscard]] bool asked(const std::string& goal) const {
    return std::any_of(statuses(goal).begin(), statuses(goal).end(),
                       [](const msg::GoalStatus& status) { return status.priority() > 0; });
  }
  [[nodiscard]] const std::vector<msg::GoalStatus>& statuses(const std::string& goal) const {
    return statuses_of_.at(goal);
  }
};

TEST_F(MotionRightOfWay, OneArmYieldsAndBothArriveWithoutContact) {
  start_all();
  go("start2", kFrom2, "arm2");
  ASSERT_TRUE(await([&] { return arrived("start2", "arm2"); }));
  go("start1", kFrom1, "arm1");
  ASSERT_TRUE(await([&] { return arrived("start1", "arm1"); }));

  go("pass1", kTo1, "arm1");
  go("pass2", kTo2, "arm2");
  ASSERT_TRUE(await([&] { return arrived("pass1", "arm1") && arrived("pass2", "arm2"); }));
  EXPECT_TRUE((yielded("pass1", "arm2") && asked("pass2")) || (yielded("pass2", "arm1") && asked("pass1")));

  const auto reports = reports_.latest();
  ASSERT_FALSE(reports.empty());
  const msg::ContactReport& report = reports.begin()->second.value;
  EXPECT_TRUE(report.has_smallest());
  EXPECT_EQ(report.contacts(), 0U);
}

}  // namespace
}  // namespace hecaton::test
