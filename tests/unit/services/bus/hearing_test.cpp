#include "services/bus/hearing.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kBeginning{1h};
constexpr Hearing::Prefix kPeer{1};
constexpr Hearing::Prefix kOther{2};
constexpr Hearing::Address kItsAddress = 11;
constexpr Hearing::Address kOthersAddress = 22;

/// Of two that were found at kBeginning only the other goes on talking.
struct Silence {
  Hearing hearing{2s};
  Clock::time_point now = kBeginning;

  Silence() {
    hearing.found(kPeer, {kItsAddress}, now);
    hearing.found(kOther, {kOthersAddress}, now);
  }
  void last(Clock::duration duration) {
    for (const auto end = now + duration; now < end;) {
      now += 50ms;
      EXPECT_TRUE(hearing.hears(kOther, now));
      hearing.look(now, kBeginning);
    }
  }
};

TEST(Hearing, AnybodyIsHeardWhoTalks) {
  Silence silence;
  silence.last(1600ms);
  EXPECT_FALSE(silence.hearing.shuns_anybody());
  EXPECT_TRUE(silence.hearing.hears(kPeer, silence.now));
  EXPECT_TRUE(silence.hearing.hears({3}, silence.now)) << "a stranger";
  silence.last(1600ms);
  EXPECT_FALSE(silence.hearing.shuns(kItsAddress));
}

TEST(Hearing, WhoIsSilentForMostOfTheLeaseIsShunnedForLongerThanIt) {
  Silence silence;
  silence.last(1650ms);
  EXPECT_TRUE(silence.hearing.shuns(kItsAddress));
  EXPECT_FALSE(silence.hearing.shuns(kOthersAddress));
  EXPECT_FALSE(silence.hearing.hears(kPeer, silence.now)) << "the link is back, but the other side may drop us yet";
  silence.hearing.dropped(kPeer, silence.now + 400ms);  // our own lease
  silence.last(2450ms);
  EXPECT_TRUE(silence.hearing.shuns(kItsAddress));
  silence.last(100ms);
  EXPECT_FALSE(silence.hearing.shuns_anybody());
  EXPECT_TRUE(silence.hearing.hears(kPeer, silence.now));
}

// It was forgotten then, so that nobody left it alone when it fell silent again.
TEST(Hearing, WhoIsFoundAgainBeforeAnybodyLooksIsWatchedAsBefore) {
  Silence silence;
  silence.last(1650ms);
  silence.last(2450ms);
  ASSERT_TRUE(silence.hearing.shuns(kItsAddress));
  silence.now += 60ms;  // the quarantine is over
  ASSERT_TRUE(silence.hearing.hears(kPeer, silence.now));
  silence.hearing.found(kPeer, {kItsAddress}, silence.now);
  EXPECT_FALSE(silence.hearing.shuns(kItsAddress)) << "it is answered at once";
  silence.last(1600ms);
  EXPECT_FALSE(silence.hearing.shuns_anybody());
  silence.last(100ms);
  EXPECT_TRUE(silence.hearing.shuns(kItsAddress));
}

TEST(Hearing, SilenceWhileWeDidNotListenIsNobodysFault) {
  Hearing hearing{2s};
  hearing.found(kPeer, {kItsAddress}, kBeginning);
  hearing.look(kBeginning + 3s, kBeginning + 3s);
  EXPECT_FALSE(hearing.shuns_anybody());
  hearing.look(kBeginning + 4700ms, kBeginning + 3s);
  EXPECT_TRUE(hearing.shuns(kItsAddress));
}

TEST(Hearing, ASuccessorAtTheSameAddressIsSpokenTo) {
  Silence silence;
  silence.last(1650ms);
  ASSERT_TRUE(silence.hearing.shuns(kItsAddress));
  silence.hearing.found({3}, {kItsAddress}, silence.now);
  EXPECT_FALSE(silence.hearing.shuns(kItsAddress));
  EXPECT_FALSE(silence.hearing.shuns_anybody());
}

// We slept for a while, so its silence was not held against it; but Fast DDS has counted it.
TEST(Hearing, WhoIsDroppedIsShunnedFromThenOn) {
  Hearing hearing{2s};
  hearing.found(kPeer, {kItsAddress}, kBeginning);
  hearing.look(kBeginning + 2s, kBeginning + 1s);
  ASSERT_FALSE(hearing.shuns_anybody());
  hearing.dropped(kPeer, kBeginning + 2s);
  EXPECT_TRUE(hearing.shuns(kItsAddress));
  EXPECT_FALSE(hearing.hears(kPeer, kBeginning + 2001ms)) << "it may know us yet, and would again be known one-sidedly";
  hearing.look(kBeginning + 4499ms, kBeginning + 1s);
  EXPECT_TRUE(hearing.shuns(kItsAddress));
  hearing.look(kBeginning + 4500ms, kBeginning + 1s);
  EXPECT_FALSE(hearing.shuns_anybody());
  EXPECT_TRUE(hearing.hears(kPeer, kBeginning + 4501ms));
}

TEST(Hearing, WhoLeftIsForgotten) {
  Silence silence;
  silence.hearing.left(kPeer, silence.now);
  silence.last(5s);
  EXPECT_FALSE(silence.hearing.shuns_anybody());
}

}  // namespace
}  // namespace hecaton::bus
