#include "services/bus/mailbox.hpp"

#include <thread>

#include <gtest/gtest.h>
#include <poll.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

TEST(Mailbox, TimesOutWhenNothingArrives) {
  Mailbox mailbox;
  const auto start = Clock::now();
  EXPECT_FALSE(mailbox.wait(5ms));
  EXPECT_GE(Clock::now() - start, 5ms);
  EXPECT_FALSE(mailbox.wait(0ms));
}

TEST(Mailbox, WakesForANotificationBeforeTheCall) {
  Mailbox mailbox;
  mailbox.notify();
  mailbox.notify();
  EXPECT_TRUE(mailbox.wait(0ms));
  EXPECT_FALSE(mailbox.wait(0ms)) << "both were announced by the first wake-up";
}

TEST(Mailbox, WakesAnotherThread) {
  Mailbox mailbox;
  std::jthread other([&] { mailbox.post({EventKind::kPeerMatched, "topic", "key", {}, Clock::now()}); });
  EXPECT_TRUE(mailbox.wait(20s));
  const auto events = mailbox.take_events();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, EventKind::kPeerMatched);
  EXPECT_EQ(events[0].key, "key");
  EXPECT_TRUE(mailbox.take_events().empty());
}

TEST(Mailbox, DescriptorIsReadableWhenWaitWouldNotBlock) {
  Mailbox mailbox;
  pollfd readable{mailbox.fd(), POLLIN, 0};
  EXPECT_EQ(::poll(&readable, 1, 0), 0);
  mailbox.notify();
  EXPECT_EQ(::poll(&readable, 1, 0), 1);
  EXPECT_TRUE(mailbox.wait(0ms));
  EXPECT_EQ(::poll(&readable, 1, 0), 0);
}

TEST(Mailbox, DropsTheOldestEventsBeyondItsCapacity) {
  Mailbox mailbox;
  for (std::size_t i = 0; i < Mailbox::kCapacity + 3; ++i) {
    mailbox.post({EventKind::kDeadlineMissed, {}, std::to_string(i), {}, Clock::now()});
  }
  const auto events = mailbox.take_events();
  ASSERT_EQ(events.size(), Mailbox::kCapacity);
  EXPECT_EQ(events.front().key, "3");
}

TEST(EndpointId, ComparesParticipantsByTheFirstTwelveBytes) {
  EndpointId a;
  EndpointId b;
  b.bytes[12] = 0xa1;
  EXPECT_TRUE(a.same_participant(b));
  EXPECT_EQ(b.text(), "000000000000000000000000a1000000");
  b.bytes[11] = 1;
  EXPECT_FALSE(a.same_participant(b));
}

}  // namespace
}  // namespace hecaton::bus
