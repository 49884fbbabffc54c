#include <gtest/gtest.h>

#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

TEST(FailoverBackoff, DoublesWithEachReplacementUpToTheMost) {
  FailoverBackoff backoff(20ms, 100ms);
  EXPECT_EQ(backoff.at(100s), 20ms);
  backoff.replaced(100s);
  EXPECT_EQ(backoff.at(100s), 40ms);
  backoff.replaced(101s);
  EXPECT_EQ(backoff.at(101s), 80ms);
  backoff.replaced(102s);
  backoff.replaced(103s);
  EXPECT_EQ(backoff.at(103s), 100ms);
}

TEST(FailoverBackoff, IsHalvedWhileNothingHappens) {
  FailoverBackoff backoff(20ms, 100ms);
  backoff.replaced(100s);
  backoff.replaced(100s);
  EXPECT_EQ(backoff.at(109s), 80ms);
  EXPECT_EQ(backoff.at(110s), 40ms);
  backoff.replaced(111s);
  EXPECT_EQ(backoff.at(111s), 80ms) << "twice what it was by then";
  EXPECT_EQ(backoff.at(131s), 20ms);
  EXPECT_EQ(backoff.at(1000s), 20ms);
}

TEST(FailoverBackoff, IsNeverBelowWhatTheCellFileSays) {
  FailoverBackoff backoff(150ms, 100ms);
  backoff.replaced(1s);
  EXPECT_EQ(backoff.at(1s), 150ms);
}

}  // namespace
}  // namespace hecaton::services
