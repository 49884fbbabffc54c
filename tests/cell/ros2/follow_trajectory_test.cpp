/// Trajectories of nodes of ROS 2 in a running cell of three arms.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>
#include <set>
#include <thread>

#include <idl/arm.h>

#include "services/bus/endpoint.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

const ActionClient::Id kUnknownGoal{9, 9, 9};
const std::vector<double> kStep{0.3, 0.1, -0.1, 0.2, 0.0, 0.0};

TEST_F(Ros2Cell, FollowsTrajectoriesOfThreeArmsAtOnce) {
  const Cell cell = connect();
  std::map<std::string, std::unique_ptr<ActionClient>> clients;
  std::map<std::string, std::vector<double>> starts;
  std::map<std::string, ActionClient::Id> ids;
  for (const char* arm : {"north", "west", "east"}) {
    clients[arm] = std::make_unique<ActionClient>(*peer_, arm);
    ASSERT_TRUE(clients[arm]->wait_available()) << arm;
    starts[arm] = home(cell, arm);
  }
  for (auto& [arm, client] : clients) {
    const auto id = client->send(client->ramp(starts[arm], kStep, 2.0));
    ASSERT_TRUE(id) << arm;
    ids[arm] = *id;
  }
  for (auto& [arm, client] : clients) {
    const auto feedback =
        client->feedback.next([&](const auto& message) { return message.goal_id().uuid() == ids[arm]; });
    ASSERT_TRUE(feedback) << arm;
    EXPECT_EQ(feedback->feedback().joint_names().front(), arm + "_joint1");
    EXPECT_EQ(feedback->feedback().actual().positions().size(), 6U);
    const auto result = client->await_result(ids[arm]);
    ASSERT_TRUE(result) << arm;
    EXPECT_EQ(result->status(), kSucceeded) << result->result().error_string();
    EXPECT_EQ(result->result().error_code(), 0);
    const auto q = cell.arm(arm).state(kLong).q;
    for (std::size_t j = 0; j < q.size(); ++j) EXPECT_NEAR(q[j], starts[arm][j] + kStep[j], 0.02) << arm << " " << j;
    EXPECT_TRUE(client->statuses.next([&](const auto& message) {
      return !message.status_list().empty() && message.status_list().back().status() == kSucceeded;
    }));
  }
  EXPECT_EQ(cell.status(kLong).contacts->contacts, 0U);
}

// As MoveIt sends it: positions and velocities each 0.1 s. Joint goals without the velocities would end far earlier.
TEST_F(Ros2Cell, FollowsVelocitiesInTheirTime) {
  constexpr double kDuration = 4.0;
  const Cell cell = connect();
  ActionClient client(*peer_, "north");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "north");
  std::vector<double> end = start;
  for (std::size_t j = 0; j < end.size(); ++j) end[j] += kStep[j];
  JointStates states(*peer_, "rt/cell/north/joint_states");
  ASSERT_TRUE(states.next([](const auto& message) { return !message.position().empty(); }));
  const auto begun = std::chrono::steady_clock::now();
  const auto id = client.send(client.smooth(start, end, kDuration));
  ASSERT_TRUE(id);
  const auto asked = client.ask_result(*id);
  double worst = 0.0;
  std::size_t samples = 0;
  while (std::chrono::steady_clock::now() < begun + std::chrono::duration<double>(0.9 * kDuration)) {
    const auto state = states.next([](const auto&) { return true; });
    ASSERT_TRUE(state);
    const std::vector<double>& q = state->position();
    const double share = std::clamp((q[0] - start[0]) / kStep[0], 0.0, 1.0);
    for (std::size_t j = 0; j < q.size(); ++j) worst = std::max(worst, std::abs(q[j] - start[j] - share * kStep[j]));
    ++samples;
  }
  EXPECT_GT(samples, 50U);
  EXPECT_LT(worst, 0.005) << "all joints move together";
  const auto result = client.await_result(asked);
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kSucceeded) << result->result().error_string();
  EXPECT_GT(took, kDuration);
  EXPECT_LT(took, kDuration + 1.0);
  RecordProperty("duration_s", std::to_string(took));
  RecordProperty("largest_deviation_rad", std::to_string(worst));
}

TEST_F(Ros2Cell, ExplainsInvalidTrajectories) {
  const Cell cell = connect();
  ActionClient client(*peer_, "west");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "west");
  const auto good = client.ramp(start, kStep, 2.0);
  const auto end_of = [&](const auto& goal) {
    const auto id = client.send(goal);
    return id ? client.await_result(*id) : std::nullopt;
  };
  auto goal = good;
  goal.trajectory().joint_names()[0] = "elbow";
  auto result = end_of(goal);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(result->result().error_code(), -2);
  EXPECT_NE(result->result().error_string().find("joint1"), std::string::npos);
  goal = good;
  goal.trajectory().points()[0].positions()[0] += 0.5;
  ASSERT_TRUE((result = end_of(goal)));
  EXPECT_EQ(result->result().error_code(), -1);
  goal = good;
  goal.trajectory().header().stamp().sec(1000);
  ASSERT_TRUE((result = end_of(goal)));
  EXPECT_EQ(result->result().error_code(), -3);
}

TEST_F(Ros2Cell, CancelsAndReplacesTrajectories) {
  const Cell cell = connect();
  ActionClient client(*peer_, "east");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "east");
  const auto first = client.send(client.ramp(start, kStep, 20.0));
  ASSERT_TRUE(first);
  const auto first_result = client.ask_result(*first);
  const auto moved = client.feedback.next(
      [&](const auto& message) { return message.feedback().desired().time_from_start().sec() >= 1; });
  ASSERT_TRUE(moved);
  auto now = cell.arm("east").state(kLong).q;
  auto second_goal = client.ramp(now, kStep, 20.0);
  second_goal.trajectory().points().erase(second_goal.trajectory().points().begin());
  const auto second = client.send(second_goal);
  ASSERT_TRUE(second);
  auto result = client.await_result(first_result);
  ASSERT_TRUE(result) << "it was asked for before the goal ended";
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(client.cancel(kUnknownGoal), 2);
  EXPECT_EQ(client.cancel(*first), 3) << "the goal has ended";
  EXPECT_EQ(client.cancel(*second), 0);
  result = client.await_result(*second);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kCanceled);
}

TEST_F(Ros2Cell, NamesThePairAndTheDistanceOfARefusedGoal) {
  const Cell cell = connect();
  ActionClient client(*peer_, "north");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "north");
  const auto end = obstructed(cell, start);
  const auto id = client.send(client.smooth(start, end, 4.0));
  ASSERT_TRUE(id);
  const auto result = client.await_result(*id);
  EXPECT_NO_THROW(cell.world().remove("obstruction", kLong));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(result->result().error_code(), -1);
  const std::string& why = result->result().error_string();
  EXPECT_TRUE(why.starts_with("the planner rejects the trajectory")) << why;
  const std::regex pair("north/[\\w.]+ and obstruction overlap by [0-9.]+ mm \\(minimum distance [0-9.]+ mm\\)");
  EXPECT_TRUE(std::regex_search(why, pair)) << why;
}

/// The states that the drivers send, as fast as a thread of this process takes them.
class DriverStates {
 public:
  struct Seen {
    bus::Clock::time_point at;
    double speed = 0.0;        ///< of joint 1 [rad/s]
    double command_age = 0.0;  ///< [s]
  };
  using OfArms = std::map<std::string, std::vector<Seen>>;

  DriverStates(int domain, const std::string& cell) : participant_(domain, "observer", in_partition(cell)) {}
  /// Those since the start.
  OfArms end() {
    thread_.request_stop();
    thread_.join();
    return seen_;
  }

 private:
  static bus::ParticipantOptions in_partition(const std::string& cell) {
    bus::ParticipantOptions options;
    options.partition = cell;
    return options;
  }
  void watch(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      static_cast<void>(mailbox_.wait(std::chrono::milliseconds(5)));
      static_cast<void>(mailbox_.take_events());
      for (const auto& sample : states_.take()) {
        if (sample.disposed || sample.value.qd().empty()) continue;
        seen_[sample.value.arm()].push_back({sample.received, sample.value.qd()[0], sample.value.command_age()});
      }
    }
  }

  bus::Participant participant_;
  bus::Mailbox mailbox_;
  bus::Reader<msg::ArmState> states_{participant_, &mailbox_};
  OfArms seen_;
  std::jthread thread_{[this](const std::stop_token& stop) { watch(stop); }};
};

/// A command or a state of an arm was late between these times.
bool is_late(const std::vector<DriverStates::Seen>& seen, bus::Clock::time_point from, bus::Clock::time_point to) {
  constexpr double kLate = 0.015;  // control period, and half of another [s]
  for (std::size_t i = 1; i < seen.size(); ++i) {
    if (seen[i].at < from || seen[i - 1].at > to) continue;
    const std::chrono::duration<double> gap = seen[i].at - seen[i - 1].at;
    if (seen[i].command_age > kLate || gap.count() > kLate) return true;
  }
  return false;
}

/// A stall of the machine stops `north`: its driver brakes when a command is late, from this speed within 17 ms. But a
/// planner that sends no command while it replaces a trajectory looks the same at its own driver. So the driver of
/// another arm must show the stall at the same time. It can: each planner in charge sends a command in each period,
/// also for an arm at rest. The other planners have no part in the replacement.
bool is_machine_stalled(const DriverStates::OfArms& arms, bus::Clock::time_point at) {
  const auto from = at - std::chrono::milliseconds(100);  // until the arm has its speed again
  const auto to = at + std::chrono::milliseconds(20);     // two periods: states of two drivers are not simultaneous
  return is_late(arms.at("north"), from, to) && std::any_of(arms.begin(), arms.end(), [&](const auto& arm) {
           return arm.first != "north" && is_late(arm.second, from, to);
         });
}

/// What the states of a driver show from the moment at which a trajectory is replaced.
struct Replacement {
  double slowest = 0.0;  ///< while the machine does not stall [rad/s]
  int judged = 0;   ///< states within half a second of the answer to the later trajectory, without those of a stall
  int excused = 0;  ///< states of a stall
};

constexpr double kTurnSpeed = 0.1;  // [rad/s]

/// Replaces a trajectory of `north`, which is at `start`, by one that goes on in the same direction.
void replace_trajectory(const Cell& cell, RosPeer& peer, int domain, const std::vector<double>& start,
                        Replacement& replacement) {
  ActionClient client(peer, "north");
  ASSERT_TRUE(client.wait_available());
  DriverStates drivers(domain, "three_puma");
  const auto turn = [&](const std::vector<double>& from, double angle) {
    std::vector<double> delta(from.size(), 0.0);
    delta[0] = angle;
    return client.ramp(from, delta, angle / kTurnSpeed);
  };
  const auto first = client.send(turn(start, 0.5));
  ASSERT_TRUE(first);
  const auto first_result = client.ask_result(*first);
  const auto comes_to = [&](const ActionClient::Id& id, std::int32_t seconds) {
    return client.feedback.next([&](const auto& message) {
      return message.goal_id().uuid() == id && message.feedback().desired().time_from_start().sec() >= seconds;
    });
  };
  ASSERT_TRUE(comes_to(*first, 2));
  JointStates states(peer, "rt/cell/north/joint_states");
  ASSERT_TRUE(states.next([](const auto& message) { return message.velocity()[0] > 0.5 * kTurnSpeed; }));
  const auto replaced_at = bus::Clock::now();
  auto second_goal = turn(cell.arm("north").state(kLong).q, 0.3);
  second_goal.trajectory().points().erase(second_goal.trajectory().points().begin());
  const auto second = client.send(second_goal);
  ASSERT_TRUE(second);
  const auto answered_at = bus::Clock::now();
  ASSERT_TRUE(comes_to(*second, 1));
  const auto seen = drivers.end();
  EXPECT_GT(states.take().size(), 20U);
  for (const char* arm : {"north", "west", "east"}) ASSERT_TRUE(seen.contains(arm)) << arm;
  replacement = {kTurnSpeed, 0, 0};
  for (const DriverStates::Seen& state : seen.at("north")) {
    if (state.at < replaced_at) continue;
    if (is_machine_stalled(seen, state.at)) {
      ++replacement.excused;
      continue;
    }
    if (state.at < answered_at + std::chrono::milliseconds(500)) ++replacement.judged;
    replacement.slowest = std::min(replacement.slowest, state.speed);
  }
  std::cout << "slowest " << replacement.slowest << " rad/s of " << kTurnSpeed << ", " << replacement.judged
            << " states judged at the replacement; " << replacement.excused << " after a stall of this machine\n";
  auto result = client.await_result(first_result);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(result->result().error_string(), "a later trajectory has replaced this one");
  ASSERT_TRUE((result = client.await_result(*second)));
  EXPECT_EQ(result->status(), kSucceeded) << result->result().error_string();
}

// Repeated only while the machine stalls too often to judge anything.
TEST_F(Ros2Cell, ReplacesATrajectoryWithoutAStop) {
  constexpr int kTries = 4;
  constexpr int kEnough = 20;  // states: of a fifth of a second
  const Cell cell = connect();
  Replacement last;
  for (int i = 0; i < kTries && last.judged <= kEnough; ++i) {
    const auto start = home(cell, "north");
    ASSERT_NO_FATAL_FAILURE(replace_trajectory(cell, *peer_, cell_domain_->number(), start, last));
    EXPECT_GT(last.slowest, 0.02 * kTurnSpeed) << "rad/s";
  }
  EXPECT_GT(last.judged, kEnough) << "states: this machine stalls too often";
}

TEST_F(Ros2Cell, StopsTheArmWhenThePlannerRejectsTheTrajectoryThatReplacesAnother) {
  const Cell cell = connect();
  ActionClient client(*peer_, "north");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "north");
  const auto end = obstructed(cell, start);
  std::vector<double> delta(start.size(), 0.0);
  delta[0] = -0.4;
  const auto first = client.send(client.ramp(start, delta, 40.0));
  ASSERT_TRUE(first);
  ASSERT_TRUE(client.feedback.next(
      [&](const auto& message) { return message.feedback().desired().time_from_start().sec() >= 1; }));
  const auto second = client.send(client.smooth(cell.arm("north").state(kLong).q, end, 10.0));
  ASSERT_TRUE(second);
  const auto result = client.await_result(*second);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_TRUE(result->result().error_string().starts_with("the planner rejects the trajectory"));
  // Its client knows that the first one has ended, too.
  const bool ended = cell.wait_until(
      [&] {
        const auto goal = cell.arm("north").goal();
        return goal && goal->state == GoalState::kCancelled;
      },
      kLong);
  EXPECT_TRUE(ended) << "the arm goes on along a trajectory that has ended for its client";
  EXPECT_NO_THROW(cell.world().remove("obstruction", kLong));
}

TEST_F(Ros2Cell, AnswersWhatWasAskedBeforeItsOwnRestart) {
  const Cell cell = connect();
  std::map<std::string, std::unique_ptr<ActionClient>> clients;
  std::map<std::string, ActionClient::Id> ids;
  std::map<std::string, rtps::SampleIdentity> asked;
  for (const auto& [arm, seconds] : std::map<std::string, double>{{"north", 12.0}, {"west", 60.0}, {"east", 2.0}}) {
    clients[arm] = std::make_unique<ActionClient>(*peer_, arm);
    ASSERT_TRUE(clients[arm]->wait_available()) << arm;
    const auto start = home(cell, arm);
    const auto id = clients[arm]->send(clients[arm]->ramp(start, kStep, seconds));
    ASSERT_TRUE(id) << arm;
    ids[arm] = *id;
    asked[arm] = clients[arm]->ask_result(*id);
    ASSERT_TRUE(clients[arm]->await_result(kUnknownGoal)) << "the request before this one has arrived";
    ASSERT_TRUE(clients[arm]->feedback.next([&](const auto& message) { return message.goal_id().uuid() == *id; }));
  }
  const auto goal_of_east = [&] { return cell.arm("east").goal(); };
  ASSERT_TRUE(goal_of_east());
  ros2_->signal(SIGKILL);
  static_cast<void>(ros2_->wait());
  ASSERT_TRUE(cell.wait_until([&] { return goal_of_east()->state == GoalState::kReached; }, kLong));
  clients["north"]->feedback.clear();
  start_ros2();

  auto result = clients["east"]->await_result(asked["east"]);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kSucceeded) << result->result().error_string();
  const auto feedback =
      clients["north"]->feedback.next([&](const auto& message) { return message.goal_id().uuid() == ids["north"]; });
  ASSERT_TRUE(feedback);
  EXPECT_GE(feedback->feedback().desired().time_from_start().sec(), 1) << "not from its start";
  ASSERT_TRUE(clients["west"]->wait_available());
  EXPECT_EQ(clients["west"]->cancel(ids["west"]), 0);
  ASSERT_TRUE((result = clients["west"]->await_result(asked["west"])));
  EXPECT_EQ(result->status(), kCanceled) << result->result().error_string();
  ASSERT_TRUE((result = clients["north"]->await_result(asked["north"])));
  EXPECT_EQ(result->status(), kSucceeded) << result->result().error_string();
  ASSERT_TRUE((result = clients["north"]->await_result(ids["north"]))) << "asked a second time";
  EXPECT_EQ(result->status(), kSucceeded);
  EXPECT_FALSE(clients["north"]->send_again(ids["north"])) << "the id is known";
}

TEST_F(Ros2Cell, EndsATrajectoryThatNoPlannerKnowsAfterItsOwnRestart) {
  const Cell cell = connect();
  ActionClient client(*peer_, "east");
  ASSERT_TRUE(client.wait_available());
  const auto start = home(cell, "east");
  const auto id = client.send(client.ramp(start, kStep, 60.0));
  ASSERT_TRUE(id);
  const auto asked = client.ask_result(*id);
  ASSERT_TRUE(client.await_result(kUnknownGoal)) << "the request before this one has arrived";
  ros2_->signal(SIGKILL);
  static_cast<void>(ros2_->wait());
  ros2::ActionCheckpoint checkpoint(folder_->path("ros2-east"));
  auto saved = checkpoint.load("east");
  ASSERT_TRUE(saved);
  ASSERT_EQ(saved->active.size(), 1U);
  saved->active[0].goal = "forgotten";
  checkpoint.save(*saved);
  start_ros2();
  const auto result = client.await_result(asked);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(result->result().error_code(), -1);
  EXPECT_NE(result->result().error_string().find("no planner knows the goal"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::test
