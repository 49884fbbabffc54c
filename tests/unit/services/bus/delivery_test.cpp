// Delivery of samples: many keys, late joiners, withdrawn keys, depth 1.
#include <algorithm>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/planner.h>
#include <idl/supervisor.h>
#include <idl/world.h>

#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

class Delivery : public BusTest {};

msg::ArmState arm_state(const std::string& arm, std::uint64_t number) {
  msg::ArmState state;
  state.arm(arm);
  state.sequence_number(number);
  state.q({0.1, 0.2, static_cast<double>(number)});
  return state;
}

msg::ProcessEvent process_event(const std::string& process) {
  msg::ProcessEvent event;
  event.process(process);
  return event;
}

/// Memory of this process that it may write to: what RLIMIT_DATA bounds [kB].
std::uint64_t writable_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kilobytes = 0;
    if (word == "VmData:" && status >> kilobytes) return kilobytes;
  }
  return 0;
}

// The largest tick has 43 MB, and writer and reader keep 64 ticks each.
TEST_F(Delivery, TakesTheMemoryThatSamplesNeed) {
  Participant planner(domain_.number(), "planner/north", one_host());
  const std::uint64_t before = writable_memory();
  ASSERT_GT(before, 0U);
  Writer<msg::PlannerTick> writer(planner);
  Reader<msg::PlannerTick> reader(there_);
  expect_matched(writer, reader);
  msg::PlannerTick tick;
  tick.arm("north");
  for (std::uint64_t number = 1; number <= 200; ++number) {
    tick.sequence_number(number);
    ASSERT_TRUE(writer.write(tick));
    ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received == number; }));
  }
  EXPECT_LT(writable_memory() - before, 100'000U);
}

// By default Fast DDS has room for 10 keys and silently drops the eleventh.
TEST_F(Delivery, ReceivesThirtyArmsOfOneWriter) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  constexpr int kArms = 30;
  // Best-effort: a sample lost in a full socket buffer comes with the next round, as in a cell.
  std::uint64_t round = 0;
  const auto until = Clock::now() + kPatience;
  while (reader.latest().size() < kArms && Clock::now() < until) {
    ++round;
    for (int arm = 0; arm < kArms; ++arm) {
      ASSERT_TRUE(writer.write(arm_state("arm" + std::to_string(arm), round)));
    }
    [[maybe_unused]] const bool arrived = reader.wait_for_data(5ms);
  }
  EXPECT_EQ(reader.latest().size(), kArms);
}

TEST_F(Delivery, ReceivesCommandsForThirtyArmsOfOneWriter) {
  Writer<msg::ArmCommand> writer(here_);
  Reader<msg::ArmCommand> reader(there_);
  expect_matched(writer, reader);
  for (int arm = 0; arm < 30; ++arm) {
    msg::ArmCommand command;
    command.arm("arm" + std::to_string(arm));
    ASSERT_TRUE(writer.write(command));
  }
  EXPECT_TRUE(wait_until(reader, [&] { return reader.latest().size() == 30; }));
}

TEST_F(Delivery, SendsACommandOnlyToTheReadersOfItsArm) {
  Reader<msg::ArmCommand> own(there_, nullptr, {.keys = {"north"}});
  Reader<msg::ArmCommand> other(there_, nullptr, {.keys = {"south"}});
  Reader<msg::ArmCommand> all(there_);
  Writer<msg::ArmCommand> south(here_, {.key = "south"});
  Writer<msg::ArmCommand> writer(here_, {.key = "north"});
  ASSERT_TRUE(writer.wait_matched(2, kPatience));
  ASSERT_TRUE(own.wait_matched(1, kPatience));
  ASSERT_TRUE(all.wait_matched(2, kPatience));
  ASSERT_TRUE(other.wait_matched(1, kPatience));  // the writer of its own arm
  EXPECT_EQ(other.matched(), 1);
  EXPECT_EQ(writer.matched(), 2);
  msg::ArmCommand command;
  command.arm("north");
  ASSERT_TRUE(writer.write(command));
  EXPECT_TRUE(wait_until(own, [&] { return own.latest("north") != nullptr; }));
  EXPECT_TRUE(wait_until(all, [&] { return all.latest("north") != nullptr; }));
  EXPECT_TRUE(other.take().empty());
}

TEST_F(Delivery, TakesTogetherWhatArrivesWhileAWatchingParticipantSleeps) {
  auto options = one_host();
  options.reception_pause = 60ms;
  Participant watching(domain_.number(), "watching", options);
  Writer<msg::ArmCommand> writer(here_);
  Reader<msg::ArmCommand> reader(watching);
  expect_matched(writer, reader);
  const auto command_for = [](const std::string& arm) {
    msg::ArmCommand command;
    command.arm(arm);
    return command;
  };
  // After a command for which it has waited it sleeps, so that some of these are late, each second one on a quiet
  // machine.
  std::vector<Clock::time_point> received;
  for (int i = 0; i < 10; ++i) {
    const std::string arm = "one" + std::to_string(i);
    ASSERT_TRUE(writer.write(command_for(arm)));
    ASSERT_TRUE(wait_until(reader, [&] { return reader.latest(arm) != nullptr; }));
    received.push_back(reader.latest(arm)->received);
  }
  EXPECT_GE(received.back() - received.front(), 2 * options.reception_pause);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(writer.write(command_for("all" + std::to_string(i))));
  EXPECT_TRUE(wait_until(reader, [&] { return reader.latest().size() == 110; })) << reader.latest().size();
}

TEST_F(Delivery, RefusesAKeyBeyondTheTopicsLimit) {
  Writer<msg::ProcessEvent> writer(here_);
  const int room = Topic<msg::ProcessEvent>::kInfo.qos.instances;
  for (int i = 0; i < room; ++i) ASSERT_TRUE(writer.write(process_event("host/p" + std::to_string(i))));
  const auto refused = writer.write(process_event("host/last"));
  EXPECT_FALSE(refused);
  EXPECT_EQ(
      refused.reason,
      "hecaton/ProcessEvent \"host/last\" not written: no room within 10 ms: the topic allows 512 keys at a time");
  // A withdrawn key makes room.
  ASSERT_TRUE(writer.retire(process_event("host/p0")));
  EXPECT_TRUE(writer.write(process_event("host/last")));
}

TEST_F(Delivery, RefusesEmptyAndOverlongKeys) {
  Writer<msg::ArmState> writer(here_);
  EXPECT_FALSE(writer.write(arm_state("", 1)));
  EXPECT_FALSE(writer.write(arm_state(std::string(300, 'x'), 1)));
  EXPECT_TRUE(writer.write(arm_state(std::string(200, 'x'), 1)));
  Writer<msg::CellMode> mode(here_);
  EXPECT_FALSE(mode.retire({})) << "a topic without key has nothing to withdraw";
}

TEST_F(Delivery, GivesALateJoinerAllObstacles) {
  Writer<msg::ObstacleShapes> writer(here_);
  constexpr int kObstacles = 100;
  for (int i = 0; i < kObstacles; ++i) {
    msg::ObstacleShapes shapes;
    shapes.name("obstacle" + std::to_string(i));
    shapes.obstacle().name(shapes.name());
    msg::PlacedShape hull;  // 3,000 vertices of 24 bytes: more than one datagram holds
    hull.kind(msg::ShapeKind::SHAPE_CONVEX);
    hull.vertices().resize(i == 0 ? 3000 : 8);
    shapes.obstacle().shapes().push_back(hull);
    ASSERT_TRUE(writer.write(shapes));
  }
  Reader<msg::ObstacleShapes> late(there_);
  ASSERT_TRUE(wait_until(late, [&] { return late.latest().size() == kObstacles; }));
  EXPECT_EQ(late.latest("obstacle0")->value.obstacle().shapes()[0].vertices().size(), 3000U);
}

TEST_F(Delivery, DisposesARemovedObstacleAndHidesItFromLateJoiners) {
  Writer<msg::ObstacleShapes> writer(here_);
  Reader<msg::ObstacleShapes> reader(there_);
  msg::ObstacleShapes pallet;
  pallet.name("pallet");
  msg::ObstacleShapes post;
  post.name("post");
  ASSERT_TRUE(writer.write(pallet));
  ASSERT_TRUE(writer.write(post));
  ASSERT_TRUE(wait_until(reader, [&] { return reader.latest().size() == 2; }));
  ASSERT_TRUE(writer.retire(pallet));
  bool disposed = false;
  ASSERT_TRUE(wait_until(reader, [&] {
    for (const auto& sample : reader.take()) disposed = disposed || (sample.disposed && sample.key == "pallet");
    return disposed;
  }));
  EXPECT_EQ(reader.latest("pallet"), nullptr);
  EXPECT_NE(reader.latest("post"), nullptr);

  Reader<msg::ObstacleShapes> late(there_);
  ASSERT_TRUE(wait_until(late, [&] { return late.latest("post") != nullptr; }));
  EXPECT_EQ(late.latest("pallet"), nullptr);

  // The name may come back.
  ASSERT_TRUE(writer.write(pallet));
  EXPECT_TRUE(wait_until(reader, [&] { return reader.latest("pallet") != nullptr; }));
}

// A cell that runs for weeks gets millions of goals: the writer keeps the newest alive and withdraws the rest.
TEST_F(Delivery, RetiresGoalsBeyondTheRetainedOnes) {
  Writer<msg::Goal> writer(here_);
  Reader<msg::Goal> reader(there_);
  expect_matched(writer, reader);
  constexpr int kGoals = 6000;    // more than the topic has room for
  constexpr int kASecond = 2000;  // readers admit 5000 samples of a writer, and each goal is written and withdrawn
  const int retained = Topic<msg::Goal>::kInfo.qos.retained;
  std::uint64_t received = 0;
  std::uint64_t disposed = 0;
  const auto collect = [&] {
    for (const auto& sample : reader.take()) ++(sample.disposed ? disposed : received);
  };
  for (int i = 0; i < kGoals; ++i) {
    if (i > 0 && i % kASecond == 0) std::this_thread::sleep_for(1100ms);  // all before it are acknowledged
    msg::Goal goal;
    goal.arm("arm1");
    goal.goal(std::to_string(i));
    const auto result = writer.write(goal);
    ASSERT_TRUE(result) << i << ": " << result.reason;
    if (i % 100 == 99) {
      ASSERT_TRUE(writer.wait_acknowledged(kPatience)) << i;
      collect();
    }
  }
  EXPECT_TRUE(wait_until(reader,
                         [&] {
                           collect();
                           return received == kGoals && disposed == kGoals - static_cast<std::uint64_t>(retained);
                         }))
      << received << " received, " << disposed << " disposed";

  Reader<msg::Goal> late(there_);
  ASSERT_TRUE(wait_until(late, [&] { return late.latest().size() == static_cast<std::size_t>(retained); }));
  EXPECT_NE(late.latest("arm1/5999"), nullptr);
  EXPECT_EQ(late.latest("arm1/" + std::to_string(kGoals - retained - 1)), nullptr);
}

TEST_F(Delivery, GivesAStateReaderOnlyTheNewestSample) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  for (std::uint64_t i = 1; i <= 50; ++i) ASSERT_TRUE(writer.write(arm_state("arm1", i)));
  // The last sample may be lost (best-effort), so write on until a later one arrives.
  std::uint64_t number = 50;
  std::uint64_t newest = 0;
  const auto until = Clock::now() + kPatience;
  while (newest <= 50 && Clock::now() < until) {
    ASSERT_TRUE(writer.write(arm_state("arm1", ++number)));
    if (!reader.wait_for_data(5ms)) continue;
    const auto samples = reader.take();
    ASSERT_LE(samples.size(), 1U);
    if (samples.empty()) continue;
    EXPECT_GT(samples[0].value.sequence_number(), newest) << "never back in time";
    newest = samples[0].value.sequence_number();
    EXPECT_DOUBLE_EQ(samples[0].value.q()[2], static_cast<double>(newest));
  }
  EXPECT_GT(newest, 50U);
}

TEST_F(Delivery, GivesAReliableReaderAllSamplesInOrder) {
  Writer<msg::WorldEditRequest> writer(here_);
  Reader<msg::WorldEditRequest> reader(there_);
  expect_matched(writer, reader);
  std::vector<std::uint64_t> seen;
  const auto collect = [&] {
    for (const auto& sample : reader.take()) seen.push_back(sample.value.request_id());
  };
  for (std::uint64_t i = 0; i < 320; ++i) {
    msg::WorldEditRequest request;
    request.request_id(i);
    ASSERT_TRUE(writer.write(request));
    if (i % 16 == 15) {
      ASSERT_TRUE(writer.wait_acknowledged(kPatience));
    }
  }
  ASSERT_TRUE(wait_until(reader, [&] {
    collect();
    return seen.size() == 320;
  })) << seen.size();
  for (std::uint64_t i = 0; i < 320; ++i) EXPECT_EQ(seen[i], i);
}

TEST_F(Delivery, DropsAndCountsTheOldestUnreadSamples) {
  Writer<msg::WorldEditRequest> writer(here_);
  ReaderOptions options;
  options.queue = 4;
  Reader<msg::WorldEditRequest> reader(there_, nullptr, options);
  expect_matched(writer, reader);
  for (std::uint64_t i = 0; i < 10; ++i) {
    msg::WorldEditRequest request;
    request.request_id(i);
    ASSERT_TRUE(writer.write(request));
  }
  ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received == 10; }));
  const auto samples = reader.take();
  ASSERT_EQ(samples.size(), 4U);
  EXPECT_EQ(samples.front().value.request_id(), 6U);
  EXPECT_EQ(reader.counters().overflowed, 6U);
}

// The sending thread of Fast DDS 2.9 can deadlock with the thread that learns of a reader's departure, see qos.cpp.
// With that sending thread one departure in fifty hung the writer's process on a busy machine.
TEST_F(Delivery, SurvivesDeparturesOfReadersWhileSamplesAreOnTheirWay) {
  constexpr int kRounds = 60;
  Writer<msg::WorldEditRequest> writer(here_);
  for (int round = 0; round < kRounds; ++round) {
    {
      Participant guest(domain_.number(), "guest", one_host());
      Reader<msg::WorldEditRequest> reader(guest);
      expect_matched(writer, reader);
      for (std::uint64_t i = 0; i < 10; ++i) {
        msg::WorldEditRequest request;
        request.request_id(i);
        ASSERT_TRUE(writer.write(request));
      }
      ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received == 10; }));
    }
    const auto until = Clock::now() + kPatience;
    while (writer.matched() > 0 && Clock::now() < until) std::this_thread::yield();
    ASSERT_EQ(writer.matched(), 0);
  }
}

bool names_second_writer(const Participant& reader, const std::string& node, const std::string& topic) {
  const auto refused = reader.refused(1min, 64);
  return std::any_of(refused.begin(), refused.end(), [&](const Refused& one) {
    return one.kind == RefusalKind::kSecondWriter && one.node == node && one.topic == topic;
  });
}

/// A participant "planner/north" or "supervisor", and an intruder.
class OwnedMessages : public Delivery {
 protected:
  template <class T>
  void expect_owned(const std::string& node, const T& message) {
    Participant owner(domain_.number(), node, one_host());
    Writer<T> own(owner);
    Writer<T> forged(here_);
    Reader<T> reader(there_);
    ASSERT_TRUE(own.wait_matched(1, kPatience));
    ASSERT_TRUE(forged.wait_matched(1, kPatience));
    ASSERT_TRUE(reader.wait_matched(2, kPatience));
    ASSERT_TRUE(forged.write(message));
    ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().refused == 1; }));
    ASSERT_TRUE(own.write(message));
    std::vector<Sample<T>> taken;
    ASSERT_TRUE(wait_until(reader, [&] {
      for (auto& sample : reader.take()) taken.push_back(std::move(sample));
      return !taken.empty();
    })) << Topic<T>::kInfo.type;
    ASSERT_EQ(taken.size(), 1U);
    EXPECT_TRUE(taken.front().writer.same_participant(own.id()));
    // The owner of an earlier call may have been heard just before the first message.
    auto again = Clock::now() + 1s;
    EXPECT_TRUE(wait_until(reader, [&] {
      if (Clock::now() > again) {
        EXPECT_TRUE(forged.write(message));
        again = Clock::now() + 1s;
      }
      return names_second_writer(there_, "here", std::string(Topic<T>::kInfo.type));
    })) << Topic<T>::kInfo.type;
    EXPECT_TRUE(reader.take().empty());
  }
};

TEST_F(OwnedMessages, ComeFromThePlannerOfTheArm) {
  msg::GoalStatus status;
  status.arm("north");
  status.goal("g");
  expect_owned("planner/north", status);
  msg::CoupledPlan plan;
  plan.arm("north");
  expect_owned("planner/north@beta", plan);
  msg::CoupledPlanProgress progress;
  progress.arm("north");
  expect_owned("planner/north", progress);
  msg::PlannerTick tick;
  tick.arm("north");
  expect_owned("planner/north", tick);
  msg::PlannedMotion motion;
  motion.arm("north");
  expect_owned("planner/north", motion);
}

TEST_F(OwnedMessages, ComeFromASupervisor) {
  msg::Fault fault;
  fault.id("f1-1");
  expect_owned("supervisor", fault);
  expect_owned("supervisor@beta", msg::SupervisorReply());
}

// A killed planner announces no departure. What its successor writes within the silence limit arrives, too.
TEST_F(OwnedMessages, OfARestartedPlannerAreNotLost) {
  Reader<msg::GoalStatus> reader(there_);
  msg::GoalStatus status;
  status.arm("north");
  status.goal("g");
  auto options = one_host();
  options.announce_departure = false;
  {
    Participant killed(domain_.number(), "planner/north", options);
    Writer<msg::GoalStatus> writer(killed);
    expect_matched(writer, reader);
    status.sequence_number(1);
    ASSERT_TRUE(writer.write(status));
    ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received == 1; }));
  }
  Participant restarted(domain_.number(), "planner/north", options);
  Writer<msg::GoalStatus> writer(restarted);
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  status.sequence_number(2);
  ASSERT_TRUE(writer.write(status));
  std::uint64_t last = 0;
  EXPECT_TRUE(wait_until(reader, [&] {
    for (const auto& sample : reader.take()) last = sample.value.sequence_number();
    return last == 2;
  }));
  EXPECT_FALSE(names_second_writer(there_, "planner/north", "GoalStatus"));
}

TEST_F(Delivery, HidesAClearedHistoryFromLateJoiners) {
  Writer<msg::Fault> faults(here_);
  Reader<msg::Fault> early(there_);
  msg::Fault fault;
  fault.id("f1-1");
  fault.term(1);
  ASSERT_TRUE(faults.write(fault));
  ASSERT_TRUE(wait_until(early, [&] { return early.counters().received == 1; }));
  faults.clear_history();
  Reader<msg::Fault> late(there_);
  ASSERT_TRUE(faults.wait_matched(2, kPatience));
  ASSERT_TRUE(late.wait_matched(1, kPatience));
  fault.term(2);
  ASSERT_TRUE(faults.write(fault));
  std::vector<std::uint64_t> terms;
  ASSERT_TRUE(wait_until(late, [&] {
    for (const auto& sample : late.take()) terms.push_back(sample.value.term());
    return !terms.empty() && terms.back() == 2;
  }));
  EXPECT_EQ(terms, std::vector<std::uint64_t>{2});
}

TEST_F(Delivery, HidesRequestsFromLateJoiners) {
  Writer<msg::WorldEditRequest> writer(here_);
  Reader<msg::WorldEditRequest> early(there_);
  expect_matched(writer, early);
  msg::WorldEditRequest request;
  request.request_id(1);
  ASSERT_TRUE(writer.write(request));
  ASSERT_TRUE(wait_until(early, [&] { return early.counters().received == 1; }));
  Reader<msg::WorldEditRequest> late(there_);
  ASSERT_TRUE(writer.wait_matched(2, kPatience));
  ASSERT_TRUE(late.wait_matched(1, kPatience));
  request.request_id(2);
  ASSERT_TRUE(writer.write(request));
  std::vector<Sample<msg::WorldEditRequest>> received;
  ASSERT_TRUE(wait_until(late, [&] {
    for (auto& sample : late.take()) received.push_back(std::move(sample));
    return !received.empty();
  }));
  EXPECT_EQ(received.front().value.request_id(), 2U);
}

TEST_F(Delivery, StampsArrivalsOnTheReadersClock) {
  Writer<msg::ArmState> writer(here_);
  Reader<msg::ArmState> reader(there_);
  expect_matched(writer, reader);
  auto state = arm_state("arm1", 1);
  state.stamp_ns(-1);  // whatever the sender's clock says
  const auto before = Clock::now();
  ASSERT_TRUE(wait_until(reader, [&] { return writer.write(state) && reader.latest("arm1") != nullptr; }));
  const auto* sample = reader.latest("arm1");
  EXPECT_GE(sample->received, before);
  EXPECT_LE(sample->received, Clock::now());
  EXPECT_EQ(sample->writer, writer.id());
}

}  // namespace
}  // namespace hecaton::bus
