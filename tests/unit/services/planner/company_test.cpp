// What a planner says of plans for several arms when it begins, and when it begins again.
#include "services/planner/company.hpp"

#include <gtest/gtest.h>

#include "tests/support/free_domain.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using test::joints;

bus::ParticipantOptions one_host() {
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  return options;
}

class CompanyOnTheBus : public testing::Test {
 protected:
  static std::vector<planner::Arm> arms() { return {test::planar_point("a"), test::planar_point("b")}; }

  /// A period in which nothing hinders the arm.
  void plan(Company& company) {
    std::vector<planner::ArmObservation> others(2);
    others[1].q = joints({2, 2});
    others[1].qd = joints({0, 0});
    others[1].known = true;
    const auto result = controller_.step(planner::MeasuredState{joints({0, 0}), joints({0, 0})}, others, {}, false);
    company.plan(controller_, result, others, {}, std::make_shared<const std::vector<world::Obstacle>>());
  }
  /// Waits for so many words of either kind.
  [[nodiscard]] bool hear(std::size_t words) {
    const auto until = bus::Clock::now() + std::chrono::seconds(60);
    while ((said_.size() < words || proposed_.size() < words) && bus::Clock::now() < until) {
      (void)progress_.wait_for_data(std::chrono::milliseconds(50));
      for (const auto& sample : progress_.take()) said_.push_back(sample.value);
      for (const auto& sample : proposals_.take()) proposed_.push_back(sample.value);
    }
    return said_.size() == words && proposed_.size() == words;
  }

  test::FreeDomain domain_;
  bus::Participant here_{domain_.number(), "here", one_host()};
  bus::Participant there_{domain_.number(), "there", one_host()};
  bus::Mailbox mailbox_;
  bus::Mailbox heard_;
  bus::Reader<msg::CompositeProgress> progress_{there_, &heard_};
  bus::Reader<msg::CompositePlan> proposals_{there_, &heard_};
  planner::ArmController controller_{planner::CellGeometry(arms(), 0), planner::LocalParameters(), 0.01, 1};
  std::vector<msg::CompositeProgress> said_;
  std::vector<msg::CompositePlan> proposed_;
};

TEST_F(CompanyOnTheBus, WhoBeginsSaysThatItTakesPartInNothing) {
  Company company(here_, &mailbox_, arms(), std::vector<planner::LocalParameters>(2), 0, "planner.a", 1);
  plan(company);
  ASSERT_TRUE(hear(1));
  EXPECT_EQ(said_[0].node(), "planner.a");
  EXPECT_EQ(said_[0].proposer(), "");
  EXPECT_EQ(proposed_[0].node(), "planner.a");
  EXPECT_TRUE(proposed_[0].arms().empty());
  // Once. After another planner has commanded the arm it says so again.
  plan(company);
  company.resign(controller_);
  company.resign(controller_);
  plan(company);
  plan(company);
  ASSERT_TRUE(hear(2));
  EXPECT_EQ(said_[1].proposer(), "");
}

}  // namespace
}  // namespace hecaton::services
