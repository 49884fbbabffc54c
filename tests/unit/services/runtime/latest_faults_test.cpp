#include "services/runtime/latest_faults.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

msg::Fault report(std::uint64_t term, std::uint64_t number, bool cleared) {
  msg::Fault fault;
  fault.id("f1-1");
  fault.term(term);
  fault.sequence_number(number);
  fault.cleared(cleared);
  return fault;
}

TEST(LatestFaults, KeepsTheLaterReportOfOneTerm) {
  LatestFaults faults;
  EXPECT_TRUE(faults.update(report(2, 1, false)));
  EXPECT_TRUE(faults.update(report(2, 2, true)));
  EXPECT_FALSE(faults.update(report(2, 1, false))) << "delivered again to a late joiner";
  EXPECT_TRUE(faults.all().at("f1-1").cleared());
}

TEST(LatestFaults, KeepsTheReportOfTheHigherTerm) {
  LatestFaults faults;
  EXPECT_TRUE(faults.update(report(6, 1, true)));
  EXPECT_FALSE(faults.update(report(2, 9, false)));
  EXPECT_TRUE(faults.all().at("f1-1").cleared());
}

TEST(LatestFaults, ForgetsAWithdrawnFault) {
  LatestFaults faults;
  faults.update(report(6, 1, true));
  faults.erase("f1-1");
  EXPECT_TRUE(faults.all().empty());
}

}  // namespace
}  // namespace hecaton::services
