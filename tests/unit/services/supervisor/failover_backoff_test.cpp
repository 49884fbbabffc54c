#include <gtest/gtest.h>

#include "services/supervisor/failover/planner_failover.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

TEST(FailoverBackoff, DoublesWithEachReplacementUpToTheMost) {
  FailoverBackoff patience(20ms, 100ms);
  EXPECT_EQ(patience.at(100s), 20ms);
  patience.replaced(100s);
  EXPECT_EQ(patience.at(100s), 40ms);
  patience.replaced(101s);
  EXPECT_EQ(patience.at(101s), 80ms);
  patience.replaced(102s);
  patience.replaced(103s);
  EXPECT_EQ(patience.at(103s), 100ms);
}

TEST(FailoverBackoff, IsHalvedWhileNothingHappens) {
  FailoverBackoff patience(20ms, 100ms);
  patience.replaced(100s);
  patience.replaced(100s);
  EXPECT_EQ(patience.at(109s), 80ms);
  EXPECT_EQ(patience.at(110s), 40ms);
  patience.replaced(111s);
  EXPECT_EQ(patience.at(111s), 80ms) << "twice what it was by then";
  EXPECT_EQ(patience.at(131s), 20ms);
  EXPECT_EQ(patience.at(1000s), 20ms);
}

TEST(FailoverBackoff, IsNeverBelowWhatTheCellFileSays) {
  FailoverBackoff patience(150ms, 100ms);
  patience.replaced(1s);
  EXPECT_EQ(patience.at(1s), 150ms);
}

}  // namespace
}  // namespace hecaton::services
