#include "services/arm_driver/command_gate.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

msg::ArmCommand command(std::uint64_t term, std::uint64_t sequence, const std::vector<double>& q = {1.0, 2.0}) {
  msg::ArmCommand message;
  message.node("planner/arm1");
  message.term(term);
  message.sequence_number(sequence);
  message.period(0.01);
  message.q(q);
  message.qd({0.1, 0.2});
  return message;
}

TEST(CommandGate, NewestByTermThenSequence) {
  CommandGate gate(2);
  EXPECT_EQ(gate.judge(command(1, 5)), Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(1, 5)), Verdict::kRepeated);
  EXPECT_EQ(gate.judge(command(1, 4)), Verdict::kRepeated);
  EXPECT_EQ(gate.judge(command(1, 6)), Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(2, 1)), Verdict::kAccepted) << "a new term counts anew";
  EXPECT_EQ(gate.judge(command(1, 7)), Verdict::kStaleTerm);
  EXPECT_EQ(gate.stale_rejected(), 1U);
  EXPECT_EQ(gate.term(), 2U);
  EXPECT_EQ(gate.sequence(), 1U);
}

TEST(CommandGate, ATermSeenElsewhereOutdatesCommands) {
  CommandGate gate(2);
  ASSERT_EQ(gate.judge(command(3, 1)), Verdict::kAccepted);
  gate.saw({{}, 4});
  EXPECT_EQ(gate.judge(command(3, 2)), Verdict::kStaleTerm);
  EXPECT_EQ(gate.complaint(), "commands of planner/arm1 carry term 3, which is older than 4");
  EXPECT_EQ(gate.term(), 3U) << "that of the last accepted command";
  EXPECT_EQ(gate.judge(command(4, 1)), Verdict::kAccepted);
  EXPECT_EQ(gate.complaint(), "");
}

TEST(CommandGate, ATermIsThatOfOnePlanner) {
  CommandGate gate(2);
  ASSERT_EQ(gate.judge(command(3, 1)), Verdict::kAccepted);
  msg::ArmCommand other = command(3, 2);
  other.node("planner/arm1@beta");
  EXPECT_EQ(gate.judge(other), Verdict::kStaleTerm) << "who commanded first has it";
  EXPECT_EQ(gate.complaint(), "commands of planner/arm1@beta carry term 3, which is that of planner/arm1");
  gate.saw({"planner/arm1@beta", 3});
  EXPECT_EQ(gate.judge(command(3, 3)), Verdict::kAccepted) << "nor can a grant take it away";
  gate.saw({"planner/arm1@beta", 4});
  EXPECT_EQ(gate.judge(command(4, 1)), Verdict::kStaleTerm) << "it was granted to another";
  other.term(4);
  EXPECT_EQ(gate.judge(other), Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(3, 4)), Verdict::kStaleTerm);
  EXPECT_EQ(gate.stale_rejected(), 3U);
  EXPECT_EQ(gate.mandate(), (ArmLease{"planner/arm1@beta", 4}));
}

TEST(CommandGate, UnusableOnesChangeNothing) {
  CommandGate gate(2);
  ASSERT_EQ(gate.judge(command(1, 1, {0.5, 0.6})), Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(9, 2, {1.0})), Verdict::kUnusable);
  EXPECT_EQ(gate.judge(command(9, 2, {1.0, NAN})), Verdict::kUnusable);
  EXPECT_EQ(gate.judge(command(9, 2, {1.0, INFINITY})), Verdict::kUnusable);
  msg::ArmCommand bad = command(9, 2);
  bad.qd({0.0, NAN});
  EXPECT_EQ(gate.judge(bad), Verdict::kUnusable);
  for (const double period : {0.0, -0.01, std::nan(""), static_cast<double>(INFINITY)}) {
    bad = command(9, 2);
    bad.period(period);
    EXPECT_EQ(gate.judge(bad), Verdict::kUnusable) << period;
  }
  EXPECT_EQ(gate.unusable(), 8U);
  EXPECT_EQ(gate.mandate().term, 1U) << "a broken sender must not fence off a sound one";
  EXPECT_EQ(gate.q()[0], 0.5);
  EXPECT_EQ(gate.judge(command(1, 2)), Verdict::kAccepted);
}

}  // namespace
}  // namespace hecaton::services
