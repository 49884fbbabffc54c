// However a cell ends, nothing of it is left.

#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

TEST(HealthEnd, TerminatedAgentEndsAllItsServicesAndReturnsZero) {
  HealthCell cell;
  const Witnesses witnesses(cell.await_healthy());
  ASSERT_EQ(witnesses.count(), 6U);
  cell.agent().signal(SIGTERM);
  const auto end = cell.await_end();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 0);
  EXPECT_EQ(end->signal_number, 0);
  EXPECT_TRUE(witnesses.await_all_ended());
}

TEST(HealthEnd, StoppedServiceDoesNotKeepTheAgentFromEnding) {
  HealthCell cell;
  const auto status = cell.await_healthy();
  const Witnesses witnesses(status);
  ASSERT_TRUE(test::signal_process(process_of(status, "driver-left")->pid(), SIGSTOP));
  cell.agent().signal(SIGINT);
  const auto end = cell.await_end();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 0);
  EXPECT_TRUE(witnesses.await_all_ended());
}

TEST(HealthEnd, KilledAgentTakesItsServicesAlong) {
  HealthCell cell;
  const Witnesses witnesses(cell.await_healthy());
  cell.agent().signal(SIGKILL);
  ASSERT_TRUE(cell.await_end());
  EXPECT_TRUE(witnesses.await_all_ended());
}

TEST(HealthEnd, UnknownHostIsBadInput) {
  HealthCell cell({"--host", "elsewhere"});
  const auto end = cell.await_end();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit_code, 3);
}

}  // namespace
}  // namespace hecaton::services::testing
