// The driver's log of planners.
#include "services/arm_driver/driver_log.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

Commander commander(const std::string& planner, std::uint64_t term, std::uint8_t process) {
  Commander one{{planner, term}, {}};
  one.writer.bytes[0] = process;
  return one;
}

TEST(CommandRecord, ReportsEachChangeOfTermPlannerOrProcessOnce) {
  CommandRecord record;
  const std::vector<Commander> lives = {commander("a", 3, 1),   // the first
                                        commander("a", 4, 1),   // the same process under another term
                                        commander("b", 5, 2),   // its standby
                                        commander("b", 5, 3),   // restarted within its term
                                        commander("a", 6, 1)};  // back
  Commander before;                                             // none
  for (const Commander& life : lives) {
    EXPECT_EQ(record.accepted(life), before);
    EXPECT_FALSE(record.accepted(life));
    before = life;
  }
}

TEST(CommandRecord, ReportsTheFirstRefusalOfEachCommander) {
  CommandRecord record;
  const Commander old = commander("a", 3, 1);
  std::vector<std::uint64_t> counts;
  for (int i = 0; i < 9; ++i) {
    if (const auto times = record.refused(old, 0)) counts.push_back(times);
  }
  EXPECT_EQ(counts, (std::vector<std::uint64_t>{1, 2, 4, 8}));
  EXPECT_EQ(record.refused(commander("b", 3, 2), 0), 1U);
  EXPECT_EQ(record.refused(commander("a", 4, 1), 0), 1U);  // under another term
  EXPECT_EQ(record.refused(commander("a", 3, 3), 0), 1U);  // another process of it
  EXPECT_EQ(record.refused(old, 1), 1U);                   // for another reason
  EXPECT_EQ(record.refused(old, 0), 0U);                   // the 10th
}

TEST(CommandRecord, ReportsForgottenCommandersAgain) {
  CommandRecord record;
  for (std::uint64_t term = 1; term <= CommandRecord::kRemembered + 1; ++term) {
    EXPECT_EQ(record.refused(commander("a", term, 1), 0), 1U);
  }
  EXPECT_EQ(record.refused(commander("a", 1, 1), 0), 1U);
}

TEST(UngrantedCommands, AreToldOnceTheyHaveLasted) {
  UngrantedCommands commands;
  bus::Clock::time_point now(std::chrono::minutes(1));
  const auto lasting = now + UngrantedCommands::kLasting;
  for (; now < lasting; now += std::chrono::milliseconds(10)) EXPECT_FALSE(commands.note(now));
  EXPECT_TRUE(commands.note(now));
  EXPECT_FALSE(commands.note(now + std::chrono::seconds(2))) << "a later failover";
}

}  // namespace
}  // namespace hecaton::services
