#include "services/supervisor/fault_list.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

const FaultObservation kSilent{msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_WARNING, "planner/a",
                               "silent"};
const FaultObservation kSilentLong{msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_ERROR, "planner/a",
                                   "silent for long"};
const FaultObservation kDied{msg::CauseKind::CAUSE_PROCESS_DIED, msg::Severity::SEVERITY_ERROR, "planner/a",
                             "signal 9"};

TEST(FaultList, HasOneRecordForOneOccurrence) {
  FaultList faults;
  for (int i = 0; i < 3; ++i) faults.raise("planner/a", kSilent, 5ms * i);
  ASSERT_EQ(faults.open().size(), 1U);
  EXPECT_EQ(faults.open().front().since, 0ms);
  EXPECT_EQ(faults.take_changes().size(), 1U);
}

TEST(FaultList, ContinuesWithRestoredFaults) {
  FaultList first;
  first.begin_term(3);
  first.raise("planner/a", kSilent, 10ms);
  first.clear("planner/a", 20ms);
  first.raise("planner/a", kDied, 30ms);

  FaultList second;
  second.restore(first.history());
  second.begin_term(4);
  EXPECT_EQ(second.take_restored(), (std::vector<FaultRecord>{first.cleared().front()})) << "published again";
  EXPECT_EQ(second.take_changes(), first.open()) << "open faults are changes";
  EXPECT_TRUE(second.take_restored().empty());
  second.raise("planner/a", kSilentLong, 40ms);
  ASSERT_EQ(second.open().size(), 1U) << "the same occurrence";
  EXPECT_EQ(second.open().front().since, 30ms);
  second.clear("planner/a", 50ms);
  second.raise("planner/a", kSilent, 60ms);
  EXPECT_EQ(second.open().front().opening_term, 4U);
  ASSERT_EQ(second.cleared().size(), 2U);
  EXPECT_EQ(second.cleared().front().opening_term, 3U);
  EXPECT_EQ(second.cleared().front().number, 2U);
  EXPECT_EQ(second.cleared().front().cleared_at, 50ms);
}

TEST(FaultList, AssignsTheFirstTermToEarlierFaults) {
  FaultList faults;
  faults.raise("planner/a", kDied, 10ms);
  faults.clear("planner/a", 20ms);
  faults.raise("planner/a", kSilent, 30ms);
  faults.begin_term(4);
  for (const FaultRecord& record : faults.take_changes()) EXPECT_EQ(record.opening_term, 4U);
  EXPECT_EQ(faults.open().front().opening_term, 4U);
  EXPECT_EQ(faults.cleared().front().opening_term, 4U);
  faults.begin_term(6);
  EXPECT_EQ(faults.open().front().opening_term, 4U);
}

TEST(FaultList, HasAUniqueNameForEachKind) {
  for (int i = 0; i <= static_cast<int>(msg::CauseKind::CAUSE_HOST_LOST); ++i) {
    const auto kind = static_cast<msg::CauseKind>(i);
    EXPECT_EQ(cause_kind(cause_name(kind)), kind);
  }
  EXPECT_FALSE(cause_kind("unknown"));
}

TEST(FaultList, CorrectsTheRecordByAStrongerExplanation) {
  FaultList faults;
  faults.raise("planner/a", kSilent, 10ms);
  faults.raise("planner/a", kDied, 15ms);
  ASSERT_EQ(faults.open().size(), 1U);
  const FaultRecord& record = *faults.open("planner/a");
  EXPECT_EQ(record.kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_EQ(record.description, "signal 9");
  EXPECT_EQ(record.since, 10ms);
  EXPECT_EQ(record.number, 1U);
}

TEST(FaultList, IgnoresAWeakerExplanation) {
  FaultList faults;
  faults.raise("planner/a", kDied, 10ms);
  static_cast<void>(faults.take_changes());
  faults.raise("planner/a", kSilentLong, 30ms);
  EXPECT_EQ(faults.open("planner/a")->kind, msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_TRUE(faults.take_changes().empty());
}

TEST(FaultList, ReportsAHigherSeverity) {
  FaultList faults;
  faults.raise("planner/a", kSilent, 10ms);
  faults.raise("planner/a", kSilentLong, 90ms);
  const auto changes = faults.take_changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[1].severity, msg::Severity::SEVERITY_ERROR);
  EXPECT_EQ(changes[1].number, changes[0].number);
}

TEST(FaultList, OpensANewFaultAfterAClearedOne) {
  FaultList faults;
  faults.raise("planner/a", kSilent, 10ms);
  faults.clear("planner/a", 30ms);
  faults.clear("planner/a", 40ms);
  EXPECT_TRUE(faults.open().empty());
  ASSERT_EQ(faults.cleared().size(), 1U);
  EXPECT_EQ(faults.cleared().front().cleared_at, 30ms);
  faults.raise("planner/a", kSilent, 50ms);
  EXPECT_EQ(faults.open("planner/a")->number, 2U);
  EXPECT_EQ(faults.open("planner/a")->since, 50ms);
}

TEST(FaultList, KeepsFaultsOfDifferentKeysApart) {
  FaultList faults;
  faults.raise("planner/a", kSilent, 10ms);
  faults.raise("planner/b", kDied, 10ms);
  faults.clear("planner/a", 20ms);
  EXPECT_EQ(faults.open("planner/a"), nullptr);
  EXPECT_NE(faults.open("planner/b"), nullptr);
}

TEST(FaultList, KeepsTheLatestClearedFaults) {
  FaultList faults;
  const auto more = FaultList::kClearedKept + 3;
  for (std::size_t i = 0; i < more; ++i) {
    faults.raise("planner/a", kSilent, 10ms);
    faults.clear("planner/a", 20ms);
  }
  EXPECT_EQ(faults.cleared().size(), FaultList::kClearedKept);
  EXPECT_EQ(faults.cleared().front().number, more);
}

FaultRecord of_another(std::uint64_t number, std::optional<std::chrono::nanoseconds> cleared) {
  return {9,   number, msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_WARNING, "planner/a", "silent", 10ms,
          3ms, cleared};
}

TEST(FaultList, AdoptsAFaultUnchanged) {
  FaultList faults;
  faults.begin_term(10);
  faults.raise("planner/b", kSilent, 15ms);
  faults.clear("planner/b", 25ms);
  static_cast<void>(faults.take_changes());
  const FaultRecord cleared = of_another(1, 20ms);
  const FaultRecord lasting = of_another(2, std::nullopt);
  faults.adopt("planner/a", cleared, 40ms);
  faults.adopt("planner/a", lasting, 40ms);
  ASSERT_EQ(faults.cleared().size(), 2U);
  EXPECT_EQ(faults.cleared().back(), cleared) << "behind those that were cleared later";
  ASSERT_NE(faults.open("planner/a"), nullptr);
  EXPECT_EQ(*faults.open("planner/a"), lasting);
  EXPECT_EQ(faults.take_changes(), (std::vector{cleared, lasting})) << "published under the own term";
  faults.adopt("planner/a", cleared, 50ms);
  faults.adopt("planner/a", lasting, 50ms);
  EXPECT_TRUE(faults.take_changes().empty()) << "known";
  faults.clear("planner/a", 60ms);
  EXPECT_EQ(faults.cleared().front().opening_term, 9U);
  EXPECT_EQ(faults.cleared().front().cleared_at, 60ms);
}

TEST(FaultList, AdoptsABetterExplanationOfAKnownFault) {
  FaultList faults;
  faults.adopt("planner/a", of_another(1, 20ms), 40ms);
  faults.adopt("planner/a", of_another(2, std::nullopt), 40ms);
  for (const std::uint64_t number : {1, 2}) {
    FaultRecord better = of_another(number, 30ms);
    better.kind = msg::CauseKind::CAUSE_PROCESS_DIED;
    better.description = "signal 9";
    faults.adopt("planner/a", better, 50ms);
  }
  EXPECT_EQ(faults.cleared().front().description, "signal 9");
  EXPECT_EQ(faults.cleared().front().cleared_at, 20ms);
  ASSERT_NE(faults.open("planner/a"), nullptr) << "only the detector clears it";
  EXPECT_EQ(faults.open("planner/a")->kind, msg::CauseKind::CAUSE_PROCESS_DIED);
}

TEST(FaultList, KeepsOneOfTwoAdoptedFaultsOfOneKeyOpen) {
  FaultList faults;
  faults.begin_term(10);
  faults.raise("planner/a", kSilent, 15ms);
  FaultRecord theirs = of_another(1, std::nullopt);
  theirs.kind = msg::CauseKind::CAUSE_PROCESS_DIED;
  theirs.description = "signal 9";
  faults.adopt("planner/a", theirs, 40ms);
  ASSERT_EQ(faults.open().size(), 1U);
  EXPECT_EQ(faults.open().front().opening_term, 10U);
  EXPECT_EQ(faults.open().front().description, "signal 9");
  ASSERT_EQ(faults.cleared().size(), 1U);
  EXPECT_EQ(faults.cleared().front().opening_term, 9U);
  EXPECT_EQ(faults.cleared().front().cleared_at, 40ms);
}

// Two leaders may exist for a second, until one hears the other.
TEST(FaultList, TwoListsThatAdoptFromEachOtherConverge) {
  constexpr std::uint64_t kEach = FaultList::kClearedKept;
  FaultList one;
  FaultList other;
  for (std::uint64_t i = 1; i <= kEach; ++i) {
    one.adopt("planner/a", of_another(2 * i, std::chrono::milliseconds(2 * i)), 1s);
    other.adopt("planner/a", of_another(2 * i + 1, std::chrono::milliseconds(2 * i + 1)), 1s);
  }
  int rounds = 0;
  for (bool news = true; news && rounds < 10; ++rounds) {
    news = false;
    for (const auto& [from, to] : {std::pair(&one, &other), std::pair(&other, &one)}) {
      for (const FaultRecord& told : from->take_changes()) {
        news = true;
        to->adopt("planner/a", told, 1s);
      }
    }
  }
  EXPECT_LT(rounds, 10);
  EXPECT_EQ(one.cleared(), other.cleared()) << "the latest of both";
  EXPECT_EQ(one.cleared().back().number, kEach + 2);
}

TEST(FaultList, AdoptsNoFaultOlderThanAllThatItKeeps) {
  FaultList faults;
  for (std::uint64_t i = 1; i <= FaultList::kClearedKept + 3; ++i) {
    faults.adopt("planner/a", of_another(i, std::chrono::milliseconds(i)), 1s);
  }
  EXPECT_EQ(faults.cleared().size(), FaultList::kClearedKept);
  EXPECT_EQ(faults.cleared().front().number, FaultList::kClearedKept + 3);
  EXPECT_EQ(faults.cleared().back().number, 4U);
}

}  // namespace
}  // namespace hecaton::services
