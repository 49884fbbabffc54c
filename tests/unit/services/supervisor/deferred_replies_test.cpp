#include <string>

#include <gtest/gtest.h>

#include "services/supervisor/replication/unreplicated.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Replies = std::vector<std::string>;

TEST(DeferredReplies, WaitUntilTheStandbyHasHeardTheOrder) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 0s);
  deferred.add("stop", 9, 0s);
  EXPECT_EQ(deferred.take(6, 1ms), Replies{});
  EXPECT_EQ(deferred.take(7, 2ms), Replies{"hold"});
  EXPECT_EQ(deferred.take(7, 3ms), Replies{}) << "each is given once";
  EXPECT_EQ(deferred.take(12, 4ms), Replies{"stop"});
}

TEST(DeferredReplies, WaitForNobodyWhenNobodyStandsBy) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 0s);
  EXPECT_EQ(deferred.take(std::nullopt, 0s), Replies{"hold"});
}

TEST(DeferredReplies, AreGivenWhenTheStandbyIsDeaf) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 1s);
  EXPECT_EQ(deferred.take(0, 1s + DeferredReplies<std::string>::kTimeout - 1ns), Replies{});
  EXPECT_EQ(deferred.take(0, 1s + DeferredReplies<std::string>::kTimeout), Replies{"hold"});
}

TEST(DeferredReplies, AreNotGivenByWhoNoLongerLeads) {
  DeferredReplies<std::string> deferred;
  deferred.add("hold", 7, 0s);
  deferred.clear();
  EXPECT_EQ(deferred.take(std::nullopt, 1h), Replies{});
}

}  // namespace
}  // namespace hecaton::services
