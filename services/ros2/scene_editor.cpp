#include "services/ros2/scene_editor.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "services/client/convert.hpp"
#include "services/messages/convert.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {
namespace {

/// Poses of links older than this say nothing about where an object is.
constexpr std::chrono::seconds kStateLimit{1};

SceneFrames frames_of(const CellView& view, bus::Clock::time_point now, std::optional<std::size_t> own) {
  SceneFrames frames;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const ArmSnapshot arm = view.arm(i);
    if (arm.kinematics == nullptr || now - arm.state->received > kStateLimit) continue;
    if (own == i) add_frames(frames, *arm.arm, *arm.kinematics, "");
    add_frames(frames, *arm.arm, *arm.kinematics, prefixed(arm.arm->name, ""));
  }
  frames.insert_or_assign(kWorldFrame, SceneFrame{});
  return frames;
}

/// Carried by the same arm at the same place of its tool, but for what rounding and measured joints change.
bool is_same(const std::optional<world::Attachment>& one, const std::optional<world::Attachment>& other) {
  constexpr double kPlace = 1e-4;  // [m, rad]
  return one && other && one->arm == other->arm &&
         (one->X_TO.translation() - other->X_TO.translation()).norm() < kPlace &&
         Eigen::AngleAxisd(one->X_TO.linear().transpose() * other->X_TO.linear()).angle() < kPlace;
}

/// Equal but for what rounding changes in a rotation on its way through the world service.
bool is_alike(const std::vector<msg::PlacedShape>& some, const std::vector<msg::PlacedShape>& others) {
  static constexpr double kRounding = 1e-9;
  return std::equal(some.begin(), some.end(), others.begin(), others.end(),
                    [](msg::PlacedShape one, const msg::PlacedShape& other) {
                      const auto X_OS = messages::from_message(one.X_OS(), "");
                      const auto X_OS_other = messages::from_message(other.X_OS(), "");
                      if (!X_OS || !X_OS_other || !X_OS->isApprox(*X_OS_other, kRounding)) return false;
                      one.X_OS(other.X_OS());
                      return one == other;
                    });
}

SceneEdit edit_of_name(SceneEdit::Kind kind, const std::string& obstacle, const std::string& arm = {}) {
  SceneEdit edit{kind, {}, arm};
  edit.obstacle.name = obstacle;
  return edit;
}

/// What the memory of a scene grows with. A scene without objects counts, too.
std::size_t parts_of(const SceneEdits& scene) {
  std::size_t parts = 1 + scene.refusals.size();
  for (const SceneEdit& edit : scene.edits) parts += 1 + edit.obstacle.shapes.size();
  return parts;
}

}  // namespace

SceneWorker::SceneWorker(std::shared_ptr<client::Connection> connection)
    : connection_(std::move(connection)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

OrderReport SceneWorker::report() const {
  const std::scoped_lock lock(mutex_);
  return report_;
}

void SceneWorker::add(SceneEdits scene) {
  const std::size_t parts = parts_of(scene);
  std::size_t waiting = 0;
  {
    const std::scoped_lock lock(mutex_);
    waiting = waiting_;
    if (waiting + parts <= kMostWaiting) {
      waiting_ += parts;
      scenes_.push_back(std::move(scene));
      arrived_.notify_one();
      return;
    }
  }
  refuse({"", "its " + std::to_string(parts) + " objects and shapes are dropped: " + std::to_string(waiting) +
                  " wait already, and at most " + std::to_string(kMostWaiting) + " may; send fewer at a time"});
}

void SceneWorker::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (arrived_.wait(lock, stop, [this] { return !scenes_.empty(); })) {
    const SceneEdits scene = std::move(scenes_.front());
    scenes_.pop_front();
    // MoveIt sends many scenes without objects, which say nothing of the refused one.
    if (!scene.edits.empty()) report_.refusal.reset();
    lock.unlock();
    carry_out(scene, stop);
    lock.lock();
    waiting_ -= parts_of(scene);
  }
}

void SceneWorker::carry_out(const SceneEdits& scene, const std::stop_token& stop) {
  for (const SceneRefusal& refusal : scene.refusals) refuse(refusal);
  for (const SceneEdit& edit : scene.edits) {
    try {
      const std::string ignored = apply(edit, {kAnswerLimit, stop});
      const std::string object = edit.obstacle.name.empty() ? "all" : edit.obstacle.name;
      if (!ignored.empty()) {
        services::log_info("planning scene ignored", {{"object", object}, {"reason", ignored}});
        continue;
      }
      services::log_info("planning scene applied", {{"object", object}});
      const std::scoped_lock counted(mutex_);
      ++report_.applied;
    } catch (const Error& error) {
      refuse({edit.obstacle.name, error.what()});
    }
  }
}

void SceneWorker::refuse(const SceneRefusal& refusal) {
  services::log_warning("planning scene not applied", {{"object", refusal.object}, {"reason", refusal.reason}});
  const std::scoped_lock lock(mutex_);
  ++report_.refused;
  report_.refusal = (refusal.object.empty() ? "" : "object '" + refusal.object + "': ") + refusal.reason;
}

void SceneWorker::require(const msg::WorldEditReply& reply) const {
  if (!reply.done()) throw Rejected(client::to_public(reply.cause()));
}

msg::WorldEditReply SceneWorker::request(msg::EditKind kind, const SceneEdit& edit, const Wait& wait) {
  msg::WorldEditRequest request;
  request.kind(kind);
  request.name(edit.obstacle.name);
  request.X_WO(messages::to_message(edit.obstacle.X_WO));
  request.arm(edit.arm);
  return connection_->edit(std::move(request), wait);
}

msg::WorldEditReply SceneWorker::put(msg::EditKind kind, const world::Obstacle& obstacle, const Wait& wait) {
  msg::WorldEditRequest request;
  request.kind(kind);
  request.name(obstacle.name);
  request.obstacle(messages::to_message(obstacle));
  msg::WorldEditReply reply = connection_->edit(std::move(request), wait);
  if (reply.done()) editions_[obstacle.name] = reply.edition();
  return reply;
}

// The world service publishes the shapes before it replies, but the two topics have no common order.
client::Connection::Scene SceneWorker::scene_with(const std::string& obstacle, const Wait& wait) {
  auto scene = connection_->scene(wait);
  const auto edited = editions_.find(obstacle);
  const auto current = [&] {
    scene = connection_->scene(wait);
    if (!scene) return false;
    const auto shapes = scene->shapes.find(obstacle);
    return shapes != scene->shapes.end() && shapes->second.edition() >= edited->second;
  };
  const bool found = edited == editions_.end() ? scene.has_value() : connection_->wait_until(current, wait);
  if (found) return *scene;
  editions_.erase(obstacle);
  throw Error("the world service sends no obstacles");
}

client::Connection::Scene SceneWorker::scene_after_edits(const Wait& wait) {
  std::optional<client::Connection::Scene> scene;
  const auto current = [&] {
    scene = connection_->scene(wait);
    if (!scene) return false;
    const msg::ObstacleStates& states = scene->states.value;
    for (const auto& [name, edition] : editions_) {
      if (states.edition() < edition) return false;
    }
    return std::all_of(states.states().begin(), states.states().end(), [&](const msg::ObstacleState& state) {
      const auto shapes = scene->shapes.find(state.name());
      const auto edited = editions_.find(state.name());
      if (edited == editions_.end()) return shapes != scene->shapes.end() || !added_.contains(state.name());
      return shapes != scene->shapes.end() && shapes->second.edition() >= edited->second;
    });
  };
  if (connection_->wait_until(current, wait)) return *scene;
  editions_.clear();
  throw Error("the world service sends no obstacles");
}

bool SceneWorker::is_added(const std::string& obstacle, const msg::ObstacleShapes& shapes) const {
  const auto added = added_.find(obstacle);
  return added != added_.end() && is_alike(added->second.shapes, shapes.obstacle().shapes());
}

void SceneWorker::note_attachment(const SceneEdit& edit) {
  const std::string& name = edit.obstacle.name;
  if (edit.obstacle.attachment) {
    attached_[name] = edit.obstacle.attachment->arm;
  } else if (edit.kind == SceneEdit::Kind::kAttach) {
    attached_[name] = edit.arm;
  } else if (edit.kind != SceneEdit::Kind::kAppend) {
    attached_.erase(name);
  }
}

bool SceneWorker::is_carried(const std::string& obstacle, const Wait& wait) {
  const auto scene = scene_with(obstacle, wait);
  const auto shapes = scene.shapes.find(obstacle);
  return shapes != scene.shapes.end() && !shapes->second.obstacle().attached_to().empty();
}

// In MoveIt a carried object is none of the world: a message that attaches it also removes it there.
std::string SceneWorker::apply(const SceneEdit& edit, const Wait& wait) {
  if (edit.kind == SceneEdit::Kind::kRemove && is_carried(edit.obstacle.name, wait)) {
    return "an arm carries it; remove the attached object first";
  }
  carry_out(edit, wait);
  return {};
}

void SceneWorker::carry_out(const SceneEdit& edit, const Wait& wait) {
  using Kind = SceneEdit::Kind;
  switch (edit.kind) {
    case Kind::kMove:
      return require(request(msg::EditKind::EDIT_MOVE, edit, wait));
    case Kind::kRemove: {
      const msg::WorldEditReply reply = request(msg::EditKind::EDIT_REMOVE, edit, wait);
      editions_.erase(edit.obstacle.name);
      require(reply);
      added_.erase(edit.obstacle.name);
      attached_.erase(edit.obstacle.name);
      return;
    }
    case Kind::kAttach:
    case Kind::kDetach: {
      const bool attach = edit.kind == Kind::kAttach;
      const auto reply = request(attach ? msg::EditKind::EDIT_ATTACH : msg::EditKind::EDIT_DETACH, edit, wait);
      require(reply);
      editions_[edit.obstacle.name] = reply.edition();
      return note_attachment(edit);
    }
    case Kind::kAdd:
    case Kind::kAppend:
      return add_or_replace(edit, wait);
    case Kind::kRemoveAll:
      return remove_all(edit.source, wait);
    case Kind::kDetachAll:
      return detach_all(edit.arm, wait);
  }
}

// Obstacles of the cell file and of other clients stay, and so does what scenes of another arm's topic show, too.
void SceneWorker::remove_all(const std::string& source, const Wait& wait) {
  if (added_.empty()) return;
  const auto scene = scene_after_edits(wait);
  std::erase_if(added_, [&](const auto& added) {
    const auto shapes = scene.shapes.find(added.first);
    return shapes == scene.shapes.end() || !is_added(added.first, shapes->second);
  });
  std::vector<SceneEdit> edits;
  for (auto& [name, added] : added_) {
    const bool meant = source.empty() || added.sources.contains(source);
    if (!meant || !scene.shapes.at(name).obstacle().attached_to().empty()) continue;
    if (source.empty() || added.sources.size() == 1) {
      edits.push_back(edit_of_name(SceneEdit::Kind::kRemove, name));
    } else {
      added.sources.erase(source);
    }
  }
  carry_out_each(edits, wait);
}

void SceneWorker::detach_all(const std::string& arm, const Wait& wait) {
  if (attached_.empty()) return;
  const auto scene = scene_after_edits(wait);
  std::erase_if(attached_, [&](const auto& attached) {
    const auto shapes = scene.shapes.find(attached.first);
    return shapes == scene.shapes.end() || shapes->second.obstacle().attached_to() != attached.second;
  });
  std::vector<SceneEdit> edits;
  for (const auto& [name, carrier] : attached_) {
    if (arm.empty() || carrier == arm) edits.push_back(edit_of_name(SceneEdit::Kind::kDetach, name, carrier));
  }
  carry_out_each(edits, wait);
}

// What another client has changed meanwhile delays no further edit.
void SceneWorker::carry_out_each(const std::vector<SceneEdit>& edits, const Wait& wait) {
  std::optional<Rejected> rejected;
  for (const SceneEdit& edit : edits) {
    try {
      carry_out(edit, wait);
    } catch (const Rejected& error) {
      if (error.cause().kind != CauseKind::kUnknownName) rejected = error;
    }
  }
  if (rejected) throw Rejected(*rejected);
}

void SceneWorker::add_or_replace(const SceneEdit& edit, const Wait& wait) {
  const std::string& name = edit.obstacle.name;
  // Known before it is sent: the world may carry out an edit whose reply is lost.
  const Added added{{edit.source}, messages::to_message(edit.obstacle).shapes()};
  const bool first = added_.try_emplace(name, added).second;
  const msg::WorldEditReply reply = put(msg::EditKind::EDIT_ADD, edit.obstacle, wait);
  if (reply.done()) {
    added_[name] = added;
    return note_attachment(edit);
  }
  if (first) added_.erase(name);
  if (reply.cause().kind() != msg::CauseKind::CAUSE_NAME_TAKEN) return require(reply);
  const auto scene = scene_with(name, wait);
  const auto old = scene.shapes.find(name);
  if (old == scene.shapes.end()) return require(reply);  // the name of an arm
  if (!is_added(name, old->second)) added_.erase(name);
  world::Obstacle next = edit.obstacle;
  if (edit.kind == SceneEdit::Kind::kAppend) {
    std::optional<world::Pose> X_WO;
    for (const msg::ObstacleState& state : scene.states.value.states()) {
      if (state.name() != edit.obstacle.name) continue;
      if (const auto pose = messages::from_message(state.X_WO(), state.name())) X_WO = *pose;
    }
    if (!X_WO) throw Error("the pose of the obstacle with this id is not known yet; send it again");
    const auto known = messages::from_message(old->second.obstacle());
    if (!known) throw Error(known.error);
    std::vector<world::PlacedShape> shapes = known->shapes;
    for (world::PlacedShape shape : next.shapes) {
      shape.X_BS = X_WO->inverse() * next.X_WO * shape.X_BS;
      shapes.push_back(std::move(shape));
    }
    next.shapes = std::move(shapes);
    next.X_WO = *X_WO;
    next.attachment = known->attachment;
  }
  replace(old->second, next, wait);
  note_attachment(edit);
  const auto ours = added_.find(name);
  if (ours == added_.end()) return;
  ours->second.sources.insert(edit.source);
  ours->second.shapes = messages::to_message(next).shapes();
}

void SceneWorker::replace(const msg::ObstacleShapes& old, const world::Obstacle& next, const Wait& wait) {
  const msg::Obstacle& before = old.obstacle();
  if (before.motion().kind() != msg::MotionKind::MOTION_STATIC) {
    throw Error("the obstacle with this id moves by itself; remove it first");
  }
  const bool same = is_alike(messages::to_message(next).shapes(), before.shapes());
  if (same && !next.attachment && before.attached_to().empty()) {
    return require(request(msg::EditKind::EDIT_MOVE, {SceneEdit::Kind::kMove, next}, wait));
  }
  const auto known = messages::from_message(before);
  if (same && known && is_same(next.attachment, known.value->attachment)) return;  // MoveIt repeats what an arm carries
  require(put(msg::EditKind::EDIT_REPLACE, next, wait));
}

SceneTopics::SceneTopics(bus::Participant& participant, const config::CellFile& file,
                         std::shared_ptr<client::Connection> connection, bus::Mailbox& mailbox)
    : worker_(std::move(connection)),
      cell_(participant, file.ros2->ns + "/planning_scene", type::kPlanningScene, mailbox) {
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string topic = file.ros2->ns + "/" + file.cell.arms[i].arm.name + "/planning_scene";
    arms_.push_back({i, Subscription<PlanningScene>(participant, topic, type::kPlanningScene, mailbox)});
  }
}

void SceneTopics::update(const CellView& view, bus::Clock::time_point now) {
  cell_.take_each(
      [&](const PlanningScene& scene) { worker_.add(edits_of(scene, frames_of(view, now, std::nullopt))); });
  for (ArmTopic& topic : arms_) {
    topic.scenes.take_each([&](const PlanningScene& scene) {
      worker_.add(of_topic(edits_of(scene, frames_of(view, now, topic.arm)), view.arm(topic.arm).arm->name));
    });
  }
}

OrderReport SceneTopics::report() const {
  OrderReport report = worker_.report();
  report.unreadable = cell_.unreadable();
  for (const ArmTopic& topic : arms_) report.unreadable += topic.scenes.unreadable();
  return report;
}

NodeEndpoints SceneTopics::endpoints() const {
  NodeEndpoints endpoints;
  endpoints.readers.push_back(cell_.id());
  for (const ArmTopic& topic : arms_) endpoints.readers.push_back(topic.scenes.id());
  return endpoints;
}

}  // namespace hecaton::ros2
