#include "services/supervisor/failover/leadership.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Role = Leadership::Role;

/// No gap between packets limits the silence of the leader.
constexpr Leadership::Limits kLimits{.listen = 200ms, .search = 200ms, .silence = 300ms, .pause = 1h};

/// Of the first of two supervisors: even terms. The other one takes odd terms.
constexpr Leadership::TermShare kFirst{0, 2};

TEST(Leadership, ListensAndThenLeadsAboveAllObservedTerms) {
  Leadership own(kLimits, 0, 0ms);
  own.observe_term(7, 0ms);
  own.observe_lease(3);
  EXPECT_FALSE(own.decide(199ms, 199ms));
  EXPECT_EQ(own.role(), Role::kListening);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  EXPECT_EQ(own.role(), Role::kLeading);
  EXPECT_EQ(own.term(), 8U);
  EXPECT_FALSE(own.decide(205ms, 205ms));
}

TEST(Leadership, LeadsAboveTheTermOfItsCheckpoint) {
  Leadership own(kLimits, 41, 0ms);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  EXPECT_EQ(own.term(), 42U);
}

// A supervisor that led or stood by before has most likely been replaced. No supervisor for a while is better than two.
TEST(Leadership, SearchesForALeaderBeforeItLeadsAgain) {
  constexpr Leadership::Limits kSearches{.listen = 200ms, .search = 2s, .silence = 300ms, .pause = 1h};
  Leadership fresh(kSearches, 0, 0ms, kFirst);
  EXPECT_TRUE(fresh.decide(200ms, 200ms)) << "it has no checkpoint";
  fresh.restart_listening(5s);
  EXPECT_FALSE(fresh.decide(6999ms, 6999ms));
  EXPECT_TRUE(fresh.decide(7s, 7s));

  Leadership restarted(kSearches, 41, 0ms, kFirst);
  EXPECT_FALSE(restarted.decide(1999ms, 1999ms));
  EXPECT_TRUE(restarted.decide(2s, 2s));

  Leadership replaced(kSearches, 41, 0ms, kFirst);
  replaced.observe_leader(43, 100ms);
  EXPECT_FALSE(replaced.decide(200ms, 200ms));
  EXPECT_EQ(replaced.role(), Role::kStandingBy) << "found";
  EXPECT_TRUE(replaced.decide(401ms, 401ms)) << "the leader is silent: a standby does not search";
}

TEST(Leadership, ListensFromTheEndOfTheHandshakeWithAnotherSupervisor) {
  Leadership own(kLimits, 41, 10s, kFirst);
  for (auto now = 10s + 0ms; now <= 12s; now += 5ms) {
    own.observe_joining(now);
    EXPECT_FALSE(own.decide(now, now));
  }
  EXPECT_FALSE(own.decide(12199ms, 12199ms));
  own.observe_leader(43, 12199ms);
  EXPECT_FALSE(own.decide(12200ms, 12200ms));
  EXPECT_EQ(own.role(), Role::kStandingBy);

  Leadership alone(kLimits, 41, 10s, kFirst);
  alone.observe_joining(12s);
  EXPECT_FALSE(alone.decide(12199ms, 12199ms));
  EXPECT_TRUE(alone.decide(12200ms, 12200ms)) << "the other one leads neither";
}

TEST(Leadership, WaitsForAHandshakeWithinALimit) {
  Leadership own(kLimits, 41, 10s);
  const auto end = 10s + kLimits.join + kLimits.listen;
  for (std::chrono::nanoseconds now = 10s; now < end; now += 5ms) {
    own.observe_joining(now);
    EXPECT_FALSE(own.decide(now, now));
  }
  own.observe_joining(end);
  EXPECT_TRUE(own.decide(end, end)) << "it never ends";
}

TEST(Leadership, ListensAfterAnAbsenceAndLeadsUnderANewTerm) {
  Leadership own(kLimits, 0, 0ms);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  own.restart_listening(5s);
  EXPECT_EQ(own.role(), Role::kListening);
  EXPECT_FALSE(own.decide(5199ms, 5199ms));
  EXPECT_TRUE(own.decide(5200ms, 5200ms));
  EXPECT_EQ(own.term(), 2U);
}

TEST(Leadership, StandsByAfterAnAbsenceWithAnotherLeader) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  own.restart_listening(5s);
  own.observe_leader(3, 5190ms);
  EXPECT_FALSE(own.decide(5200ms, 5200ms));
  EXPECT_EQ(own.role(), Role::kStandingBy);
}

TEST(Leadership, ListensAgainWhenNodesHaveFollowedAHigherTerm) {
  Leadership own(kLimits, 0, 0ms, {0, 2});
  EXPECT_TRUE(own.decide(200ms, 200ms));
  own.observe_term(2, 210ms);
  EXPECT_EQ(own.role(), Role::kLeading) << "its own";
  own.observe_term(5, 220ms);
  EXPECT_EQ(own.role(), Role::kListening);
  EXPECT_FALSE(own.decide(419ms, 419ms));
  EXPECT_TRUE(own.decide(420ms, 420ms));
  EXPECT_EQ(own.term(), 6U);
}

// No other supervisor can lead, and an intruder may have claimed the term.
TEST(Leadership, LeadsOnAtOnceUnderAHigherTermInACellWithOneSupervisor) {
  constexpr Leadership::Limits kSearches{.listen = 200ms, .search = 2s, .silence = 300ms, .pause = 1h};
  Leadership alone(kSearches, 0, 0ms);
  EXPECT_TRUE(alone.decide(200ms, 200ms));
  alone.observe_term(5, 220ms);
  EXPECT_TRUE(alone.decide(219ms, 219ms)) << "the turn began before the heartbeat arrived";
  EXPECT_EQ(alone.role(), Role::kLeading);
  EXPECT_EQ(alone.term(), 6U);
  alone.restart_listening(1s);
  EXPECT_FALSE(alone.decide(1s + 199ms, 1s + 199ms)) << "it was away itself";
}

TEST(Leadership, DoesNotListenAgainForTheTermOfALease) {
  Leadership own(kLimits, 0, 0ms);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  own.observe_lease(9);
  EXPECT_EQ(own.role(), Role::kLeading);
  EXPECT_EQ(own.term(), 1U);
  EXPECT_EQ(own.take_term(), 10U);
}

TEST(Leadership, TwoSupervisorsNeverTakeTheSameTerm) {
  Leadership first(kLimits, 0, 0ms, {0, 2});
  Leadership second(kLimits, 0, 0ms, {1, 2});
  EXPECT_TRUE(first.decide(200ms, 200ms));
  EXPECT_TRUE(second.decide(200ms, 200ms));
  EXPECT_EQ(first.term(), 2U);
  EXPECT_EQ(second.term(), 1U);
  second.observe_lease(4);
  EXPECT_EQ(second.take_term(), 5U);
  EXPECT_EQ(second.take_term(), 7U);
  EXPECT_EQ(first.take_term(), 4U);
}

TEST(Leadership, LeadsAtOnceWhenTheLeadersProcessEnded) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  own.observe_leader(3, 190ms);
  EXPECT_FALSE(own.decide(200ms, 200ms));
  own.leader_died();
  EXPECT_TRUE(own.decide(201ms, 201ms));
  EXPECT_EQ(own.term(), 4U);
}

TEST(Leadership, StandsByWhileAnotherLeads) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  for (auto now = 0ms; now <= 2s; now += 25ms) {
    own.observe_leader(3, now);
    EXPECT_FALSE(own.decide(now, now));
  }
  EXPECT_EQ(own.role(), Role::kStandingBy);
}

TEST(Leadership, LeadsWhenTheLeaderIsSilent) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  own.observe_leader(3, 150ms);
  EXPECT_FALSE(own.decide(200ms, 200ms));
  EXPECT_FALSE(own.decide(450ms, 450ms));
  EXPECT_TRUE(own.decide(451ms, 451ms));
  EXPECT_EQ(own.term(), 4U);
}

// The leader's messages may still wait in the socket.
TEST(Leadership, DoesNotLeadWhileItHearsNoOtherHost) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  own.observe_leader(3, 190ms);
  EXPECT_FALSE(own.decide(200ms, 195ms));
  EXPECT_FALSE(own.decide(5s, 195ms));
  EXPECT_FALSE(own.decide(5005ms, 490ms)) << "messages arrive in their order";
  own.observe_leader(3, 4990ms);
  EXPECT_FALSE(own.decide(5010ms, 5005ms));
  EXPECT_TRUE(own.decide(5300ms, 5291ms)) << "others are heard, and the leader is not";
}

// After a partition hosts are not heard again all at once.
TEST(Leadership, GivesALeaderTimeToBeHeardAgainAfterAPause) {
  Leadership own({.listen = 200ms, .search = 200ms, .silence = 300ms, .pause = 100ms}, 0, 0ms, kFirst);
  own.observe_leader(3, 190ms);
  EXPECT_FALSE(own.decide(200ms, 200ms));
  for (auto now = 5000ms; now <= 5180ms; now += 20ms)
    EXPECT_FALSE(own.decide(now, now)) << "cut off, now others are heard";
  own.observe_leader(3, 5190ms);
  for (auto now = 5200ms; now <= 5480ms; now += 20ms) EXPECT_FALSE(own.decide(now, now)) << "the leader is heard, too";
  EXPECT_TRUE(own.decide(5500ms, 5500ms));
}

TEST(Leadership, StepsDownForAHigherTerm) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  own.observe_leader(9, 210ms);
  EXPECT_EQ(own.role(), Role::kStandingBy);
  EXPECT_FALSE(own.decide(215ms, 215ms));
  EXPECT_TRUE(own.decide(600ms, 600ms));
  EXPECT_EQ(own.term(), 10U);
}

TEST(Leadership, IgnoresALeaderOfALowerTerm) {
  Leadership own(kLimits, 4, 0ms, kFirst);
  EXPECT_TRUE(own.decide(200ms, 200ms));
  own.observe_leader(5, 210ms);
  EXPECT_EQ(own.role(), Role::kLeading);
  EXPECT_EQ(own.term(), 6U);
}

// It is of an earlier process of this supervisor, or forged.
TEST(Leadership, LeadsOnAboveACellModeOfATermOfItsOwnShare) {
  constexpr Leadership::Limits kSearches{.listen = 200ms, .search = 2s, .silence = 300ms, .pause = 1h};
  for (const Leadership::TermShare share : {Leadership::TermShare{0, 1}, kFirst}) {
    Leadership own(kSearches, 0, 0ms, share);
    EXPECT_TRUE(own.decide(200ms, 200ms));
    for (auto now = 300ms; now < 2s; now += 100ms) {
      const std::uint64_t forged = own.term() + 2 * (now.count() % 200);
      own.observe_leader(forged, now);
      EXPECT_TRUE(own.decide(now - 1ms, now - 1ms)) << "the turn began before the mode arrived";
      EXPECT_EQ(own.role(), Role::kLeading);
      EXPECT_GT(own.term(), forged);
    }
  }
}

TEST(Leadership, DoesNotWaitForALeaderOfItsOwnShare) {
  Leadership own(kLimits, 0, 0ms, kFirst);
  for (auto now = 0ms; now < 200ms; now += 25ms) {
    own.observe_leader(8, now);
    EXPECT_FALSE(own.decide(now, now));
  }
  EXPECT_TRUE(own.decide(200ms, 200ms));
  EXPECT_EQ(own.term(), 10U);
}

}  // namespace
}  // namespace hecaton::services
