#include "services/planner/planner_service.hpp"

#include <gtest/gtest.h>

#include "tests/support/free_domain.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

bus::ParticipantOptions one_host() {
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  return options;
}

class CoordinationPublisherTest : public testing::Test {
 protected:
  /// Waits until `messages` messages of each kind have been received.
  [[nodiscard]] bool receive(std::size_t messages) {
    const auto until = bus::Clock::now() + std::chrono::seconds(60);
    while ((joined_.size() < messages || proposed_.size() < messages) && bus::Clock::now() < until) {
      (void)progress_.wait_for_data(std::chrono::milliseconds(50));
      for (const auto& sample : progress_.take()) joined_.push_back(sample.value);
      for (const auto& sample : proposals_.take()) proposed_.push_back(sample.value);
    }
    return joined_.size() == messages && proposed_.size() == messages;
  }

  test::FreeDomain domain_;
  bus::Participant here_{domain_.number(), "here", one_host()};
  bus::Participant there_{domain_.number(), "there", one_host()};
  bus::Mailbox received_;
  bus::Reader<msg::CoupledPlanProgress> progress_{there_, &received_};
  bus::Reader<msg::CoupledPlan> proposals_{there_, &received_};
  CoordinationPublisher publisher_{here_, {"a", "b"}, 0, "planner.a"};
  std::vector<msg::CoupledPlanProgress> joined_;
  std::vector<msg::CoupledPlan> proposed_;
};

TEST_F(CoordinationPublisherTest, WithdrawsEarlierPlansWhenThePlannerTakesCharge) {
  publisher_.publish(nullptr, {});
  ASSERT_TRUE(receive(1));
  EXPECT_EQ(joined_[0].node(), "planner.a");
  EXPECT_EQ(joined_[0].proposer(), "");
  EXPECT_EQ(proposed_[0].node(), "planner.a");
  EXPECT_TRUE(proposed_[0].arms().empty());
  // Once, and again after another planner was in charge.
  publisher_.publish(nullptr, {});
  publisher_.resign();
  publisher_.publish(nullptr, {});
  publisher_.publish(nullptr, {});
  ASSERT_TRUE(receive(2));
  EXPECT_EQ(joined_[1].proposer(), "");
}

TEST_F(CoordinationPublisherTest, PublishesAPlanWithTheNamesOfItsArms) {
  publisher_.publish(nullptr, {});
  ASSERT_TRUE(receive(1));
  auto plan = std::make_shared<planner::CoupledPlan>();
  plan->number = 7;
  plan->arms = {0, 1};
  const planner::JointVector zero = planner::JointVector::Zero(2);
  plan->points = {{zero, zero}, {zero, zero}};
  publisher_.publish(plan, {.proposer = 0, .number = 7, .reached = 0});
  ASSERT_TRUE(receive(2));
  EXPECT_EQ(proposed_[1].number(), 7U);
  EXPECT_EQ(proposed_[1].arms(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(proposed_[1].points(), 2U);
  EXPECT_EQ(proposed_[1].q().size(), 8U);
  EXPECT_EQ(joined_[1].proposer(), "a");
  EXPECT_EQ(joined_[1].reached(), 0);
}

}  // namespace
}  // namespace hecaton::services
