#include "services/bus/authentication_watch.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;
using Peers = std::vector<AuthenticationWatch::Prefix>;

constexpr Clock::time_point kStart{100s};
constexpr AuthenticationWatch::Prefix kSlow{1};
constexpr AuthenticationWatch::Prefix kQuick{2};

TEST(AuthenticationWatch, ReturnsAPeerOnceWhenItsHandshakeTakesTooLong) {
  AuthenticationWatch watch;
  watch.found(kSlow, kStart);
  watch.found(kQuick, kStart);
  watch.found(kSlow, kStart + 1s);  // announced again: the handshake is the same
  watch.ended(kQuick);
  EXPECT_EQ(watch.take_overdue(kStart + AuthenticationWatch::kLimit), Peers{});
  EXPECT_EQ(watch.take_overdue(kStart + AuthenticationWatch::kLimit + 1ms), Peers{kSlow});
  EXPECT_EQ(watch.take_overdue(kStart + 1h), Peers{});
}

TEST(AuthenticationWatch, BeginsAnewWithAPeerThatReturns) {
  AuthenticationWatch watch;
  watch.found(kSlow, kStart);
  watch.ended(kSlow);
  watch.found(kSlow, kStart + 10s);
  EXPECT_EQ(watch.take_overdue(kStart + 12s), Peers{});
  EXPECT_EQ(watch.take_overdue(kStart + 14s), Peers{kSlow});
}

}  // namespace
}  // namespace hecaton::bus
