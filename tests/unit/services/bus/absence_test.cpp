#include "services/bus/absence.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kBegin{1h};

/// A process that looks every 50 ms unless it is stopped.
struct Life {
  Absence absence{2s, kBegin};
  Clock::time_point now = kBegin;

  bool run_for(Clock::duration duration) {
    bool began = false;
    for (const auto end = now + duration; now < end;) {
      now += Absence::kLook;
      began = absence.look(now) || began;
    }
    return began;
  }
};

TEST(Absence, WhoRunsIsThere) {
  Life life;
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(life.run_for(50ms));
    EXPECT_FALSE(life.absence.away(life.now + 49ms));
    EXPECT_EQ(life.absence.arrival(life.now + 49ms), life.now + 49ms);
  }
}

TEST(Absence, StallsOfABusyMachineAreNone) {
  Life life;
  EXPECT_FALSE(life.absence.away(life.now + 126ms));
  EXPECT_FALSE(life.absence.look(life.now + 126ms));
  EXPECT_FALSE(life.absence.away(life.now + 127ms));
}

TEST(Absence, AfterAShortOneOnlyTheBacklogIsThrownAway) {
  Life life;
  life.run_for(1s);
  const auto before = life.now;
  life.now += 600ms;
  EXPECT_TRUE(life.absence.away(life.now)) << "also before anybody has looked";
  EXPECT_EQ(life.absence.arrival(life.now), before) << "what is taken now came before the stall";
  EXPECT_FALSE(life.absence.overslept(life.now));
  EXPECT_FALSE(life.absence.look(life.now));
  EXPECT_TRUE(life.absence.away(life.now + 19ms));
  EXPECT_FALSE(life.absence.away(life.now + 20ms));
}

// The peers' lease of 2 s began with the last that they heard: no later than the stall. Ours began no later than now.
TEST(Absence, AfterALongOneTheLeaseRunsOutOnBothSides) {
  Life life;
  life.run_for(1s);
  life.now += 1100ms;
  EXPECT_TRUE(life.absence.overslept(life.now));
  const auto woken = life.now;
  EXPECT_TRUE(life.absence.look(life.now));
  EXPECT_FALSE(life.absence.overslept(life.now));
  EXPECT_FALSE(life.run_for(2450ms)) << "one absence, told once";
  EXPECT_TRUE(life.absence.away(woken + 2450ms));
  life.run_for(50ms);
  EXPECT_FALSE(life.absence.away(woken + 2500ms));
}

TEST(Absence, ShortLeasesDoNotMakeEveryPauseLong) {
  Absence absence{20ms, kBegin};
  EXPECT_FALSE(absence.overslept(kBegin + 200ms));
  EXPECT_TRUE(absence.overslept(kBegin + 300ms));
}

}  // namespace
}  // namespace hecaton::bus
