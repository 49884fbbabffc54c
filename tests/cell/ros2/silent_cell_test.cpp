/// The servers of hecaton-ros2 in a cell whose planners and supervisor are silent.

#include <atomic>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "planner/model/kinematics.hpp"
#include "services/client/connection.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2/control.hpp"
#include "services/ros2/scene_editor.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/process_info.hpp"
#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

using Trigger = PeerClient<std_srvs::srv::Trigger_RequestPubSubType, std_srvs::srv::Trigger_ResponsePubSubType>;

config::CellFile three_puma_with_ros2() {
  config::CellFile file = config::load_cell_file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
  file.ros2.emplace().ns = "/cell";
  return file;
}

class SilentCell : public testing::Test {
 protected:
  /// Calls `update` in a thread until the end of the test, with a time that is `ahead_` of the clock.
  void serve(const std::function<void(bus::Clock::time_point)>& update) {
    loop_ = std::jthread([this, update](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        static_cast<void>(mailbox_.wait(5ms));
        update(bus::Clock::now() + ahead_.load());
      }
    });
  }

  FreeDomain cell_domain_;
  FreeDomain ros_domain_;
  config::CellFile file_ = three_puma_with_ros2();
  bus::Mailbox mailbox_;
  bus::Participant participant_{ros_domain_.number(), "/", bus::ros2::participant_options()};
  std::shared_ptr<client::Connection> connection_ =
      client::Connection::make(client::join(file_, cell_domain_.number()));
  RosPeer peer_{ros_domain_.number()};
  std::atomic<std::chrono::seconds> ahead_{0s};
  std::jthread loop_;
};

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
      server_->update(snapshot, now);
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
  std::atomic<bool> has_state_{true};  ///< of the driver
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

TEST_F(SilentCell, KeepsABoundedNumberOfObjectsAndShapesThatWait) {
  ros2::SceneWorker worker(connection_);
  const auto scene_of = [](std::size_t shapes) {
    ros2::SceneEdits scene;
    ros2::SceneEdit& edit = scene.edits.emplace_back();
    edit.obstacle.name = "crate";
    edit.obstacle.shapes.resize(shapes, {world::Sphere{0.1}, world::Pose::Identity()});
    return scene;
  };
  worker.add(scene_of(ros2::SceneWorker::kMostWaiting));
  auto report = worker.report();
  EXPECT_EQ(report.refused, 1U);
  ASSERT_TRUE(report.refusal);
  EXPECT_NE(report.refusal->find("8194 objects and shapes are dropped: 0 wait already, and at most 8192 may"),
            std::string::npos)
      << *report.refusal;
  ros2::SceneEdits refusals;
  refusals.refusals.resize(ros2::SceneWorker::kMostWaiting, {"crate", "its shape is a cone"});
  worker.add(refusals);
  EXPECT_EQ(worker.report().refused, 2U) << "those of refused objects take memory, too";
}

/// A world service that obeys a test.
class ObedientWorld {
 public:
  using Judge = std::function<bool(const msg::Obstacle&)>;

  ObedientWorld(const config::CellFile& file, int domain) : participant_(domain, "world", in_partition(file)) {}

  /// `accepts`: whether an obstacle may be added.
  void judge_by(Judge accepts) {
    const std::scoped_lock lock(mutex_);
    accepts_ = std::move(accepts);
  }
  /// Answers nothing from the next removal on, as a process that is killed then.
  void fall_silent_after_a_removal() {
    const std::scoped_lock lock(mutex_);
    last_ = true;
  }
  void answer_again() {
    const std::scoped_lock lock(mutex_);
    last_ = silent_ = false;
  }
  [[nodiscard]] std::optional<msg::Obstacle> find(const std::string& name) const {
    const std::scoped_lock lock(mutex_);
    const auto found = obstacles_.find(name);
    return found == obstacles_.end() ? std::nullopt : std::optional(found->second);
  }
  /// Of the sphere of that name [m]; 0: there is none.
  [[nodiscard]] double radius(const std::string& name) const {
    const auto obstacle = find(name);
    return obstacle ? obstacle->shapes().at(0).dimensions().x() : 0.0;
  }

 private:
  static bus::ParticipantOptions in_partition(const config::CellFile& file) {
    bus::ParticipantOptions options;
    options.partition = file.cell.name;
    return options;
  }
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      static_cast<void>(mailbox_.wait(20ms));
      static_cast<void>(mailbox_.take_events());
      const std::scoped_lock lock(mutex_);
      for (const auto& sample : requests_.take()) {
        if (!silent_ && !sample.disposed) edit(sample.value);
      }
      publish_states();
    }
  }
  void edit(const msg::WorldEditRequest& request) {
    if (!taken_.insert({request.client(), request.request_id()}).second) return;
    msg::WorldEditReply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.done(true);
    const bool adds = request.kind() == msg::EditKind::EDIT_ADD;
    const std::string& name = adds ? request.obstacle().name() : request.name();
    const auto refuse = [&](msg::CauseKind kind) {
      reply.done(false);
      reply.cause(services::make_cause(kind, name, "refused by the test"));
    };
    const bool known = obstacles_.contains(name);
    if (adds && known) {
      refuse(msg::CauseKind::CAUSE_NAME_TAKEN);
    } else if (adds && !accepts_(request.obstacle())) {
      refuse(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW);
    } else if (adds) {
      obstacles_[name] = request.obstacle();
    } else if (!known) {
      refuse(msg::CauseKind::CAUSE_UNKNOWN_NAME);
    } else if (request.kind() == msg::EditKind::EDIT_MOVE) {
      obstacles_[name].X_WO(request.X_WO());
    } else {
      obstacles_.erase(name);
      silent_ = last_;
    }
    if (reply.done()) publish_shapes(name);
    reply.edition(edition_);
    static_cast<void>(replies_.write(reply));
  }
  void publish_shapes(const std::string& name) {
    msg::ObstacleShapes message;
    message.name(name);
    message.term(1);
    message.edition(++edition_);
    message.stamp_ns(services::stamp_now());
    const auto found = obstacles_.find(name);
    if (found == obstacles_.end()) {
      static_cast<void>(shapes_.retire(message));
      return;
    }
    message.obstacle(found->second);
    static_cast<void>(shapes_.write(message));
  }
  void publish_states() {
    msg::ObstacleStates message;
    message.term(1);
    message.edition(edition_);
    message.sequence_number(++sequence_);
    message.stamp_ns(services::stamp_now());
    for (const auto& [name, obstacle] : obstacles_) {
      msg::ObstacleState& state = message.states().emplace_back();
      state.name(name);
      state.X_WO(obstacle.X_WO());
    }
    static_cast<void>(states_.write(message));
  }

  bus::Participant participant_;
  bus::Mailbox mailbox_;
  bus::Reader<msg::WorldEditRequest> requests_{participant_, &mailbox_};
  bus::Writer<msg::WorldEditReply> replies_{participant_};
  bus::Writer<msg::ObstacleShapes> shapes_{participant_};
  bus::Writer<msg::ObstacleStates> states_{participant_};
  mutable std::mutex mutex_;  ///< guards what follows
  Judge accepts_ = [](const msg::Obstacle&) { return true; };
  bool last_ = false;
  bool silent_ = false;
  std::map<std::string, msg::Obstacle> obstacles_;
  std::set<std::pair<std::string, std::uint64_t>> taken_;
  std::uint64_t edition_ = 0;
  std::uint64_t sequence_ = 0;
  std::jthread thread_{[this](const std::stop_token& stop) { run(stop); }};
};

/// Edits of the obstacle `crate`, a sphere.
class EditedCrate : public SilentCell {
 protected:
  void SetUp() override {
    add(0.1);
    ASSERT_TRUE(eventually([&] { return world_.radius("crate") == 0.1 && worker_.report().applied == 1; }))
        << worker_.report().refusal.value_or("no answer");
  }
  static ros2::SceneEdit edit_of(ros2::SceneEdit::Kind kind, const std::string& name) {
    ros2::SceneEdit edit{kind, {}};
    edit.obstacle.name = name;
    edit.obstacle.X_WO.translation().x() = 1.0;
    return edit;
  }
  void order(const ros2::SceneEdit& edit) { worker_.add({{edit}, {}}); }
  void add(double radius, const std::string& name = "crate") {
    ros2::SceneEdit edit = edit_of(ros2::SceneEdit::Kind::kAdd, name);
    edit.obstacle.shapes = {{world::Sphere{radius}, world::Pose::Identity()}};
    order(edit);
  }
  [[nodiscard]] bool eventually(const std::function<bool()>& condition) const {
    return connection_->wait_until(condition, kLong);
  }
  [[nodiscard]] bool waits_for_missing() const {
    return eventually([&] { return worker_.report().missing.has_value(); });
  }
  [[nodiscard]] bool waits_for_none_missing() const {
    return eventually([&] { return !worker_.report().missing; });
  }
  /// The world service ends while a larger sphere replaces the crate.
  void lose_crate(double radius) {
    world_.fall_silent_after_a_removal();
    add(radius);
    ASSERT_TRUE(waits_for_missing());
    ASSERT_FALSE(world_.find("crate"));
  }

  ObedientWorld world_{file_, cell_domain_.number()};
  ros2::SceneWorker worker_{connection_};
};

TEST_F(EditedCrate, IsAddedAgainWhenTheWorldAnswers) {
  lose_crate(0.2);
  const auto report = worker_.report();
  EXPECT_NE(report.missing->find("the cell lacks 'crate', from which arms keep no distance"), std::string::npos)
      << *report.missing;
  EXPECT_EQ(report.refused, 1U);
  world_.answer_again();
  EXPECT_TRUE(eventually([&] { return world_.radius("crate") == 0.2; })) << "without another scene";
  EXPECT_TRUE(waits_for_none_missing());
}

TEST_F(EditedCrate, IsRestoredOnceTheWorldAcceptsOneOfItsForms) {
  const auto radius_of = [](const msg::Obstacle& obstacle) { return obstacle.shapes().at(0).dimensions().x(); };
  world_.judge_by([](const msg::Obstacle&) { return false; });
  add(0.2);
  ASSERT_TRUE(waits_for_missing());
  EXPECT_NE(worker_.report().missing->find("refused by the test"), std::string::npos) << *worker_.report().missing;
  world_.judge_by([radius_of](const msg::Obstacle& obstacle) { return radius_of(obstacle) < 0.15; });
  EXPECT_TRUE(waits_for_none_missing());
  EXPECT_EQ(world_.radius("crate"), 0.1) << "as it was";
}

TEST_F(EditedCrate, IsAddedWhereALaterEditPutsIt) {
  lose_crate(0.2);
  ros2::SceneEdit move = edit_of(ros2::SceneEdit::Kind::kMove, "crate");
  move.obstacle.X_WO.translation().x() = 2.0;
  order(move);
  ASSERT_TRUE(eventually([&] { return worker_.report().refused == 2; })) << "the world does not answer";
  world_.answer_again();
  ASSERT_TRUE(waits_for_none_missing());
  ASSERT_TRUE(world_.find("crate"));
  EXPECT_EQ(world_.find("crate")->X_WO().position().x(), 2.0);

  lose_crate(0.3);
  add(0.4);
  ASSERT_TRUE(eventually([&] { return worker_.report().refused == 4; }));
  world_.answer_again();
  EXPECT_TRUE(waits_for_none_missing());
  EXPECT_EQ(world_.radius("crate"), 0.4) << "the newest one";
}

TEST_F(EditedCrate, IsNotAddedAgainAfterItsRemoval) {
  lose_crate(0.2);
  order(edit_of(ros2::SceneEdit::Kind::kRemove, "crate"));
  ASSERT_TRUE(waits_for_none_missing());
  world_.answer_again();
  add(0.1, "box");
  EXPECT_TRUE(eventually([&] { return world_.radius("box") == 0.1; }));
  EXPECT_FALSE(world_.find("crate"));
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
