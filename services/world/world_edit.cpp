#include "services/world/world_edit.hpp"

#include <algorithm>

#include "planner/model/kinematics.hpp"
#include "services/config/obstacle_rules.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::services {
namespace {

world::EditResult refused(const std::string& obstacle, std::string reason,
                          world::EditRefusal refusal = world::EditRefusal::kInvalidValue) {
  return {refusal, obstacle, std::move(reason)};
}

std::string about(const std::string& obstacle, const std::string& sentence) {
  return "obstacle '" + obstacle + "': " + sentence;
}

/// A refusal when the obstacle at X_WO would overlap an arm; otherwise empty.
std::optional<world::EditResult> refuse_place(const world::BulletWorld& world, const EditedCell& cell,
                                              const world::Obstacle& obstacle, const world::Pose& X_WO) {
  const std::string overlap = config::overlap_with_arms(cell.arms, cell.q, world.obstacles(), obstacle, X_WO);
  if (overlap.empty()) return std::nullopt;
  return refused(obstacle.name, about(obstacle.name, "pose must be clear of the arms, but " + overlap),
                 world::EditRefusal::kNotNow);
}

/// `replace`: an obstacle with this name gives up its place.
world::EditResult add(world::BulletWorld& world, const EditedCell& cell, const msg::Obstacle& message, bool replace) {
  const auto obstacle = messages::from_message(message);
  if (!obstacle) return refused(message.name(), obstacle.error);
  if (const auto complaint = config::complain(*obstacle))
    return refused(obstacle->name, about(obstacle->name, complaint->sentence()));
  std::vector<std::string> arms;
  for (const planner::PlannedArm& planned : cell.arms) arms.push_back(planned.arm.name);
  std::vector<std::string> others;
  for (const world::Obstacle& other : world.obstacles()) {
    if (!replace || other.name != obstacle->name) others.push_back(other.name);
  }
  if (const auto complaint = config::complain_about_name(obstacle->name, arms, others)) {
    return refused(obstacle->name, about(obstacle->name, complaint->sentence()), world::EditRefusal::kNameTaken);
  }
  if (others.size() >= config::kMostObstacles) {
    return refused(obstacle->name,
                   "the cell has " + std::to_string(others.size()) + " obstacles, the most that it may have",
                   world::EditRefusal::kNotNow);
  }
  if (!obstacle->attachment) {
    const world::Pose X_WO = world::motion_at(*obstacle, world.time()).X_WO;
    if (const auto refusal = refuse_place(world, cell, *obstacle, X_WO)) return *refusal;
  }
  return replace && world.find(obstacle->name) != nullptr ? world.replace(*obstacle) : world.add(*obstacle);
}

world::EditResult move(world::BulletWorld& world, const EditedCell& cell, const msg::WorldEditRequest& request) {
  const auto X_WO = messages::from_message(request.X_WO(), "obstacle \"" + request.name() + "\": X_WO");
  if (!X_WO) return refused(request.name(), X_WO.error);
  if (const auto complaint = config::complain(*X_WO, "pose")) {
    return refused(request.name(), about(request.name(), complaint->sentence()));
  }
  const world::Obstacle* obstacle = world.find(request.name());
  if (obstacle != nullptr && !obstacle->attachment) {
    if (const auto refusal = refuse_place(world, cell, *obstacle, *X_WO)) return *refusal;
  }
  return world.move(request.name(), *X_WO);
}

/// The tool frame X_WT of the arm; empty when the cell has no such arm or its state is unknown.
std::optional<world::Pose> tool_of(const EditedCell& cell, const std::string& name) {
  for (std::size_t i = 0; i < cell.arms.size(); ++i) {
    const planner::Arm& arm = cell.arms[i].arm;
    if (arm.name != name || !cell.q[i]) continue;
    planner::Kinematics kinematics;
    planner::forward_kinematics(*arm.model, arm.X_WB, *cell.q[i], kinematics);
    return kinematics.X_WT;
  }
  return std::nullopt;
}

world::EditResult attach(world::BulletWorld& world, const EditedCell& cell, const msg::WorldEditRequest& request) {
  const world::Obstacle* obstacle = world.find(request.name());
  const auto X_WT = tool_of(cell, request.arm());
  if (obstacle != nullptr && !obstacle->attachment && X_WT) {
    const auto index = static_cast<std::size_t>(obstacle - world.obstacles().data());
    world::Obstacle carried = *obstacle;
    carried.attachment = {request.arm(), X_WT->inverse() * world.snapshot().states[index].X_WO};
    if (world::is_scripted(carried.motion)) carried.motion = world::StaticMotion{};  // attaching ends a scripted motion
    if (const auto complaint = config::complain(carried))
      return refused(carried.name, about(carried.name, complaint->sentence()), world::EditRefusal::kNotNow);
  }
  return world.attach(request.name(), request.arm());
}

/// Refuses a request with an arm when another arm carries the obstacle.
world::EditResult detach(world::BulletWorld& world, const msg::WorldEditRequest& request) {
  const world::Obstacle* obstacle = world.find(request.name());
  const bool names_arm = !request.arm().empty();
  if (names_arm && obstacle != nullptr && obstacle->attachment && obstacle->attachment->arm != request.arm()) {
    return refused(request.name(), "obstacle '" + request.name() + "' is attached to '" + obstacle->attachment->arm +
                                       "', not to '" + request.arm() + "'");
  }
  return world.detach(request.name());
}

}  // namespace

msg::Cause cause_of(const world::EditResult& result) {
  switch (result.refusal) {
    case world::EditRefusal::kNone:
      return {};
    case world::EditRefusal::kUnknownName:
      return make_cause(msg::CauseKind::CAUSE_UNKNOWN_NAME, result.subject, result.reason);
    case world::EditRefusal::kNameTaken:
      return make_cause(msg::CauseKind::CAUSE_NAME_TAKEN, result.subject, result.reason);
    case world::EditRefusal::kInvalidValue:
      return make_cause(msg::CauseKind::CAUSE_INVALID_VALUE, result.subject, result.reason);
    case world::EditRefusal::kNotNow:
      break;
  }
  return make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, result.subject, result.reason);
}

const std::string& edited_name(const msg::WorldEditRequest& request) {
  const bool carries_obstacle =
      request.kind() == msg::EditKind::EDIT_ADD || request.kind() == msg::EditKind::EDIT_REPLACE;
  return carries_obstacle ? request.obstacle().name() : request.name();
}

world::EditResult apply_edit(world::BulletWorld& world, const EditedCell& cell, const msg::WorldEditRequest& request) {
  switch (request.kind()) {
    case msg::EditKind::EDIT_ADD:
      return add(world, cell, request.obstacle(), false);
    case msg::EditKind::EDIT_REPLACE:
      return add(world, cell, request.obstacle(), true);
    case msg::EditKind::EDIT_MOVE:
      return move(world, cell, request);
    case msg::EditKind::EDIT_REMOVE:
      return world.remove(request.name());
    case msg::EditKind::EDIT_ATTACH:
      return attach(world, cell, request);
    case msg::EditKind::EDIT_DETACH:
      return detach(world, request);
  }
  return refused(request.name(), "edit: unknown kind");
}

std::vector<msg::WorldEditReply> EditReplies::take(const CheckpointWriter& writer) {
  std::vector<msg::WorldEditReply> ready;
  while (!waiting_.empty()) {
    const CheckpointWriter::Outcome outcome = writer.outcome(waiting_.front().first);
    if (!outcome.known) break;
    ready.push_back(std::move(waiting_.front().second));
    waiting_.pop_front();
    if (outcome.failure) ready.back().cause(not_persisted("the edit is ", *outcome.failure));
  }
  return ready;
}

bool TakenRequests::take(const msg::WorldEditRequest& request) {
  constexpr std::size_t kMost = 1000;
  if (request.request_id() == 0) return true;
  std::pair<std::string, std::uint64_t> key{request.client(), request.request_id()};
  if (std::find(taken_.rbegin(), taken_.rend(), key) != taken_.rend()) return false;
  taken_.push_back(std::move(key));
  if (taken_.size() > kMost) taken_.pop_front();
  return true;
}

std::optional<msg::WorldEditRequest> edit_of(const world::BulletWorld& world, const msg::ToolState& state) {
  msg::WorldEditRequest request;
  request.client("driver/" + state.arm());
  request.arm(state.arm());
  const auto carries = [&](const std::string& name) {
    const world::Obstacle* obstacle = world.find(name);
    return obstacle != nullptr && obstacle->attachment && obstacle->attachment->arm == state.arm();
  };
  if (!state.releasing().empty() && carries(state.releasing())) {
    request.kind(msg::EditKind::EDIT_DETACH);
    request.name(state.releasing());
    return request;
  }
  if (!state.grasping().empty() && !carries(state.grasping())) {
    request.kind(msg::EditKind::EDIT_ATTACH);
    request.name(state.grasping());
    return request;
  }
  return std::nullopt;
}

// The state repeats what it asks for until it is done: no reply is needed.
void GraspService::apply(const Edited& edited) {
  for (const auto& sample : states_.take()) {
    if (sample.disposed || edited.persistence.unusable()) continue;
    const auto request = edit_of(edited.world, sample.value);
    if (!request) continue;
    const world::EditResult result = apply_edit(edited.world, edited.cell, *request);
    if (result.done()) {
      edited.obstacles.publish_shapes(edited.world, request->name(), edited.term);
      static_cast<void>(edited.persistence.write(edited.world));
    }
    log_info(
        request->kind() == msg::EditKind::EDIT_ATTACH ? "gripper holds" : "gripper releases",
        {{"arm", request->arm()}, {"obstacle", request->name()}, {"done", result.done()}, {"reason", result.reason}});
  }
}

void EditService::apply(const Edited& edited) {
  const auto& unusable = edited.persistence.unusable();
  for (const auto& sample : requests_.take()) {
    if (sample.disposed || !taken_.take(sample.value)) continue;
    const msg::WorldEditRequest& request = sample.value;
    const world::EditResult result = unusable ? world::EditResult{world::EditRefusal::kNotNow, world_node(), *unusable}
                                              : apply_edit(edited.world, edited.cell, request);
    if (result.done()) edited.obstacles.publish_shapes(edited.world, edited_name(request), edited.term);
    msg::WorldEditReply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.done(result.done());
    reply.cause(cause_of(result));
    reply.edition(edited.world.edition());
    waiting_.add(result.done() ? edited.persistence.write(edited.world) : 0, std::move(reply));
    log_info("world edit", {{"client", request.client()},
                            {"obstacle", edited_name(request)},
                            {"done", result.done()},
                            {"reason", result.reason}});
  }
}

void EditService::reply(const CheckpointWriter& writer) {
  for (const msg::WorldEditReply& reply : waiting_.take(writer)) static_cast<void>(replies_.write(reply));
}

}  // namespace hecaton::services
