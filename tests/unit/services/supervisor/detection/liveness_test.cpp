#include "services/supervisor/detection/liveness.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr LivenessLimits kNodeLimits{.silence = 20ms, .lost = 100ms, .grace = 1s, .recovery = 50ms};

// An observer whose loop turns every 5 ms; a turn above 12 ms is a stall.
class LivenessTest : public ::testing::Test {
 protected:
  LivenessTest() { liveness_.expect("a", kNodeLimits); }

  void turn(Time to, bool heard) {
    const bool stalled = clock_.advance(to);
    now_ = to;
    if (heard) liveness_.heard("a", to);
    liveness_.judge(stalled);
  }
  void run_for(Time duration, bool heard) {
    for (const Time end = now_ + duration; now_ < end;) turn(now_ + 5ms, heard);
  }
  Presence presence() { return liveness_.presence("a"); }

  Time now_{0};
  StallCompensatedClock clock_{5ms, 12ms, 0ms};
  Liveness liveness_{clock_};
};

TEST_F(LivenessTest, IsMissingAfterTheGrace) {
  run_for(1s, false);
  EXPECT_EQ(presence(), Presence::kWaiting);
  run_for(5ms, false);
  EXPECT_EQ(presence(), Presence::kMissing);
}

TEST_F(LivenessTest, IsAliveAfterTheFirstPacket) {
  run_for(500ms, false);
  turn(now_ + 5ms, true);
  EXPECT_EQ(presence(), Presence::kAlive);
}

TEST_F(LivenessTest, IsSuspectedAndThenLostWhileSilent) {
  run_for(100ms, true);
  run_for(20ms, false);
  EXPECT_EQ(presence(), Presence::kAlive);
  run_for(5ms, false);
  EXPECT_EQ(presence(), Presence::kSuspected);
  run_for(75ms, false);  // 100 ms in all
  EXPECT_EQ(presence(), Presence::kSuspected);
  run_for(5ms, false);
  EXPECT_EQ(presence(), Presence::kLost);
}

TEST_F(LivenessTest, ReturnsAfterSteadyPackets) {
  run_for(100ms, true);
  run_for(30ms, false);
  run_for(50ms, true);  // the first packet arrives at 5 ms, so 45 ms without a gap
  EXPECT_EQ(presence(), Presence::kReturning);
  run_for(5ms, true);
  EXPECT_EQ(presence(), Presence::kAlive);
}

TEST_F(LivenessTest, DoesNotReturnWhileFlapping) {
  run_for(100ms, true);
  run_for(30ms, false);
  for (int i = 0; i < 50; ++i) {
    run_for(30ms, true);
    EXPECT_EQ(presence(), Presence::kReturning);
    run_for(30ms, false);
    EXPECT_EQ(presence(), Presence::kSuspected);
  }
}

TEST_F(LivenessTest, SuspectsNoSenderAfterAnOwnStall) {
  run_for(100ms, true);
  turn(now_ + 126ms, false);
  EXPECT_EQ(presence(), Presence::kAlive);
  EXPECT_EQ(clock_.last_stall(), 126ms);
  EXPECT_EQ(clock_.now(), 105ms);
}

TEST_F(LivenessTest, CountsSilenceAfreshAfterAnOwnStall) {
  run_for(100ms, true);
  run_for(20ms, false);
  turn(now_ + 126ms, false);
  run_for(20ms, false);
  EXPECT_EQ(presence(), Presence::kAlive);
  run_for(5ms, false);
  EXPECT_EQ(presence(), Presence::kSuspected);
}

TEST_F(LivenessTest, AllowsMoreSilenceAfterALongStall) {
  run_for(100ms, true);
  turn(now_ + 800ms, false);
  run_for(120ms, false);
  EXPECT_EQ(presence(), Presence::kAlive);
  run_for(5ms, false);
  EXPECT_EQ(presence(), Presence::kSuspected);
}

// Ten turns of 20 ms each are ten stalls: each counts 5 ms, and only the first is excused within 2 × 20 ms.
TEST_F(LivenessTest, DetectsASilenceDespiteStallsInARow) {
  run_for(100ms, true);
  for (int i = 0; i < 10; ++i) turn(now_ + 20ms, false);
  EXPECT_EQ(presence(), Presence::kSuspected);
}

TEST_F(LivenessTest, KeepsASenderSuspectedAfterAStall) {
  run_for(100ms, true);
  run_for(30ms, false);
  turn(now_ + 126ms, false);
  EXPECT_EQ(presence(), Presence::kSuspected);
}

TEST_F(LivenessTest, MeasuresAgesFromArrival) {
  run_for(100ms, true);
  clock_.advance(now_ + 10ms);
  liveness_.heard("a", now_ + 2ms);
  liveness_.judge(false);
  EXPECT_EQ(liveness_.silence("a"), 8ms);
}

TEST_F(LivenessTest, IgnoresOlderArrivals) {
  run_for(100ms, true);
  clock_.advance(now_ + 10ms);
  liveness_.heard("a", now_ + 9ms);
  liveness_.heard("a", now_ + 3ms);
  EXPECT_EQ(liveness_.silence("a"), 1ms);
}

TEST_F(LivenessTest, GivesARestartedSenderANewGraceAndRecovery) {
  run_for(100ms, true);
  liveness_.restarted("a");
  run_for(900ms, false);
  EXPECT_EQ(presence(), Presence::kWaiting);
  turn(now_ + 5ms, true);
  EXPECT_EQ(presence(), Presence::kReturning);
  run_for(50ms, true);
  EXPECT_EQ(presence(), Presence::kAlive);
}

TEST_F(LivenessTest, IgnoresUnknownNames) {
  liveness_.heard("b", 0ms);
  liveness_.restarted("b");
  EXPECT_FALSE(liveness_.knows("b"));
  EXPECT_FALSE(liveness_.last_heard("b"));
}

TEST(StallCompensatedClock, CountsOnlyOnePeriodOfAStall) {
  StallCompensatedClock clock(5ms, 12ms, 1000ms);
  EXPECT_FALSE(clock.advance(1012ms));
  EXPECT_EQ(clock.now(), 12ms);
  EXPECT_TRUE(clock.advance(1112ms));
  EXPECT_EQ(clock.now(), 17ms);
}

TEST(StallCompensatedClock, DatesArrivalsWithinAStallAsLateAsPossible) {
  StallCompensatedClock clock(5ms, 12ms, 0ms);
  clock.advance(10ms);
  clock.advance(110ms);
  EXPECT_EQ(clock.at(12ms), 12ms);
  EXPECT_EQ(clock.at(60ms), 15ms);
  EXPECT_EQ(clock.at(7ms), 7ms);
}

TEST(StallCompensatedClock, NeverGoesBack) {
  StallCompensatedClock clock(5ms, 12ms, 100ms);
  clock.advance(105ms);
  clock.advance(95ms);
  EXPECT_EQ(clock.now(), 5ms);
}

}  // namespace
}  // namespace hecaton::services
