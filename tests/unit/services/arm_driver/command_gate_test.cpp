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

TEST(CommandGate, AcceptsTheNewestByTermThenSequence) {
  CommandGate gate(2);
  EXPECT_EQ(gate.judge(command(1, 5)).verdict, Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(1, 5)).verdict, Verdict::kRepeated);
  EXPECT_EQ(gate.judge(command(1, 4)).verdict, Verdict::kRepeated);
  EXPECT_EQ(gate.judge(command(1, 6)).verdict, Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(2, 1)).verdict, Verdict::kAccepted) << "sequence numbers start again in a new term";
  EXPECT_EQ(gate.judge(command(1, 7)).verdict, Verdict::kStaleTerm);
  EXPECT_EQ(gate.stale_rejected(), 1U);
  EXPECT_EQ(gate.term(), 2U);
  EXPECT_EQ(gate.sequence(), 1U);
}

TEST(CommandGate, RefusesCommandsOlderThanAnObservedTerm) {
  CommandGate gate(2);
  ASSERT_EQ(gate.judge(command(3, 1)).verdict, Verdict::kAccepted);
  gate.observe_lease({{}, 4});
  const Judgement stale = gate.judge(command(3, 2));
  EXPECT_EQ(stale.verdict, Verdict::kStaleTerm);
  EXPECT_EQ(stale.cause, make_cause(msg::CauseKind::CAUSE_COMMAND_REFUSED, "planner/arm1",
                                    "commands of planner/arm1 have term 3, older than term 4"));
  EXPECT_EQ(gate.term(), 3U) << "that of the last accepted command";
  const Judgement accepted = gate.judge(command(4, 1));
  EXPECT_EQ(accepted.verdict, Verdict::kAccepted);
  EXPECT_TRUE(is_none(accepted.cause));
}

TEST(CommandGate, GivesATermToOnePlanner) {
  CommandGate gate(2);
  ASSERT_EQ(gate.judge(command(3, 1)).verdict, Verdict::kAccepted);
  msg::ArmCommand other = command(3, 2);
  other.node("planner/arm1@beta");
  const Judgement second = gate.judge(other);
  EXPECT_EQ(second.verdict, Verdict::kStaleTerm) << "the planner that commanded first has it";
  EXPECT_EQ(second.cause.text(), "commands of planner/arm1@beta have term 3, which belongs to planner/arm1");
  gate.observe_lease({"planner/arm1@beta", 3});
  EXPECT_EQ(gate.judge(command(3, 3)).verdict, Verdict::kAccepted) << "an observed lease cannot take it away";
  gate.observe_lease({"planner/arm1@beta", 4});
  EXPECT_EQ(gate.judge(command(4, 1)).verdict, Verdict::kStaleTerm) << "the lease belongs to another planner";
  other.term(4);
  EXPECT_EQ(gate.judge(other).verdict, Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(3, 4)).verdict, Verdict::kStaleTerm);
  EXPECT_EQ(gate.stale_rejected(), 3U);
  EXPECT_EQ(gate.lease(), (ArmLease{"planner/arm1@beta", 4}));
}

TEST(CommandGate, IgnoresUnusableCommands) {
  CommandGate gate(2);
  ASSERT_EQ(gate.judge(command(1, 1, {0.5, 0.6})).verdict, Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(9, 2, {1.0})).verdict, Verdict::kUnusable);
  EXPECT_EQ(gate.judge(command(9, 2, {1.0, NAN})).verdict, Verdict::kUnusable);
  EXPECT_EQ(gate.judge(command(9, 2, {1.0, INFINITY})).verdict, Verdict::kUnusable);
  msg::ArmCommand bad = command(9, 2);
  bad.qd({0.0, NAN});
  EXPECT_EQ(gate.judge(bad).verdict, Verdict::kUnusable);
  for (const double period : {0.0, -0.01, std::nan(""), static_cast<double>(INFINITY)}) {
    bad = command(9, 2);
    bad.period(period);
    EXPECT_EQ(gate.judge(bad).verdict, Verdict::kUnusable) << period;
  }
  EXPECT_EQ(gate.lease().term, 1U) << "a broken planner must not fence off a sound one";
  EXPECT_EQ(gate.set_point().target.q[0], 0.5);
  EXPECT_EQ(gate.judge(command(1, 2)).verdict, Verdict::kAccepted);
}

}  // namespace
}  // namespace hecaton::services
