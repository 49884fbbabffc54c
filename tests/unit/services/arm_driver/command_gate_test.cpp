#include "services/arm_driver/command_gate.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "services/arm_driver/known_planners.hpp"

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

CommandOrigin from(std::uint8_t participant, std::chrono::milliseconds at) {
  CommandOrigin origin;
  origin.writer.bytes[0] = participant;
  origin.at = bus::Clock::time_point(at);
  return origin;
}

TEST(CommandGate, FollowsOneParticipantUnderATerm) {
  using namespace std::chrono_literals;
  CommandGate gate(2, {0.05, 50ms});
  ASSERT_EQ(gate.judge(command(1, 1), from(1, 0ms)).verdict, Verdict::kAccepted);
  const Judgement second = gate.judge(command(1, 2), from(2, 10ms));
  EXPECT_EQ(second.verdict, Verdict::kSecondWriter);
  EXPECT_EQ(second.cause.text(), "two participants command the arm as planner/arm1 under term 1");
  EXPECT_EQ(gate.judge(command(1, 2), from(1, 20ms)).verdict, Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(1, 3), from(2, 71ms)).verdict, Verdict::kAccepted) << "the planner was restarted";
  EXPECT_EQ(gate.judge(command(1, 4), from(1, 80ms)).verdict, Verdict::kSecondWriter);
  CommandOrigin standby = from(3, 81ms);
  standby.named = true;
  EXPECT_EQ(gate.judge(command(2, 1), standby).verdict, Verdict::kAccepted) << "a new lease";
  EXPECT_EQ(gate.stale_rejected(), 0U);
}

// While the supervisor is silent, an intruder would only have to take a greater term.
TEST(CommandGate, TakesANewTermOfAKnownPlannerOnlyWithoutTheSupervisor) {
  using namespace std::chrono_literals;
  CommandGate gate(2, {0.05, 50ms});
  EXPECT_EQ(gate.judge(command(3, 1), from(1, 0ms)).verdict, Verdict::kAccepted) << "nothing is known yet";
  const Judgement refused = gate.judge(command(4, 1), from(2, 10ms));
  EXPECT_EQ(refused.verdict, Verdict::kNotGranted);
  EXPECT_EQ(refused.cause.text(),
            "commands of planner/arm1 have term 4, the supervisor is silent, and their sender is not known as this "
            "planner");
  EXPECT_EQ(gate.judge(command(9, 1), from(2, 10s)).verdict, Verdict::kNotGranted) << "nor later";
  EXPECT_EQ(gate.lease().term, 3U) << "it proves nothing";
  EXPECT_EQ(gate.judge(command(4, 1), from(1, 20ms)).verdict, Verdict::kAccepted) << "the arm has followed it";
  gate.observe_lease({{}, 6});
  EXPECT_EQ(gate.judge(command(7, 1), from(2, 30ms)).verdict, Verdict::kNotGranted);
  CommandOrigin standby = from(2, 40ms);
  standby.named = true;
  EXPECT_EQ(gate.judge(command(7, 1), standby).verdict, Verdict::kAccepted) << "the only one with a planner's name";
  gate.observe_lease({{}, 8});
  EXPECT_EQ(gate.judge(command(8, 1), from(5, 10s)).verdict, Verdict::kAccepted) << "a cell mode has named the term";
}

// The supervisor has begun a new term, which its cell mode tells to all at once.
TEST(CommandGate, LeavesANewTermToTheParticipantThatTheArmFollows) {
  using namespace std::chrono_literals;
  CommandGate gate(2, {0.05, 50ms});
  gate.observe_lease({{}, 1});
  gate.set_granted(1);
  ASSERT_EQ(gate.judge(command(1, 1), from(1, 0ms)).verdict, Verdict::kAccepted);
  gate.observe_lease({{}, 2});
  gate.set_granted(2);
  EXPECT_EQ(gate.judge(command(2, 1), from(2, 10ms)).verdict, Verdict::kSecondWriter) << "an intruder was faster";
  EXPECT_EQ(gate.judge(command(2, 1), from(1, 20ms)).verdict, Verdict::kAccepted);
  gate.observe_lease({{}, 3});
  gate.set_granted(3);
  EXPECT_EQ(gate.judge(command(3, 1), from(2, 71ms)).verdict, Verdict::kAccepted) << "the planner was restarted";
  gate.observe_lease({"planner/arm1", 4});
  gate.set_granted(4);
  EXPECT_EQ(gate.judge(command(4, 1), from(3, 72ms)).verdict, Verdict::kAccepted) << "the lease names it";
}

bus::Event discovery(bus::EventKind kind, const std::string& name, std::uint8_t participant) {
  bus::Event event;
  event.kind = kind;
  event.key = name;
  event.peer.bytes[0] = participant;
  return event;
}

TEST(KnownPlanners, KnowTheOnlyParticipantOfAName) {
  using enum bus::EventKind;
  KnownPlanners planners({"planner/arm1", "planner/arm1@beta"});
  const auto is_only = [&](std::uint8_t participant, const std::string& node) {
    CommandOrigin origin = from(participant, std::chrono::milliseconds(0));
    origin.writer.bytes[15] = 9;  // an endpoint of it
    return planners.is_only(origin.writer, node);
  };
  EXPECT_FALSE(is_only(1, "planner/arm1"));
  planners.note(discovery(kParticipantFound, "planner/arm1", 1));
  planners.note(discovery(kParticipantFound, "planner/arm1", 1));
  planners.note(discovery(kParticipantFound, "planner/arm1@beta", 2));
  planners.note(discovery(kParticipantFound, "intruder", 3));
  planners.note(discovery(kPeerLost, "planner/arm1", 1));
  EXPECT_TRUE(is_only(1, "planner/arm1")) << "it was found again";
  EXPECT_TRUE(is_only(2, "planner/arm1@beta"));
  EXPECT_FALSE(is_only(2, "planner/arm1"));
  EXPECT_FALSE(is_only(3, "intruder"));
  planners.note(discovery(kParticipantFound, "planner/arm1", 4));
  EXPECT_FALSE(is_only(1, "planner/arm1")) << "one of two";
  EXPECT_FALSE(is_only(4, "planner/arm1"));
  planners.note(discovery(kParticipantLost, "planner/arm1", 1));
  EXPECT_TRUE(is_only(4, "planner/arm1")) << "a new process";
  for (std::uint8_t i = 10; i < 10 + 2 * KnownPlanners::kMost; ++i) {
    planners.note(discovery(kParticipantFound, "planner/arm1@beta", i));
  }
  EXPECT_FALSE(is_only(4, "planner/arm1")) << "more than it keeps";
}

TEST(CommandGate, RefusesTermsThatWereNotGranted) {
  CommandGate gate(2);
  gate.set_granted(3);
  EXPECT_EQ(gate.judge(command(4, 1)).verdict, Verdict::kNotGranted);
  EXPECT_EQ(gate.lease().term, 0U) << "it proves nothing";
  EXPECT_EQ(gate.judge(command(3, 1)).verdict, Verdict::kAccepted);
  gate.set_granted(std::nullopt);
  EXPECT_EQ(gate.judge(command(4, 1)).verdict, Verdict::kAccepted) << "the supervisor is not heard";
}

TEST(CommandGate, RefusesLeapsOfTheSequence) {
  CommandGate gate(2);
  EXPECT_EQ(gate.judge(command(1, CommandGate::kLargestNumber + 1)).verdict, Verdict::kUnusable);
  ASSERT_EQ(gate.judge(command(1, 5)).verdict, Verdict::kAccepted);
  EXPECT_EQ(gate.judge(command(1, 6 + CommandGate::kLeap)).verdict, Verdict::kUnusable);
  EXPECT_EQ(gate.judge(command(1, 6)).verdict, Verdict::kAccepted);
}

TEST(CommandGate, RefusesAPeriodBeyondTheCommandTimeout) {
  CommandGate gate(2, {.longest_period = 0.05});
  for (const double period : {0.0501, 1e300, 1.7e308}) {
    msg::ArmCommand message = command(1, 1);
    message.period(period);
    EXPECT_EQ(gate.judge(message).verdict, Verdict::kUnusable) << period;
  }
  EXPECT_EQ(gate.judge(command(1, 1)).verdict, Verdict::kAccepted);
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
