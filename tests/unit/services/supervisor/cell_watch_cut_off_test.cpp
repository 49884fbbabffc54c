// A supervisor whose own host is cut off, or not heard by the others.

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/cell_watch_fixture.hpp"

namespace hecaton::services::testing {
namespace {

/// A third host, on which there is the supervisor alone.
class CutOff : public ::testing::Test, protected VirtualCell {
 protected:
  explicit CutOff(const WatchLimits& limits = cell_limits()) : VirtualCell(nodes_of_three_hosts(), limits, "h3") {
    run_for(200ms);
  }

  static std::vector<ExpectedNode> nodes_of_three_hosts() {
    std::vector<ExpectedNode> nodes = cell_nodes();
    nodes.push_back({"agent/h3", msg::NodeKind::NODE_AGENT, {}, "h3"});
    return nodes;
  }
  void fall_silent(const std::string& host) {
    for (const ExpectedNode& node : watch.nodes()) {
      if (node.host == host) hung.insert(node.name);
    }
  }
  void cut_off() {
    fall_silent("h1");
    fall_silent("h2");
  }
  std::vector<std::string> accused() {
    std::vector<std::string> subjects;
    for (const FaultRecord& fault : watch.faults().open()) subjects.push_back(fault.subject);
    return subjects;
  }
  Names held() { return arms_on(watch.mode().decide(), msg::Mode::MODE_HOLD); }
};

// Its own link is more likely to have failed than all of theirs; and they return one after the other.
TEST_F(CutOff, WhoHearsNoOtherHostTellsThatOfItsOwn) {
  cut_off();
  run_for(2s);
  EXPECT_EQ(accused(), Names{"h3"});
  const FaultRecord fault = watch.faults().open().front();
  EXPECT_EQ(fault.kind, msg::CauseKind::CAUSE_HOST_LOST);
  EXPECT_EQ(fault.seen, "host h3: no agent of another host heard there for more than 100 ms");
  EXPECT_EQ(watch.mode().decide().mode(), msg::Mode::MODE_HOLD);
  hung.clear();
  fall_silent("h2");
  run_for(500ms);
  EXPECT_EQ(accused(), Names{});
  EXPECT_EQ(held(), Names{"arm3"});
  hung.insert("driver/arm1");
  run_for(50ms);
  EXPECT_EQ(accused(), Names{}) << "a reunion";
  hung.erase("driver/arm1");
  run_for(1100ms);
  hung.insert("driver/arm1");
  run_for(50ms);
  EXPECT_EQ(accused(), Names{"driver/arm1"}) << "it had returned";
  hung.erase("driver/arm1");
  run_for(4s);
  EXPECT_EQ(accused(), Names{"h2"}) << "it does not return";
}

// Beats are not in phase, and some are later than others. Chaos saw 15 ms between the last of one host and of the
// other.
TEST_F(CutOff, NobodyIsLostWhoFellSilentALittleBeforeTheOthers) {
  std::size_t over = 0;  // faults of ours
  for (const Time before : {Time(10ms), Time(20ms), Time(40ms)}) {
    fall_silent("h2");
    run_for(before);
    cut_off();
    run_for(1s);
    EXPECT_EQ(accused(), Names{"h3"}) << before.count();
    EXPECT_EQ(watch.faults().over().size(), over) << "nobody was accused before";
    hung.clear();
    run_for(10s);
    over = watch.faults().over().size();
  }
}

TEST_F(CutOff, OneBeatNowAndThenIsNoReturn) {
  cut_off();
  run_for(300ms);
  for (int i = 0; i < 5; ++i) {
    hung.erase("agent/h1");
    run_for(10ms);
    hung.insert("agent/h1");
    run_for(i < 4 ? 140ms : 20s);
  }
  EXPECT_EQ(accused(), Names{"h3"});
  EXPECT_TRUE(watch.faults().over().empty()) << "one long fault";
}

TEST_F(CutOff, WhoWasLostBeforeIsNoneOfThem) {
  fall_silent("h2");
  run_for(300ms);
  fall_silent("h1");
  run_for(300ms);
  EXPECT_EQ(accused(), (Names{"h2", "h1"})) << "of two hosts the other is lost";
}

TEST_F(CutOff, AfterItsReturnItsOwnAgentIsJudgedAfresh) {
  cut_off();
  run_for(200ms);
  hung = {"agent/h3"};
  run_for(200ms);
  ASSERT_EQ(accused(), Names{"h3"});
  EXPECT_EQ(watch.faults().open().front().seen, "host h3: nothing heard of it or its nodes for more than 100 ms");
}

TEST_F(CutOff, DriversThatBeatWithoutStatesAreNotBackYet) {
  cut_off();
  run_for(200ms);
  hung.clear();
  mute = {"driver/arm3", "world"};
  run_for(300ms);
  EXPECT_EQ(accused(), Names{});
  EXPECT_EQ(held(), Names{"arm3"});
  EXPECT_EQ(watch.mode().decide().mode(), msg::Mode::MODE_HOLD);
  mute.clear();
  run_for(300ms);
  EXPECT_EQ(watch.mode().decide(), msg::CellMode{});
}

TEST_F(CutOff, WhoStaysAwayIsHeldUntilItIsTold) {
  cut_off();
  run_for(1s);
  hung = {"agent/h2", "driver/arm3"};
  run_for(4s);
  hung = {"driver/arm3"};
  for (const Time end = now + 6s; now < end; turn()) {
    ASSERT_EQ(held(), Names{"arm3"}) << "at " << now.count();
  }
  EXPECT_EQ(accused(), Names{"driver/arm3"});
}

TEST_F(CutOff, WhoHasReturnedIsJudgedLikeAnyOther) {
  cut_off();
  run_for(1s);
  hung.clear();
  run_for(1200ms);
  hung = {"driver/arm3"};
  run_for(50ms);
  hung.clear();
  run_for(300ms);
  EXPECT_EQ(accused(), Names{});
  hung = {"driver/arm3"};
  run_for(50ms);
  EXPECT_EQ(accused(), Names{"driver/arm3"}) << "also when it hangs again before it has been well for long";
}

class LeadsUnheard : public CutOff {
 protected:
  LeadsUnheard() {
    fall_silent("h1");  // whose supervisor led
    run_for(300ms);
    watch.faults().recall({});
  }
  void follow(const std::string& node, std::uint64_t term) { watch.heard(node, {pids[node], now, 0, {term, 1}}); }
};

// Chaos let nothing leave the host of a supervisor that stood by: the others dropped it within a second, each at its
// own time, and the leader's host was the first.
TEST_F(LeadsUnheard, WhoIsLeftAloneByOneAfterTheOtherTellsItsOwnHost) {
  watch.begin_to_lead(7);
  run_for(600ms);
  EXPECT_EQ(accused(), Names{});
  EXPECT_EQ(held(), (Names{"arm1", "arm2"})) << "whose drivers are not heard";
  fall_silent("h2");
  run_for(1s);
  EXPECT_EQ(accused(), Names{"h3"});
  EXPECT_TRUE(watch.faults().over().empty());
  run_for(20s);
  EXPECT_EQ(accused(), Names{"h3"});
  hung.clear();
  follow("planner/arm1", 7);
  run_for(500ms);
  EXPECT_EQ(accused(), Names{});
}

TEST_F(LeadsUnheard, WhatItsPredecessorToldOfItsHostStandsUntilItIsFollowed) {
  FaultHistory told;
  told.open["agent/h3"] = {1,  1, msg::CauseKind::CAUSE_HOST_LOST, msg::Severity::SEVERITY_ERROR, "h3", "silent", 0ms,
                           {}, {}};
  watch.faults().recall(told);
  watch.begin_to_lead(7);
  run_for(500ms);
  EXPECT_EQ(accused(), Names{"h3"});
  follow("planner/arm3", 7);
  run_for(10ms);
  EXPECT_EQ(accused(), Names{"h1"});
}

TEST_F(LeadsUnheard, WhoIsFollowedBlamesTheOthers) {
  watch.begin_to_lead(7);
  follow("planner/arm3", 6);
  run_for(100ms);
  EXPECT_EQ(accused(), Names{}) << "that was who led before";
  follow("planner/arm3", 7);
  run_for(10ms);
  EXPECT_EQ(accused(), Names{"h1"});
}

TEST_F(LeadsUnheard, AndWhoIsNotForLongBlamesThemAllTheSame) {
  watch.begin_to_lead(7);
  run_for(4s);
  EXPECT_EQ(accused(), Names{});
  run_for(2s);
  EXPECT_EQ(accused(), Names{"h1"});
}

// Its processes leave us alone one after the other.
TEST_F(LeadsUnheard, OfTwoHostsTheOtherIsLostAsAWhole) {
  FaultHistory told;
  told.open["agent/h1"] = {1,  1, msg::CauseKind::CAUSE_HOST_LOST, msg::Severity::SEVERITY_ERROR, "h1", "silent", 0ms,
                           {}, {}};
  watch.faults().recall(told);
  watch.begin_to_lead(7);
  hung.insert("planner/arm3");
  run_for(300ms);
  EXPECT_EQ(accused(), Names{"h1"});
  fall_silent("h2");
  run_for(300ms);
  EXPECT_EQ(accused(), (Names{"h2", "h1"}));
}

TEST_F(LeadsUnheard, OfTwoHostsTheOtherIsLost) {
  FaultHistory told;
  told.open["agent/h2"] = {1,  1, msg::CauseKind::CAUSE_HOST_LOST, msg::Severity::SEVERITY_ERROR, "h2", "silent", 0ms,
                           {}, {}};
  fall_silent("h2");
  watch.faults().recall(told);
  watch.begin_to_lead(7);
  run_for(200ms);
  EXPECT_EQ(accused(), (Names{"h1", "h2"}));
}

// Limits of a machine that a whole cell shares.
WatchLimits patient_limits() {
  WatchLimits limits = cell_limits();
  limits.node.silence = limits.arm_stream = limits.world_stream = 250ms;
  limits.node.lost = limits.host_lease = 1s;
  return limits;
}

class CutOffOnASharedMachine : public CutOff {
 protected:
  CutOffOnASharedMachine() : CutOff(patient_limits()) {}
};

// Chaos muted the host of a leader and killed a planner: its successor, who had never lost us, was heard as the only
// one.
TEST_F(CutOffOnASharedMachine, AProcessThatHasJustBegunMayBeHeardAllTheSame) {
  cut_off();
  hung.erase("planner/arm3");
  run_for(2s);
  EXPECT_EQ(accused(), Names{"h3"});
  EXPECT_TRUE(watch.faults().over().empty());
  hung.clear();
  run_for(500ms);
  EXPECT_EQ(accused(), Names{});
  EXPECT_EQ(watch.mode().decide(), msg::CellMode{});
}

/// It leads, is followed, and is muted at some time: it hears the others, who leave it alone after 1.4 s or later.
template <bool kPatient>
class MutedLeader : public CutOff {
 protected:
  explicit MutedLeader() : CutOff(kPatient ? patient_limits() : cell_limits()) {
    watch.begin_to_lead(7);
    lead_for(5s);
  }
  /// Every node of another host has heard what we said in the turn before, unless nobody hears us.
  void lead_for(Time duration) {
    for (const Time end = now + duration; now < end;) {
      turn();
      const HeardMode last{7, published};
      watch.mode_published(++published);
      for (const ExpectedNode& node : watch.nodes()) {
        const bool answers = node.role != msg::NodeKind::NODE_AGENT && running(node.name) && !is_muted;
        if (answers) watch.heard(node.name, {pids[node.name], now, 0, last});
      }
    }
  }
  void expect_nobody_told() {
    EXPECT_EQ(accused(), Names{});
    EXPECT_TRUE(watch.faults().over().empty());
  }

  std::uint64_t published = 0;
  bool is_muted = false;
};
using MutedLeaderInHaste = MutedLeader<false>;
using MutedLeaderWithPatience = MutedLeader<true>;

// Chaos muted the host of a leader, whose standby was dead, for 1.54 s: the agent of one host left it alone just then.
TEST_F(MutedLeaderWithPatience, AnAgentThatLeavesItAloneAsTheMuteEndsIsNotLost) {
  is_muted = true;
  lead_for(1540ms);
  is_muted = false;
  lead_for(50ms);
  hung.insert("agent/h2");
  lead_for(4300ms);
  hung.clear();
  lead_for(10s);
  expect_nobody_told();
  fall_silent("h2");
  lead_for(1100ms);
  EXPECT_EQ(accused(), Names{"h2"}) << "it had returned";
}

TEST_F(MutedLeaderInHaste, WhoIsLeftAloneByOneAfterTheOtherTellsItsOwnHost) {
  is_muted = true;
  lead_for(1400ms);
  hung.insert("agent/h1");
  lead_for(100ms);
  hung.insert("planner/arm3");
  lead_for(100ms);
  fall_silent("h1");
  lead_for(300ms);
  expect_nobody_told();
  EXPECT_EQ(held(), (Names{"arm1", "arm2", "arm3"})) << "who is not heard may hear us";
  fall_silent("h2");
  lead_for(300ms);
  EXPECT_EQ(accused(), Names{"h3"});
  lead_for(20s);
  EXPECT_EQ(accused(), Names{"h3"});
  hung.clear();
  is_muted = false;
  lead_for(500ms);
  EXPECT_EQ(accused(), Names{});
  EXPECT_EQ(watch.mode().decide(), msg::CellMode{});
}

TEST_F(MutedLeaderInHaste, WhoIsStillLostAfterAllHaveHeardItAgainIsTold) {
  is_muted = true;
  lead_for(1500ms);
  fall_silent("h2");
  lead_for(100ms);
  is_muted = false;
  lead_for(5900ms - 1s);
  expect_nobody_told();
  lead_for(2s);
  EXPECT_EQ(accused(), Names{"h2"});
}

TEST_F(MutedLeaderInHaste, OfTwoHostsOfWhichOneIsLostTheOtherIsLost) {
  fall_silent("h2");
  lead_for(10s);
  ASSERT_EQ(accused(), Names{"h2"});
  fall_silent("h1");
  is_muted = true;
  lead_for(1s);
  EXPECT_EQ(accused(), (Names{"h2", "h1"})) << "one of them leaves nobody alone in its own time";
}

TEST_F(MutedLeaderInHaste, AnswersThatAreLateForAMomentExcuseNobody) {
  is_muted = true;
  lead_for(400ms);
  is_muted = false;
  hung.insert("driver/arm3");
  lead_for(50ms);
  EXPECT_EQ(accused(), Names{"driver/arm3"});
}

// Nothing but what they say of us tells a muted host from one of which all processes have ended but its agent.
TEST_F(MutedLeaderInHaste, DeathsAreToldWhoeverHearsUs) {
  for (const ExpectedNode& node : watch.nodes()) {
    if (node.role != msg::NodeKind::NODE_AGENT && node.host != "h3") kill(node.name, 9);
  }
  lead_for(1s);
  EXPECT_EQ(accused().size(), 7U);
  EXPECT_EQ(watch.faults().open().front().kind, msg::CauseKind::CAUSE_PROCESS_DIED);
}

class CutOffThatWaits : public CutOff {
 protected:
  static WatchLimits limits() {
    WatchLimits limits = cell_limits();
    limits.waits_for_resume.insert(msg::CauseKind::CAUSE_HOST_LOST);
    return limits;
  }
  CutOffThatWaits() : CutOff(limits()) {}
};

TEST_F(CutOffThatWaits, ArmsThatItDidNotHearWaitForResume) {
  cut_off();
  run_for(200ms);
  hung.clear();
  run_for(500ms);
  EXPECT_EQ(accused(), Names{});
  EXPECT_NE(watch.mode().decide(), msg::CellMode{});
}

}  // namespace
}  // namespace hecaton::services::testing
