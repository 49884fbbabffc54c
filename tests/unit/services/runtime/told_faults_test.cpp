#include "services/runtime/told_faults.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

msg::Fault fault(std::uint64_t term, std::uint64_t number, bool cleared) {
  msg::Fault told;
  told.id("f1-1");
  told.term(term);
  told.sequence_number(number);
  told.cleared(cleared);
  return told;
}

TEST(ToldFaults, ALaterWordCounts) {
  ToldFaults told;
  EXPECT_TRUE(told.hear(fault(2, 1, false)));
  EXPECT_TRUE(told.hear(fault(2, 2, true)));
  EXPECT_FALSE(told.hear(fault(2, 1, false))) << "and comes once more to whoever joins";
  EXPECT_TRUE(told.all().at("f1-1").cleared());
}

TEST(ToldFaults, TheWordOfWhoLeadsCountsAgainstAnEarlierLeaders) {
  ToldFaults told;
  EXPECT_TRUE(told.hear(fault(6, 1, true)));
  EXPECT_FALSE(told.hear(fault(2, 9, false)));
  EXPECT_TRUE(told.all().at("f1-1").cleared());
}

TEST(ToldFaults, WhatWasWithdrawnIsForgotten) {
  ToldFaults told;
  told.hear(fault(6, 1, true));
  told.forget("f1-1");
  EXPECT_TRUE(told.all().empty());
}

}  // namespace
}  // namespace hecaton::services
