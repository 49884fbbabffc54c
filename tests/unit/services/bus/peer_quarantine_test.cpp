#include "services/bus/peer_quarantine.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kBeginning{1h};
constexpr PeerQuarantine::Prefix kPeer{1};
constexpr PeerQuarantine::Prefix kOther{2};
constexpr PeerQuarantine::Address kPeerAddress = 11;
constexpr PeerQuarantine::Address kOtherAddress = 22;

/// Of two peers found at kBeginning only kOther goes on sending.
struct Silence {
  PeerQuarantine quarantine{2s};
  Clock::time_point now = kBeginning;

  Silence() {
    quarantine.found(kPeer, {kPeerAddress}, 2s, now);
    quarantine.found(kOther, {kOtherAddress}, 2s, now);
    quarantine.endpoint_found(kOther);
  }
  void last(Clock::duration duration) {
    for (const auto end = now + duration; now < end;) {
      now += 50ms;
      EXPECT_TRUE(quarantine.accepts(kOther, now));
      quarantine.update(now, kBeginning);
    }
  }
};

TEST(PeerQuarantine, AcceptsPeersThatSend) {
  Silence silence;
  silence.last(1600ms);
  EXPECT_FALSE(silence.quarantine.any_quarantined());
  EXPECT_TRUE(silence.quarantine.accepts(kPeer, silence.now));
  EXPECT_TRUE(silence.quarantine.accepts({3}, silence.now)) << "an unknown peer";
  silence.last(1600ms);
  EXPECT_FALSE(silence.quarantine.is_quarantined(kPeerAddress));
}

TEST(PeerQuarantine, SparesASilentPeerWithALongerLease) {
  Silence silence;
  silence.quarantine.found(kPeer, {kPeerAddress}, 10s, silence.now);
  silence.last(9s);
  EXPECT_FALSE(silence.quarantine.any_quarantined());
  silence.quarantine.dropped(kPeer, silence.now);
  EXPECT_TRUE(silence.quarantine.is_quarantined(kPeerAddress)) << "Fast DDS has dropped it";
}

TEST(PeerQuarantine, NeverReceivesARevokedPeerAgain) {
  Silence silence;
  silence.last(1s);
  EXPECT_FALSE(silence.quarantine.is_revoked(kPeer));
  silence.quarantine.revoke({{1, 0, 0, 0, 0, 0}}, silence.now);
  EXPECT_TRUE(silence.quarantine.is_revoked(kPeer));
  EXPECT_TRUE(silence.quarantine.is_revoked({1, 0, 0, 0, 0, 0, 7, 8})) << "another participant of the identity";
  EXPECT_FALSE(silence.quarantine.is_revoked(kOther));
  EXPECT_TRUE(silence.quarantine.is_quarantined(kPeerAddress)) << "nothing is sent to it at once";
  EXPECT_FALSE(silence.quarantine.is_quarantined(kOtherAddress));
  silence.quarantine.revoke({{1, 0, 0, 0, 0, 0}}, silence.now);
  silence.last(3s);
  EXPECT_FALSE(silence.quarantine.any_quarantined()) << "Fast DDS has dropped it meanwhile";
  EXPECT_TRUE(silence.quarantine.is_revoked(kPeer));
}

TEST(PeerQuarantine, LastsLongerThanTheLeaseAfterSilenceForMostOfIt) {
  Silence silence;
  silence.last(1650ms);
  EXPECT_TRUE(silence.quarantine.is_quarantined(kPeerAddress));
  EXPECT_FALSE(silence.quarantine.is_quarantined(kOtherAddress));
  EXPECT_FALSE(silence.quarantine.accepts(kPeer, silence.now)) << "the link is back, but the peer may drop this side";
  silence.quarantine.dropped(kPeer, silence.now + 400ms);  // the lease on this side
  silence.last(2450ms);
  EXPECT_TRUE(silence.quarantine.is_quarantined(kPeerAddress));
  silence.last(100ms);
  EXPECT_FALSE(silence.quarantine.any_quarantined());
  EXPECT_TRUE(silence.quarantine.accepts(kPeer, silence.now));
}

TEST(PeerQuarantine, WatchesAPeerThatIsFoundBeforeTheUpdateAfterItsQuarantine) {
  Silence silence;
  silence.last(1650ms);
  silence.last(2450ms);
  ASSERT_TRUE(silence.quarantine.is_quarantined(kPeerAddress));
  silence.now += 60ms;  // the quarantine is over
  ASSERT_TRUE(silence.quarantine.accepts(kPeer, silence.now));
  silence.quarantine.found(kPeer, {kPeerAddress}, 2s, silence.now);
  EXPECT_FALSE(silence.quarantine.is_quarantined(kPeerAddress)) << "it is answered at once";
  silence.last(1600ms);
  EXPECT_FALSE(silence.quarantine.any_quarantined());
  silence.last(100ms);
  EXPECT_TRUE(silence.quarantine.is_quarantined(kPeerAddress));
}

/// Both peers go on sending.
void talk(PeerQuarantine& quarantine, Clock::time_point& now, Clock::duration duration) {
  for (const auto end = now + duration; now < end;) {
    now += 50ms;
    static_cast<void>(quarantine.accepts(kPeer, now));
    static_cast<void>(quarantine.accepts(kOther, now));
    quarantine.update(now, kBeginning);
  }
}

TEST(PeerQuarantine, BeginsWhenTheEndpointsOfAPeerAreMissingAndEachTimeLater) {
  PeerQuarantine quarantine(2s);
  auto now = kBeginning;
  quarantine.found(kOther, {kOtherAddress}, 2s, now);
  quarantine.endpoint_found(kOther);
  for (const auto limit : {6s, 12s, 24s}) {
    quarantine.found(kPeer, {kPeerAddress}, 2s, now);
    talk(quarantine, now, limit);
    EXPECT_FALSE(quarantine.any_quarantined());
    talk(quarantine, now, 100ms);
    EXPECT_TRUE(quarantine.is_quarantined(kPeerAddress)) << "the peer has not dropped this participant";
    EXPECT_FALSE(quarantine.is_quarantined(kOtherAddress));
    quarantine.dropped(kPeer, now + 2s);
    talk(quarantine, now, 2500ms);
    EXPECT_FALSE(quarantine.any_quarantined());
  }
  quarantine.found(kPeer, {kPeerAddress}, 2s, now);
  quarantine.endpoint_found(kPeer);
  talk(quarantine, now, 100s);
  EXPECT_FALSE(quarantine.any_quarantined());
  quarantine.found(kPeer, {kPeerAddress}, 2s, now);
  talk(quarantine, now, 6100ms);
  EXPECT_TRUE(quarantine.is_quarantined(kPeerAddress)) << "as for the first time";
}

TEST(PeerQuarantine, SparesOtherProgramsWithoutEndpoints) {
  PeerQuarantine quarantine(2s);
  auto now = kBeginning;
  quarantine.found(kPeer, {kPeerAddress}, 10s, now);
  talk(quarantine, now, 100s);
  EXPECT_FALSE(quarantine.any_quarantined());
}

TEST(PeerQuarantine, IgnoresSilenceWhileThisProcessDidNotReceive) {
  PeerQuarantine quarantine{2s};
  quarantine.found(kPeer, {kPeerAddress}, 2s, kBeginning);
  quarantine.update(kBeginning + 3s, kBeginning + 3s);
  EXPECT_FALSE(quarantine.any_quarantined());
  quarantine.update(kBeginning + 4700ms, kBeginning + 3s);
  EXPECT_TRUE(quarantine.is_quarantined(kPeerAddress));
}

TEST(PeerQuarantine, EndsWhenASuccessorAppearsAtTheSameAddress) {
  Silence silence;
  silence.last(1650ms);
  ASSERT_TRUE(silence.quarantine.is_quarantined(kPeerAddress));
  silence.quarantine.found({3}, {kPeerAddress}, 2s, silence.now);
  EXPECT_FALSE(silence.quarantine.is_quarantined(kPeerAddress));
}

TEST(PeerQuarantine, SparesAPeerWhoseAddressAnotherAnnounces) {
  Silence silence;
  silence.quarantine.found({3}, {kOtherAddress}, 2s, silence.now);
  silence.last(1650ms);
  EXPECT_FALSE(silence.quarantine.accepts({3}, silence.now)) << "it is silent";
  EXPECT_TRUE(silence.quarantine.accepts(kOther, silence.now));
  EXPECT_FALSE(silence.quarantine.is_quarantined(kOtherAddress));
}

// This process did not receive for a while, so the peer's silence did not count; but Fast DDS has counted it.
TEST(PeerQuarantine, BeginsWhenFastDdsDropsThePeer) {
  PeerQuarantine quarantine{2s};
  quarantine.found(kPeer, {kPeerAddress}, 2s, kBeginning);
  quarantine.update(kBeginning + 2s, kBeginning + 1s);
  ASSERT_FALSE(quarantine.any_quarantined());
  quarantine.dropped(kPeer, kBeginning + 2s);
  EXPECT_TRUE(quarantine.is_quarantined(kPeerAddress));
  EXPECT_FALSE(quarantine.accepts(kPeer, kBeginning + 2001ms))
      << "it may still know this side, which would be one-sided";
  quarantine.update(kBeginning + 4499ms, kBeginning + 1s);
  EXPECT_TRUE(quarantine.is_quarantined(kPeerAddress));
  quarantine.update(kBeginning + 4500ms, kBeginning + 1s);
  EXPECT_FALSE(quarantine.any_quarantined());
  EXPECT_TRUE(quarantine.accepts(kPeer, kBeginning + 4501ms));
}

TEST(PeerQuarantine, ForgetsAPeerThatLeft) {
  Silence silence;
  silence.quarantine.left(kPeer, silence.now);
  silence.last(5s);
  EXPECT_FALSE(silence.quarantine.any_quarantined());
}

}  // namespace
}  // namespace hecaton::bus
