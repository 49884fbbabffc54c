#include "services/bus/stream_holder.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "services/bus/refusals.hpp"
#include "services/bus/term_limit.hpp"

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

EndpointId endpoint(std::uint8_t participant, std::uint8_t entity = 1) {
  EndpointId id;
  id.bytes.front() = participant;
  id.bytes.back() = entity;
  return id;
}

class StreamHolderTest : public testing::Test {
 protected:
  bool admits(std::uint8_t participant) { return holder_.admits(endpoint(participant), now_, 200ms); }

  StreamHolder holder_;
  Clock::time_point now_{10s};
};

TEST_F(StreamHolderTest, RefusesASecondParticipantWhileTheFirstWrites) {
  EXPECT_TRUE(admits(1));
  for (int i = 0; i < 100; ++i) {
    now_ += 2ms;
    EXPECT_FALSE(admits(2));
    EXPECT_TRUE(admits(1));
    EXPECT_EQ(holder_.take_challenger(), endpoint(2)) << "both write at one time";
  }
  EXPECT_TRUE(holder_.admits(endpoint(1, 9), now_, 200ms)) << "another writer of the same participant";
}

TEST_F(StreamHolderTest, GivesTheKeyToASuccessorAndReportsNone) {
  ASSERT_TRUE(admits(1));
  now_ += 150ms;
  EXPECT_FALSE(admits(2)) << "the first one may be late";
  now_ += 60ms;
  EXPECT_TRUE(admits(2));
  now_ += 10ms;
  EXPECT_TRUE(admits(2));
  EXPECT_EQ(holder_.take_challenger(), std::nullopt);
  EXPECT_EQ(holder_.holder(), endpoint(2));
}

TEST(WriterChanges, ReportTwoWritersAndNoFailover) {
  WriterChanges changes;
  Clock::time_point now{10s};
  EXPECT_FALSE(changes.note(endpoint(1), 0, now));
  EXPECT_FALSE(changes.note(endpoint(2), 0, now)) << "a failover";
  bool reported = false;
  for (int i = 0; i < 20; ++i) {
    now += 10ms;
    reported = changes.note(endpoint(static_cast<std::uint8_t>(1 + i % 2)), 0, now);
  }
  EXPECT_TRUE(reported);
  now += 2s;
  EXPECT_FALSE(changes.note(endpoint(1), 0, now)) << "one of them has left";
}

// hecaton-chaos has shown this: a leader whose host receives nothing writes for seconds beside its successor.
TEST(WriterChanges, IgnoreALeaderThatDoesNotHearItsSuccessor) {
  WriterChanges changes;
  Clock::time_point now{10s};
  EXPECT_FALSE(changes.note(endpoint(1), 21, now));
  bool reported = false;
  for (int i = 0; i < 100; ++i) {
    now += 10ms;
    reported = reported || changes.note(endpoint(2), 44, now) || changes.note(endpoint(1), 21, now);
  }
  EXPECT_FALSE(reported) << "readers follow the term 44";
  for (int i = 0; i < 20; ++i) {
    now += 10ms;
    reported = changes.note(endpoint(static_cast<std::uint8_t>(2 + i % 2)), 44, now);
  }
  EXPECT_TRUE(reported) << "two writers of one term";
}

TEST(WriterChanges, ReportAnIntruderUnderAnOldTerm) {
  WriterChanges changes;
  Clock::time_point now{10s};
  EXPECT_FALSE(changes.note(endpoint(1), 21, now));
  EXPECT_FALSE(changes.note(endpoint(2), 44, now));
  bool reported = false;
  for (int i = 0; i < 20; ++i) {
    now += 10ms;
    const bool intruder = i % 2 == 0;
    reported = changes.note(endpoint(intruder ? 3 : 2), intruder ? 21 : 44, now);
  }
  EXPECT_TRUE(reported) << "it has never led";
}

// An intruder may be heard first.
TEST(TermLimit, DoesNotBeginWithATermThatNoCellHas) {
  constexpr Clock::time_point kBegin{10s};
  TermLimit terms(kBegin);
  EXPECT_FALSE(terms.admits(kLargestTerm, kBegin));
  EXPECT_FALSE(terms.admits(kLargestFirstTerm, kBegin + TermLimit::kFirstWait));
  EXPECT_FALSE(terms.admits(kTermLeap + 1, kBegin));
  EXPECT_TRUE(terms.admits(0, kBegin));
  EXPECT_TRUE(terms.admits(7, kBegin + 1s)) << "the cell itself";
  EXPECT_FALSE(terms.admits(kLargestFirstTerm, kBegin + 1h)) << "it leaps";
  EXPECT_TRUE(terms.admits(kTermLeap + 7, kBegin + 1h));
}

TEST(TermLimit, JoinsACellWhoseTermAnIntruderHasRaised) {
  constexpr Clock::time_point kBegin{10s};
  TermLimit terms(kBegin);
  const auto later = kBegin + TermLimit::kFirstWait + 1s;
  EXPECT_FALSE(terms.admits(kLargestFirstTerm + 1, later));
  EXPECT_TRUE(terms.admits(kLargestFirstTerm, later));
}

TEST(TermLimit, BeginsWithTheTermOfTheCheckpoint) {
  constexpr Clock::time_point kBegin{10s};
  TermLimit terms(kBegin);
  terms.know(5);
  EXPECT_FALSE(terms.admits(kLargestFirstTerm, kBegin + 1h));
  terms.know(kLargestTerm);
  EXPECT_FALSE(terms.admits(kLargestFirstTerm, kBegin + 1h)) << "no usable term";
  terms.know(3 * kTermLeap);
  EXPECT_TRUE(terms.admits(4 * kTermLeap, kBegin)) << "the cell of this process";
  EXPECT_TRUE(terms.admits(1, kBegin)) << "older ones are for the services to refuse";
}

TEST(SampleRate, AdmitsAsManyAsAllowedInASecond) {
  SampleRate rate;
  Clock::time_point now{10s};
  int admitted = 0;
  for (int i = 0; i < 1000; ++i) admitted += rate.admits(now, 10) ? 1 : 0;
  EXPECT_EQ(admitted, 10);
  EXPECT_TRUE(rate.admits(now + 1100ms, 10));
  EXPECT_TRUE(SampleRate().admits(now, 0)) << "no limit";
}

// Each of an intruder's datagrams has another GUID.
TEST(RefusalLog, NamesASecondWriterAndAWrongTermInAFlood) {
  RefusalLog log;
  Clock::time_point now{10s};
  log.note({.kind = RefusalKind::kSecondWriter, .topic = "ArmState", .sender = endpoint(1), .text = "x", .last = now});
  log.note({.kind = RefusalKind::kNotGranted, .topic = "ArmCommand", .sender = endpoint(2), .text = "y", .last = now});
  for (int i = 0; i < 1000; ++i) {
    now += 1ms;
    EndpointId forged = endpoint(3);
    forged.bytes[1] = static_cast<std::uint8_t>(i);
    forged.bytes[2] = static_cast<std::uint8_t>(i / 256);
    log.note({.sender = forged, .text = "a gap", .last = now, .address = i % 2 == 0 ? "10.0.0.8" : "10.0.0.9"});
    log.note({.topic = "Goal", .sender = forged, .text = "too long", .last = now});
  }
  const auto recent = log.recent(Clock::time_point(9s), 4);
  ASSERT_EQ(recent.size(), 4U);
  EXPECT_EQ(recent[0].text, "x");
  EXPECT_EQ(recent[1].text, "y");
  const auto all = log.recent(Clock::time_point(9s), 500);
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const Refused& one) { return one.topic.empty(); }), 2)
      << "one for each address";
}

TEST(RefusalLog, CountsBySenderAndForgetsTheQuietest) {
  RefusalLog log;
  Clock::time_point now{10s};
  log.found(endpoint(1, 0), "intru\x1B[31mder", "10.0.0.9");
  for (int i = 0; i < 3; ++i)
    log.note({.topic = "ArmCommand", .sender = endpoint(1), .text = "q[0] = nan", .last = now});
  for (int i = 2; i < 200; ++i) {
    now += 1ms;
    log.note({.topic = "Goal", .sender = endpoint(static_cast<std::uint8_t>(i)), .text = "x", .last = now});
    log.note({.topic = "ArmCommand", .sender = endpoint(1), .text = std::string(5000, '\xC3'), .last = now});
  }
  const auto recent = log.recent(Clock::time_point(10s), 500);
  EXPECT_LE(recent.size(), RefusalLog::kSenders);
  const auto first =
      std::find_if(recent.begin(), recent.end(), [](const auto& one) { return one.sender == endpoint(1); });
  ASSERT_NE(first, recent.end());
  EXPECT_EQ(first->count, 3U + 198U);
  EXPECT_EQ(first->node, "intru?[31mder");
  EXPECT_EQ(first->address, "10.0.0.9");
  EXPECT_EQ(first->text, std::string(RefusalLog::kLongestText, '?'));
  EXPECT_TRUE(log.recent(now, 500).empty());
}

}  // namespace
}  // namespace hecaton::bus
