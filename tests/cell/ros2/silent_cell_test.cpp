/// The servers of hecaton-ros2 in a cell whose planners and supervisor are silent.

#include "tests/cell/ros2/silent_cell.hpp"

#include <atomic>
#include <deque>
#include <future>
#include <set>

#include "planner/model/kinematics.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2/control.hpp"
#include "services/ros2/planner_watch.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::test {
namespace {

using Trigger = PeerClient<std_srvs::srv::Trigger_RequestPubSubType, std_srvs::srv::Trigger_ResponsePubSubType>;

class SilentPlanner : public SilentCell {
 protected:
  SilentPlanner() {
    const auto& home = arm_.home();
    state_.value.q({home.begin(), home.end()});
    state_.received = bus::Clock::now();
    planner::forward_kinematics(*arm_.model, arm_.X_WB, home, kinematics_);
    start();
  }
  ~SilentPlanner() override { end(); }
  /// The service, with what an earlier one has left.
  void start() {
    make_server();
    run();
  }
  void make_server() { server_.emplace(participant_, "/cell", arm_, connection_, mailbox_, checkpoint_); }
  void run() {
    serve([this](bus::Clock::time_point now) {
      ros2::ArmSnapshot snapshot;
      snapshot.arm = &arm_;
      if (has_state_) {
        snapshot.state = &state_;
        snapshot.kinematics = &kinematics_;
      }
      ros2::ArmReadiness readiness{.planner_heard = planner_heard_};
      if (latched_) readiness.latched_by = "the arm is stopped: stop by operator";
      server_->update(snapshot, readiness, now);
    });
  }
  /// Requests wait until run().
  void pause() {
    loop_.request_stop();
    loop_.join();
  }
  void end() {
    pause();
    server_.reset();
  }
  /// Asks again until the service answers: after a restart the first requests may find none.
  std::optional<Result> result_of(const ActionClient::Id& id) {
    std::optional<Result> result;
    const auto until = std::chrono::steady_clock::now() + kLong;
    while (!result && std::chrono::steady_clock::now() < until) {
      result = client_.await_result(client_.ask_result(id), 2s);
    }
    return result;
  }
  [[nodiscard]] auto trajectory() const {
    const auto& home = arm_.home();
    return client_.ramp({home.begin(), home.end()}, {0.3, 0.1, -0.1, 0.2, 0.0, 0.0}, 60.0);
  }
  std::optional<ActionClient::Id> send_trajectory() { return client_.send(trajectory()); }
  /// Waits until the service publishes these statuses of its newest goals, oldest first.
  bool wait_for_statuses(const std::vector<int>& newest) {
    const auto fits = [&](const auto& message) {
      const auto& list = message.status_list();
      return list.size() >= newest.size() &&
             std::equal(newest.rbegin(), newest.rend(), list.rbegin(),
                        [](int status, const auto& goal) { return goal.status() == status; });
    };
    return client_.statuses.next(fits).has_value();
  }

  const planner::Arm& arm_ = file_.cell.arms[0].arm;
  bus::Sample<msg::ArmState> state_;
  planner::Kinematics kinematics_;
  std::atomic<bool> has_state_{true};      ///< of the driver
  std::atomic<bool> planner_heard_{true};  ///< it runs, but does not answer
  std::atomic<bool> latched_{false};       ///< the arm was stopped
  TemporaryFolder run_;
  std::string checkpoint_ = run_.path("ros2-north");
  std::optional<ros2::TrajectoryServer> server_;
  ActionClient client_{peer_, arm_.name};
};

const ActionClient::Id kNoGoal{};

TEST_F(SilentPlanner, EndsACancelledTrajectoryThatNoPlannerAnswers) {
  ASSERT_TRUE(client_.wait_available());
  const auto id = send_trajectory();
  ASSERT_TRUE(id);
  ASSERT_EQ(client_.cancel(*id), 0);
  const auto asked = client_.ask_result(*id);
  ahead_ = 11s;
  const auto result = client_.await_result(asked);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kCanceled);
  EXPECT_NE(result->result().error_string().find("no planner of the arm has confirmed it for 10 s"), std::string::npos)
      << result->result().error_string();
  EXPECT_EQ(client_.cancel(*id), 3) << "it has ended";
}

TEST_F(SilentPlanner, EndsATrajectoryAfterARestartWithoutAStateOfTheArm) {
  ASSERT_TRUE(client_.wait_available());
  const auto id = send_trajectory();
  ASSERT_TRUE(id);
  end();
  has_state_ = false;
  start();
  ahead_ = 11s;
  const auto result = result_of(*id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_NE(result->result().error_string().find("no planner knows the goal"), std::string::npos)
      << result->result().error_string();
}

TEST_F(SilentPlanner, KeepsATrajectoryWhileNoPlannerIsHeard) {
  planner_heard_ = false;
  ASSERT_TRUE(client_.wait_available());
  const auto id = send_trajectory();
  ASSERT_TRUE(id);
  end();
  start();
  ahead_ = 12s;
  EXPECT_FALSE(client_.await_result(client_.ask_result(*id), 2s)) << "a planner may start yet";
  ahead_ = 60s;
  const auto result = result_of(*id);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_NE(result->result().error_string().find("no planner of the arm was heard for 30 s"), std::string::npos)
      << result->result().error_string();
}

TEST_F(SilentPlanner, RefusesATrajectoryForAStoppedArmAndKeepsTheOneBefore) {
  ASSERT_TRUE(client_.wait_available());
  const auto before = send_trajectory();
  ASSERT_TRUE(before && wait_for_statuses({ros2::ActionGoals::kExecuting}));
  latched_ = true;
  const auto late = send_trajectory();
  ASSERT_TRUE(late);
  const auto result = result_of(*late);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(result->result().error_code(), -1);
  EXPECT_EQ(result->result().error_string(),
            "the arm is stopped: stop by operator; resume it, then send the trajectory again");
  EXPECT_TRUE(wait_for_statuses({ros2::ActionGoals::kExecuting, kAborted})) << "a stop keeps what was under way";
}

TEST(Ros2Control, FindsTheArmsThatStandUntilAPersonResumesThem) {
  services::CellModeView modes;
  EXPECT_FALSE(ros2::latched_by(modes, "north")) << "the mode is not known";
  msg::CellMode mode;
  mode.term(1);
  const auto order_north = [&](msg::Mode what, msg::CauseKind kind, const std::string& text) {
    msg::ArmOrder order;
    order.arm("north");
    order.mode(what);
    order.ordered(what);
    order.cause(services::make_cause(kind, "north", text));
    mode.arms({order});
    mode.sequence_number(mode.sequence_number() + 1);
    ASSERT_TRUE(modes.apply(mode));
  };
  order_north(msg::Mode::MODE_HOLD, msg::CauseKind::CAUSE_HOLD_ORDERED, "hold by operator");
  EXPECT_FALSE(ros2::latched_by(modes, "north")) << "a hold is a pause";
  order_north(msg::Mode::MODE_STOP, msg::CauseKind::CAUSE_STOP_ORDERED, "stop by operator");
  EXPECT_EQ(ros2::latched_by(modes, "north"), "the arm is stopped: stop by operator");
  EXPECT_FALSE(ros2::latched_by(modes, "west"));
  order_north(msg::Mode::MODE_HOLD, msg::CauseKind::CAUSE_HELD_BY_FAULT, "hold until resumed: protective stop");
  EXPECT_EQ(ros2::latched_by(modes, "north"), "the arm is on hold until resumed: protective stop");
}

TEST(Ros2PlannerWatch, KnowsThePlannersOfAnArmUntilDiscoveryLosesThem) {
  ros2::PlannerWatch planners;
  const auto note = [&](bus::EventKind kind, const std::string& name, std::uint8_t participant) {
    bus::EndpointId peer;
    peer.bytes[0] = participant;
    planners.note({kind, {}, name, peer, {}});
  };
  note(bus::EventKind::kParticipantFound, "driver/north", 1);
  EXPECT_FALSE(planners.knows("north"));
  note(bus::EventKind::kParticipantFound, "planner/north", 2);
  note(bus::EventKind::kParticipantFound, "planner/north@beta", 3);
  EXPECT_TRUE(planners.knows("north"));
  EXPECT_FALSE(planners.knows("west"));
  note(bus::EventKind::kParticipantLost, "planner/north", 2);
  EXPECT_TRUE(planners.knows("north")) << "its standby is there";
  note(bus::EventKind::kParticipantLost, "planner/north@beta", 3);
  EXPECT_FALSE(planners.knows("north"));
}

/// What the planner of an arm receives. For one thread.
class GoalReceiver {
 public:
  GoalReceiver(const config::CellFile& file, int domain, const std::string& arm)
      : participant_(domain, "planner/" + arm, in_partition(file.cell.name)) {}

  /// The next goal or cancellation.
  std::optional<msg::Goal> next() {
    const auto until = std::chrono::steady_clock::now() + kLong;
    while (taken_.empty()) {
      if (std::chrono::steady_clock::now() > until) return std::nullopt;
      static_cast<void>(mailbox_.wait(20ms));
      static_cast<void>(mailbox_.take_events());
      for (auto& sample : goals_.take()) taken_.push_back(std::move(sample.value));
    }
    msg::Goal goal = std::move(taken_.front());
    taken_.pop_front();
    return goal;
  }
  bool reject(const msg::Goal& goal) {
    msg::GoalStatus rejected;
    rejected.arm(goal.arm());
    rejected.goal(goal.goal());
    rejected.term(1);
    rejected.sequence_number(1);
    rejected.stamp_ns(1);
    rejected.node("planner/" + goal.arm());
    rejected.state(msg::GoalState::GOAL_REJECTED);
    return static_cast<bool>(statuses_.write(rejected));
  }

 private:
  static bus::ParticipantOptions in_partition(const std::string& cell) {
    bus::ParticipantOptions options;
    options.partition = cell;
    return options;
  }
  bus::Participant participant_;
  bus::Mailbox mailbox_;
  bus::Reader<msg::Goal> goals_{participant_, &mailbox_};
  bus::Writer<msg::GoalStatus> statuses_{participant_};
  std::deque<msg::Goal> taken_;
};

TEST_F(SilentPlanner, CancelsAfterARestartWhatARejectedTrajectoryReplaced) {
  GoalReceiver planner(file_, cell_domain_.number(), arm_.name);
  ASSERT_TRUE(client_.wait_available());
  ASSERT_TRUE(send_trajectory());
  const auto first = planner.next();
  ASSERT_TRUE(first && send_trajectory());
  const auto second = planner.next();
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->cancel());
  end();
  start();
  ASSERT_TRUE(planner.reject(*second));
  const auto cancelled = planner.next();
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->goal(), first->goal());
  EXPECT_TRUE(cancelled->cancel());
}

TEST_F(SilentPlanner, SavesEachTrajectoryBeforeAPlannerReceivesIt) {
  GoalReceiver planner(file_, cell_domain_.number(), arm_.name);
  ASSERT_TRUE(client_.wait_available());
  std::vector<std::string> sent;
  for (int i = 0; i < 8; ++i) {
    auto received = std::async(std::launch::async, [&] {
      auto goal = planner.next();
      return std::pair(std::move(goal), ros2::ActionCheckpoint(checkpoint_).load(arm_.name));
    });
    ASSERT_TRUE(send_trajectory()) << i;
    const auto [goal, saved] = received.get();
    ASSERT_TRUE(goal && saved) << i;
    ASSERT_EQ(saved->active.size(), 1U) << i;
    EXPECT_EQ(saved->active[0].goal, goal->goal()) << i;
    EXPECT_EQ(saved->active[0].replaced, sent) << "no planner has answered them";
    sent.push_back(goal->goal());
  }
}

TEST_F(SilentPlanner, EndsAfterARestartWhatAKilledProcessLeft) {
  GoalReceiver planner(file_, cell_domain_.number(), arm_.name);
  ASSERT_TRUE(client_.wait_available());
  const auto id = send_trajectory();
  ASSERT_TRUE(id && planner.next());
  end();
  ros2::ActionCheckpoint checkpoint(checkpoint_);
  auto saved = checkpoint.load(arm_.name);
  ASSERT_TRUE(saved && saved->active.size() == 1);
  // Killed before it has sent the trajectory that replaces another. A second goal is in no list of the planner.
  const ActionClient::Id forgotten{7, 7, 7};
  saved->goals.push_back({{{forgotten}, {}}, ros2::ActionGoals::kExecuting, false, {}, 0});
  saved->active[0].goal = "client/killed/2";
  saved->active[0].replaced = {"client/killed/1"};
  saved->uncancelled = {"client/killed/0"};
  checkpoint.save(*saved);
  make_server();
  std::set<std::string> cancelled;
  for (int i = 0; i < 2; ++i) {
    const auto goal = planner.next();
    ASSERT_TRUE(goal && goal->cancel());
    cancelled.insert(goal->goal());
  }
  EXPECT_EQ(cancelled, (std::set<std::string>{"client/killed/0", "client/killed/1"}))
      << "at once: the arm may move along them";
  run();
  auto result = result_of(forgotten);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status(), kAborted);
  EXPECT_EQ(client_.cancel(forgotten), 3) << "it has ended";
  ahead_ = 11s;
  ASSERT_TRUE((result = result_of(*id)));
  EXPECT_EQ(result->status(), kAborted);
  const auto last = planner.next();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->goal(), "client/killed/2");
  EXPECT_TRUE(last->cancel());
}

TEST_F(SilentPlanner, CancelsAllGoalsBeforeOneThatComesWithTheCancellation) {
  ASSERT_TRUE(client_.wait_available());
  const auto first = send_trajectory();
  ASSERT_TRUE(first);
  pause();
  const auto cancellation = client_.begin_cancel(kNoGoal, 0);
  const auto second = client_.begin_send(trajectory());
  ASSERT_TRUE(client_.wait_received());
  run();
  const auto answer = client_.end_cancel(cancellation);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->goals_canceling().size(), 1U);
  EXPECT_EQ(answer->goals_canceling()[0].goal_id().uuid(), *first);
  EXPECT_TRUE(client_.end_send(second));
  EXPECT_TRUE(wait_for_statuses({kCanceled, ros2::ActionGoals::kExecuting}));
}

TEST_F(SilentPlanner, CancelsAGoalThatComesWithItsCancellation) {
  ASSERT_TRUE(client_.wait_available());
  pause();
  const auto sent = client_.begin_send(trajectory());
  const auto cancellation = client_.begin_cancel(sent.id, 0);
  ASSERT_TRUE(client_.wait_received());
  run();
  const auto answer = client_.end_cancel(cancellation);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->return_code(), 0);
  EXPECT_EQ(answer->goals_canceling().size(), 1U);
  EXPECT_TRUE(client_.end_send(sent));
  EXPECT_TRUE(wait_for_statuses({ros2::ActionGoals::kCanceling}));
}

TEST_F(SilentPlanner, AnswersCancellationsAsOtherActionServers) {
  ASSERT_TRUE(client_.wait_available());
  auto answer = client_.ask_cancel(kNoGoal, 0);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->return_code(), 0) << "of no goal, all are cancelled";
  EXPECT_TRUE(answer->goals_canceling().empty());
  EXPECT_EQ(client_.cancel({9, 9, 9}), 2);

  const auto id = send_trajectory();
  ASSERT_TRUE(id);
  answer = client_.ask_cancel(kNoGoal, 1);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->return_code(), 0) << "no goal is of 1970";
  EXPECT_TRUE(answer->goals_canceling().empty());
  answer = client_.ask_cancel(kNoGoal, std::numeric_limits<std::int32_t>::max());
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->return_code(), 0);
  ASSERT_EQ(answer->goals_canceling().size(), 1U);
  EXPECT_EQ(answer->goals_canceling()[0].goal_id().uuid(), *id);
}

TEST_F(SilentCell, StopsWithoutWaitingForOtherOrders) {
  ros2::OrderServices orders(participant_, file_, Cell(connection_), mailbox_);
  Trigger hold(peer_, "/cell/north/hold");
  Trigger hold_east(peer_, "/cell/east/hold");
  Trigger resume(peer_, "/cell/north/resume");
  Trigger resume_west(peer_, "/cell/west/resume");
  Trigger stop(peer_, "/cell/north/stop");
  serve([&](bus::Clock::time_point) { orders.update(); });
  for (Trigger* service : {&hold, &hold_east, &resume, &resume_west, &stop}) ASSERT_TRUE(service->wait_available());
  std::vector<rtps::SampleIdentity> holds;
  for (int i = 0; i < 4; ++i) holds.push_back(hold.send({}));
  const auto first = hold.receive(holds[0]);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->success()) << "no supervisor answers";
  const auto resumed = resume.send({});
  const auto resumed_west = resume_west.send({});
  const auto held_east = hold_east.send({});
  const auto stopped = stop.call({});
  ASSERT_TRUE(stopped);
  EXPECT_FALSE(stopped->success());
  const auto withdrawn = resume.receive(resumed);
  ASSERT_TRUE(withdrawn);
  EXPECT_TRUE(withdrawn->message().starts_with("not carried out: a later hold or stop")) << withdrawn->message();
  ASSERT_TRUE(hold_east.receive(held_east));
  EXPECT_FALSE(resume_west.receive(resumed_west, 0s)) << "the hold was sent later, but comes first";
  loop_.request_stop();
  loop_.join();
}

}  // namespace
}  // namespace hecaton::test
