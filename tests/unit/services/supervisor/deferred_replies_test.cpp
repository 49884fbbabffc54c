#include <string>

#include <gtest/gtest.h>

#include "services/supervisor/replication/unreplicated.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Replies = std::vector<std::string>;

TEST(DeferredReplies, WaitUntilTheStandbyHasHeardTheOrder) {
  DeferredReplies<std::string> owed;
  owed.owe("hold", 7, 0s);
  owed.owe("stop", 9, 0s);
  EXPECT_EQ(owed.take(6, 1ms), Replies{});
  EXPECT_EQ(owed.take(7, 2ms), Replies{"hold"});
  EXPECT_EQ(owed.take(7, 3ms), Replies{}) << "each is given once";
  EXPECT_EQ(owed.take(12, 4ms), Replies{"stop"});
}

TEST(DeferredReplies, WaitForNobodyWhenNobodyStandsBy) {
  DeferredReplies<std::string> owed;
  owed.owe("hold", 7, 0s);
  EXPECT_EQ(owed.take(std::nullopt, 0s), Replies{"hold"});
}

TEST(DeferredReplies, AreGivenWhenTheStandbyIsDeaf) {
  DeferredReplies<std::string> owed;
  owed.owe("hold", 7, 1s);
  EXPECT_EQ(owed.take(0, 1s + DeferredReplies<std::string>::kPatience - 1ns), Replies{});
  EXPECT_EQ(owed.take(0, 1s + DeferredReplies<std::string>::kPatience), Replies{"hold"});
}

TEST(DeferredReplies, AreNotGivenByWhoNoLongerLeads) {
  DeferredReplies<std::string> owed;
  owed.owe("hold", 7, 0s);
  owed.drop();
  EXPECT_EQ(owed.take(std::nullopt, 1h), Replies{});
}

}  // namespace
}  // namespace hecaton::services
