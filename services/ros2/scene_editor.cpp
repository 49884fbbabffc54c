#include "services/ros2/scene_editor.hpp"

#include <optional>
#include <utility>

#include "services/messages/convert.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {
namespace {

/// Poses of links older than this say nothing about where an object is.
constexpr std::chrono::seconds kStateLimit{1};
constexpr std::chrono::seconds kRestorePeriod{1};  // between attempts to add missing obstacles

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
  const auto arrived = [this] { return !scenes_.empty(); };
  auto next_attempt = bus::Clock::now();
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (missing_.empty()) {
      arrived_.wait(lock, stop, arrived);
    } else {
      arrived_.wait_until(lock, stop, next_attempt, arrived);
    }
    if (arrived()) {
      const SceneEdits scene = std::move(scenes_.front());
      scenes_.pop_front();
      // MoveIt sends many scenes without objects, which say nothing of the refused one.
      if (!scene.edits.empty()) report_.refusal.reset();
      lock.unlock();
      carry_out(scene, stop);
      lock.lock();
      waiting_ -= parts_of(scene);
    }
    if (missing_.empty() || bus::Clock::now() < next_attempt) continue;
    lock.unlock();
    restore_missing(stop);
    lock.lock();
    next_attempt = bus::Clock::now() + kRestorePeriod;
  }
}

void SceneWorker::carry_out(const SceneEdits& scene, const std::stop_token& stop) {
  for (const SceneRefusal& refusal : scene.refusals) refuse(refusal);
  for (const SceneEdit& edit : scene.edits) {
    const std::string& name = edit.obstacle.name;
    try {
      apply(edit, {kAnswerLimit, stop});
      services::log_info("planning scene applied", {{"object", name}});
      const std::scoped_lock counted(mutex_);
      ++report_.applied;
    } catch (const Error& error) {
      if (const auto missing = missing_.find(name); missing != missing_.end()) missing->second.reason = error.what();
      refuse({name, error.what()});
    }
    report_missing();
  }
}

void SceneWorker::restore_missing(const std::stop_token& stop) {
  std::vector<std::string> names;
  for (const auto& [name, missing] : missing_) names.push_back(name);
  try {
    for (const std::string& name : names) {
      const auto refusal = add_missing(name, {kAnswerLimit, stop});
      if (const auto missing = missing_.find(name); missing != missing_.end()) missing->second.reason = *refusal;
    }
  } catch (const Error& error) {
    for (auto& [name, missing] : missing_) missing.reason = error.what();
  }
  report_missing();
}

void SceneWorker::report_missing() {
  constexpr std::size_t kMostNamed = 3;
  std::string names;
  std::size_t named = 0;
  for (const auto& [name, missing] : missing_) {
    if (reported_missing_.insert(name).second) {
      services::log_error("obstacle missing: it is added again each second until the world has it",
                          {{"object", name}, {"reason", missing.reason}});
    }
    if (++named <= kMostNamed) names += (named > 1 ? ", '" : "'") + name + "'";
  }
  std::erase_if(reported_missing_, [this](const std::string& name) {
    if (missing_.contains(name)) return false;
    services::log_info("obstacle not missing any more", {{"object", name}});
    return true;
  });
  std::optional<std::string> text;
  if (named > kMostNamed) names += " and " + std::to_string(named - kMostNamed) + " more";
  if (named > 0) {
    text = "the cell lacks " + names +
           ", from which arms keep no distance until the world service adds it: " + missing_.begin()->second.reason;
  }
  const std::scoped_lock lock(mutex_);
  report_.missing = std::move(text);
}

void SceneWorker::refuse(const SceneRefusal& refusal) {
  services::log_warning("planning scene not applied", {{"object", refusal.object}, {"reason", refusal.reason}});
  const std::scoped_lock lock(mutex_);
  ++report_.refused;
  report_.refusal = (refusal.object.empty() ? "" : "object '" + refusal.object + "': ") + refusal.reason;
}

void SceneWorker::require(const msg::WorldEditReply& reply) const {
  if (!reply.done()) throw Error(reply.cause().text());
}

msg::WorldEditReply SceneWorker::request(msg::EditKind kind, const SceneEdit& edit, const Wait& wait) {
  msg::WorldEditRequest request;
  request.kind(kind);
  request.name(edit.obstacle.name);
  request.X_WO(messages::to_message(edit.obstacle.X_WO));
  request.arm(edit.arm);
  return connection_->edit(std::move(request), wait);
}

msg::WorldEditReply SceneWorker::add_obstacle(const world::Obstacle& obstacle, const Wait& wait) {
  msg::WorldEditRequest request;
  request.kind(msg::EditKind::EDIT_ADD);
  request.name(obstacle.name);
  request.obstacle(messages::to_message(obstacle));
  msg::WorldEditReply reply = connection_->edit(std::move(request), wait);
  if (reply.done()) editions_[obstacle.name] = reply.edition();
  if (reply.done() || reply.cause().kind() == msg::CauseKind::CAUSE_NAME_TAKEN) missing_.erase(obstacle.name);
  return reply;
}

std::optional<std::string> SceneWorker::add_missing(const std::string& obstacle, const Wait& wait) {
  std::optional<std::string> refusal;
  const std::vector<world::Obstacle> versions = missing_.at(obstacle).versions;  // add_obstacle() may remove them
  for (const world::Obstacle& version : versions) {
    std::optional<std::string> why;
    try {
      const msg::WorldEditReply reply = add_obstacle(version, wait);
      if (!reply.done()) why = reply.cause().text();
    } catch (const InvalidArgument& error) {
      why = error.what();  // too large for a message
    }
    if (!refusal) refusal = why;
    if (!missing_.contains(obstacle)) break;
  }
  return refusal;
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

bool SceneWorker::is_carried(const std::string& obstacle, const Wait& wait) {
  const auto scene = scene_with(obstacle, wait);
  const auto shapes = scene.shapes.find(obstacle);
  return shapes != scene.shapes.end() && !shapes->second.obstacle().attached_to().empty();
}

void SceneWorker::apply(const SceneEdit& edit, const Wait& wait) {
  if (!missing_.contains(edit.obstacle.name) || apply_to_missing(edit, wait)) apply_to_known(edit, wait);
}

bool SceneWorker::apply_to_missing(const SceneEdit& edit, const Wait& wait) {
  using Kind = SceneEdit::Kind;
  const std::string& name = edit.obstacle.name;
  std::vector<world::Obstacle>& versions = missing_.at(name).versions;
  switch (edit.kind) {
    case Kind::kAdd:
      // What the cell had comes last, whatever was ordered since.
      versions = {edit.obstacle, versions.back()};
      return true;
    case Kind::kRemove: {
      if (versions.front().attachment) return false;  // as apply_to_known() of a carried one
      missing_.erase(name);
      // An addition without an answer may have been carried out.
      const msg::WorldEditReply reply = request(msg::EditKind::EDIT_REMOVE, edit, wait);
      editions_.erase(name);
      if (reply.cause().kind() != msg::CauseKind::CAUSE_UNKNOWN_NAME) require(reply);
      return false;
    }
    case Kind::kMove:
      for (world::Obstacle& version : versions) {
        if (!version.attachment) version.X_WO = edit.obstacle.X_WO;
      }
      break;
    case Kind::kAppend:
    case Kind::kAttach:
    case Kind::kDetach:
      break;
  }
  const auto refusal = add_missing(name, wait);
  if (missing_.contains(name)) throw Error("the world lacks the obstacle, which is added again first: " + *refusal);
  return true;
}

void SceneWorker::apply_to_known(const SceneEdit& edit, const Wait& wait) {
  using Kind = SceneEdit::Kind;
  switch (edit.kind) {
    case Kind::kMove:
      return require(request(msg::EditKind::EDIT_MOVE, edit, wait));
    case Kind::kRemove: {
      // In MoveIt a carried object is none of the world: a message that attaches it also removes it there.
      if (is_carried(edit.obstacle.name, wait)) return;
      const msg::WorldEditReply reply = request(msg::EditKind::EDIT_REMOVE, edit, wait);
      editions_.erase(edit.obstacle.name);
      return require(reply);
    }
    case Kind::kAttach:
    case Kind::kDetach: {
      const bool attach = edit.kind == Kind::kAttach;
      const auto reply = request(attach ? msg::EditKind::EDIT_ATTACH : msg::EditKind::EDIT_DETACH, edit, wait);
      if (reply.done()) editions_[edit.obstacle.name] = reply.edition();
      return require(reply);
    }
    case Kind::kAdd:
    case Kind::kAppend:
      return add_or_replace(edit, wait);
  }
}

void SceneWorker::add_or_replace(const SceneEdit& edit, const Wait& wait) {
  const msg::WorldEditReply reply = add_obstacle(edit.obstacle, wait);
  if (reply.done() || reply.cause().kind() != msg::CauseKind::CAUSE_NAME_TAKEN) {
    if (missing_.contains(edit.obstacle.name)) static_cast<void>(add_missing(edit.obstacle.name, wait));
    return require(reply);
  }
  const auto scene = scene_with(edit.obstacle.name, wait);
  const auto old = scene.shapes.find(edit.obstacle.name);
  if (old == scene.shapes.end()) return require(reply);  // the name of an arm
  std::optional<world::Pose> X_WO;
  for (const msg::ObstacleState& state : scene.states.value.states()) {
    if (state.name() != edit.obstacle.name) continue;
    if (const auto pose = messages::from_message(state.X_WO(), state.name())) X_WO = *pose;
  }
  if (!X_WO) throw Error("the pose of the obstacle with this id is not known yet; send it again");
  world::Obstacle next = edit.obstacle;
  if (edit.kind == SceneEdit::Kind::kAppend) {
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
  replace(old->second, *X_WO, std::move(next), wait);
}

void SceneWorker::replace(const msg::ObstacleShapes& old, const world::Pose& X_WO, world::Obstacle next,
                          const Wait& wait) {
  const msg::Obstacle& before = old.obstacle();
  if (before.motion().kind() != msg::MotionKind::MOTION_STATIC) {
    throw Error("the obstacle with this id moves by itself; remove it first");
  }
  SceneEdit edit{SceneEdit::Kind::kMove, next};
  // Without a moment in which the cell lacks the obstacle.
  const bool same = messages::to_message(next).shapes() == before.shapes();
  if (same && !next.attachment && before.attached_to().empty()) {
    return require(request(msg::EditKind::EDIT_MOVE, edit, wait));
  }
  const auto known = messages::from_message(before);
  if (same && known && is_same(next.attachment, known.value->attachment)) return;  // MoveIt repeats what an arm carries
  // The obstacle may be missing from here on, also when the world gives no answer.
  Missing missing{{std::move(next)}, {}};
  if (known) {
    missing.versions.push_back(*known);
    missing.versions.back().X_WO = X_WO;
  }
  const std::string name = edit.obstacle.name;
  missing_.insert_or_assign(name, std::move(missing));
  const msg::WorldEditReply removed = request(msg::EditKind::EDIT_REMOVE, edit, wait);
  if (!removed.done()) missing_.erase(name);
  require(removed);
  if (const auto refusal = add_missing(name, wait)) throw Error(*refusal);
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
    topic.scenes.take_each(
        [&](const PlanningScene& scene) { worker_.add(edits_of(scene, frames_of(view, now, topic.arm))); });
  }
}

NodeEndpoints SceneTopics::endpoints() const {
  NodeEndpoints endpoints;
  endpoints.readers.push_back(cell_.id());
  for (const ArmTopic& topic : arms_) endpoints.readers.push_back(topic.scenes.id());
  return endpoints;
}

}  // namespace hecaton::ros2
