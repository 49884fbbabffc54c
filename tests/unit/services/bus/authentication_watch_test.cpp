#include "services/bus/authentication_watch.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;
using Peers = std::vector<AuthenticationWatch::Prefix>;
using Names = std::vector<std::string>;

constexpr auto kLimit = AuthenticationWatch::kLimit;
constexpr Clock::time_point kStart{100s};
constexpr AuthenticationWatch::Prefix kSlow{1};
constexpr AuthenticationWatch::Prefix kQuick{2};

TEST(AuthenticationWatch, ReturnsAPeerOnceWhenItsHandshakeTakesTooLong) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  watch.found(kQuick, "quick", kStart);
  watch.found(kSlow, "slow", kStart + 1s);  // announced again: the handshake is the same
  watch.ended(kQuick, true, kStart);
  EXPECT_EQ(watch.take_overdue(kStart + kLimit), Peers{});
  EXPECT_EQ(watch.take_overdue(kStart + kLimit + 1ms), Peers{kSlow});
  EXPECT_EQ(watch.take_overdue(kStart + 1h), Peers{});
}

TEST(AuthenticationWatch, BeginsAnewWithAPeerThatReturns) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  watch.forget(kSlow);
  watch.found(kSlow, "slow", kStart + 10s);
  EXPECT_EQ(watch.take_overdue(kStart + 12s), Peers{});
  EXPECT_EQ(watch.take_overdue(kStart + 14s), Peers{kSlow});
  watch.found(kSlow, "slow", kStart + 15s);
  EXPECT_EQ(watch.take_overdue(kStart + 17s), Peers{});
  EXPECT_EQ(watch.take_overdue(kStart + 19s), Peers{kSlow});
}

TEST(AuthenticationWatch, WaitsWhileOtherHandshakesEnd) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  for (auto now = kStart; now <= kStart + 10s; now += 1s) {
    watch.found(kQuick, "quick", now);
    watch.ended(kQuick, true, now);
    EXPECT_EQ(watch.take_overdue(now), Peers{}) << "the machine is busy with handshakes";
  }
  EXPECT_EQ(watch.take_overdue(kStart + 10s + kLimit + 1ms), Peers{kSlow});
}

TEST(AuthenticationWatch, DoesNotWaitForAnIntruderThatFails) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  for (auto now = kStart; now <= kStart + kLimit; now += 1s) {
    watch.found(kQuick, "intruder", now);
    watch.ended(kQuick, false, now);
  }
  EXPECT_EQ(watch.take_overdue(kStart + kLimit + 1ms), Peers{kSlow});
}

TEST(AuthenticationWatch, WaitsNoLongerThanTheLongestTime) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  const auto end = kStart + AuthenticationWatch::kLongest;
  watch.ended(kQuick, true, end);
  EXPECT_EQ(watch.take_overdue(end), Peers{});
  EXPECT_EQ(watch.take_overdue(end + 1ms), Peers{kSlow});
}

TEST(AuthenticationWatch, NamesAPeerUntilItsFirstEndpointIsMatched) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  watch.found(kQuick, "quick", kStart);
  EXPECT_EQ(watch.joining(kStart + 1h), (Names{"slow", "quick"}));
  watch.ended(kQuick, true, kStart);
  EXPECT_EQ(watch.joining(kStart), (Names{"slow", "quick"}));
  EXPECT_EQ(watch.take_overdue(kStart + 1h), Peers{kSlow}) << "the handshake of the other has ended";
  EXPECT_EQ(watch.joining(kStart), (Names{"slow", "quick"}));
  watch.forget(kQuick);
  EXPECT_EQ(watch.joining(kStart), Names{"slow"});
  watch.ended(kSlow, false, kStart + 1h);
  EXPECT_EQ(watch.joining(kStart + 1h), Names{});
}

TEST(AuthenticationWatch, ForgetsAnAuthorizedPeerWithoutMatchingEndpoints) {
  AuthenticationWatch watch;
  watch.found(kSlow, "slow", kStart);
  watch.ended(kSlow, true, kStart + 2s);
  EXPECT_EQ(watch.joining(kStart + 2s + AuthenticationWatch::kMatching), Names{"slow"});
  EXPECT_EQ(watch.joining(kStart + 2s + AuthenticationWatch::kMatching + 1ms), Names{});
}

}  // namespace
}  // namespace hecaton::bus
