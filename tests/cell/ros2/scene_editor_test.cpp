/// Edits of planning scenes, at a world service that obeys a test.

#include "services/ros2/scene_editor.hpp"

#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/process_info.hpp"
#include "tests/cell/ros2/silent_cell.hpp"

namespace hecaton::test {
namespace {

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
  /// Answers nothing from now on, as a process that is killed.
  void fall_silent() {
    const std::scoped_lock lock(mutex_);
    silent_ = true;
  }
  /// The kinds of all edits that it has received.
  [[nodiscard]] std::vector<msg::EditKind> edits() const {
    const std::scoped_lock lock(mutex_);
    return edits_;
  }
  void answer_again() {
    const std::scoped_lock lock(mutex_);
    silent_ = false;
  }
  /// Another client puts a sphere there [m], which `arm` carries if it has a name.
  void put(const std::string& name, double radius, const std::string& arm = {}) {
    world::Obstacle obstacle;
    obstacle.name = name;
    obstacle.shapes = {{world::Sphere{radius}, world::Pose::Identity()}};
    if (!arm.empty()) obstacle.attachment.emplace().arm = arm;
    const std::scoped_lock lock(mutex_);
    obstacles_[name] = messages::to_message(obstacle);
    publish_shapes(name);
  }
  /// The arm that carries an obstacle; empty: none.
  [[nodiscard]] std::string carrier(const std::string& name) const {
    const auto obstacle = find(name);
    return obstacle ? obstacle->attached_to() : "no obstacle";
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
    edits_.push_back(request.kind());
    msg::WorldEditReply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.done(true);
    const bool replaces = request.kind() == msg::EditKind::EDIT_REPLACE;
    const bool adds = replaces || request.kind() == msg::EditKind::EDIT_ADD;
    const std::string& name = adds ? request.obstacle().name() : request.name();
    const auto refuse = [&](msg::CauseKind kind) {
      reply.done(false);
      reply.cause(services::make_cause(kind, name, "refused by the test"));
    };
    const bool known = obstacles_.contains(name);
    if (adds && known && !replaces) {
      refuse(msg::CauseKind::CAUSE_NAME_TAKEN);
    } else if (adds && !accepts_(request.obstacle())) {
      refuse(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW);
    } else if (adds) {
      obstacles_[name] = request.obstacle();
    } else if (!known) {
      refuse(msg::CauseKind::CAUSE_UNKNOWN_NAME);
    } else if (request.kind() == msg::EditKind::EDIT_MOVE) {
      obstacles_[name].X_WO(request.X_WO());
    } else if (request.kind() == msg::EditKind::EDIT_ATTACH || request.kind() == msg::EditKind::EDIT_DETACH) {
      obstacles_[name].attached_to(request.kind() == msg::EditKind::EDIT_ATTACH ? request.arm() : "");
    } else {
      obstacles_.erase(name);
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
  bool silent_ = false;
  std::vector<msg::EditKind> edits_;
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
  void add_carried(const std::string& name, const std::string& arm) {
    ros2::SceneEdit edit = edit_of(ros2::SceneEdit::Kind::kAdd, name);
    edit.obstacle.shapes = {{world::Sphere{0.1}, world::Pose::Identity()}};
    edit.obstacle.attachment.emplace().arm = arm;
    order(edit);
  }
  /// Another client does it, and the worker can know it.
  void put(const std::string& name, double radius, const std::string& arm = {}) {
    world_.put(name, radius, arm);
    ASSERT_TRUE(eventually([&] {
      const auto scene = connection_->scene(kLong);
      if (!scene) return false;
      const auto shapes = scene->shapes.find(name);
      return shapes != scene->shapes.end() && shapes->second.obstacle().shapes().at(0).dimensions().x() == radius;
    }));
  }
  [[nodiscard]] bool eventually(const std::function<bool()>& condition) const {
    return connection_->wait_until(condition, kLong);
  }

  ObedientWorld world_{file_, cell_domain_.number()};
  ros2::SceneWorker worker_{connection_};
};

TEST_F(EditedCrate, IsReplacedWithoutAMomentInWhichTheCellLacksIt) {
  add(0.2);
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 2; })) << worker_.report().refusal.value_or("-");
  EXPECT_EQ(world_.radius("crate"), 0.2);
  using enum msg::EditKind;
  EXPECT_EQ(world_.edits(), (std::vector{EDIT_ADD, EDIT_ADD, EDIT_REPLACE})) << "no removal";
}

TEST_F(EditedCrate, StaysAsItWasWhenTheWorldRefusesItsNewForm) {
  world_.judge_by([](const msg::Obstacle& obstacle) { return obstacle.shapes().at(0).dimensions().x() < 0.15; });
  add(0.2);
  ASSERT_TRUE(eventually([&] { return worker_.report().refused == 1; }));
  EXPECT_EQ(*worker_.report().refusal, "object 'crate': refused by the test");
  EXPECT_EQ(world_.radius("crate"), 0.1);
}

TEST_F(EditedCrate, IsReplacedByTheNextSceneAfterAWorldThatDidNotAnswer) {
  world_.fall_silent();
  add(0.2);
  ASSERT_TRUE(eventually([&] { return worker_.report().refused == 1; })) << "the world does not answer";
  EXPECT_EQ(world_.radius("crate"), 0.1);
  world_.answer_again();
  add(0.3);
  EXPECT_TRUE(eventually([&] { return world_.radius("crate") == 0.3; }));
}

TEST_F(EditedCrate, IgnoresTheRemovalOfWhatAnArmCarries) {
  add_carried("part", "north");
  order(edit_of(ros2::SceneEdit::Kind::kRemove, "part"));
  order(edit_of(ros2::SceneEdit::Kind::kMove, "unknown"));
  ASSERT_TRUE(eventually([&] { return worker_.report().refused == 1; })) << "edits are carried out in their order";
  EXPECT_EQ(worker_.report().applied, 2U) << "the removal does not count";
  EXPECT_TRUE(world_.find("part"));
}

TEST_F(EditedCrate, IsRemovedWithAllThatScenesAddedAndNothingElse) {
  add(0.1, "ball");
  add(0.1, "box");
  add_carried("part", "north");
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 4; })) << worker_.report().refusal.value_or("-");
  put("table", 0.5);
  put("box", 0.3);
  add(0.4, "table");
  add(0.2, "ball");
  order(edit_of(ros2::SceneEdit::Kind::kRemoveAll, ""));
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 7; })) << worker_.report().refusal.value_or("-");
  EXPECT_FALSE(world_.find("crate"));
  EXPECT_FALSE(world_.find("ball"));
  EXPECT_EQ(world_.carrier("part"), "north") << "as in MoveIt, which has it no longer in its world";
  EXPECT_EQ(world_.radius("table"), 0.4) << "scenes only gave it another form";
  EXPECT_EQ(world_.radius("box"), 0.3) << "the one of another client took the place of the one of a scene";
  EXPECT_EQ(worker_.report().refused, 0U);
}

TEST_F(EditedCrate, StaysUntilEveryArmThatShowsItHasRemovedAll) {
  const auto from = [](const std::string& arm, ros2::SceneEdit edit) {
    edit.source = arm;
    return edit;
  };
  ros2::SceneEdit shown = edit_of(ros2::SceneEdit::Kind::kAdd, "shown");
  shown.obstacle.shapes = {{world::Sphere{0.1}, world::Pose::Identity()}};
  order(from("north", shown));
  order(from("west", shown));
  const ros2::SceneEdit clear = edit_of(ros2::SceneEdit::Kind::kRemoveAll, "");
  order(from("north", clear));
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 4; })) << worker_.report().refusal.value_or("-");
  EXPECT_TRUE(world_.find("shown")) << "west shows it, too";
  order(from("west", clear));
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 5; })) << worker_.report().refusal.value_or("-");
  EXPECT_FALSE(world_.find("shown"));
  EXPECT_TRUE(world_.find("crate")) << "it came on the topic of the cell";
}

TEST_F(EditedCrate, IsReleasedWithAllThatScenesAttached) {
  ros2::SceneEdit attach = edit_of(ros2::SceneEdit::Kind::kAttach, "crate");
  attach.arm = "east";
  order(attach);
  add_carried("part", "north");
  put("tray", 0.1, "north");
  ros2::SceneEdit release = edit_of(ros2::SceneEdit::Kind::kDetachAll, "");
  release.arm = "north";
  order(release);
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 4; })) << worker_.report().refusal.value_or("-");
  EXPECT_EQ(world_.carrier("part"), "");
  EXPECT_EQ(world_.carrier("crate"), "east");
  EXPECT_EQ(world_.carrier("tray"), "north") << "another client attached it";
  order(edit_of(ros2::SceneEdit::Kind::kDetachAll, ""));
  ASSERT_TRUE(eventually([&] { return worker_.report().applied == 5; })) << worker_.report().refusal.value_or("-");
  EXPECT_EQ(world_.carrier("crate"), "");
  EXPECT_EQ(world_.carrier("tray"), "north");
}

}  // namespace
}  // namespace hecaton::test
