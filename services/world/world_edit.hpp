#pragma once
/// Edits of the world: applies requests, and replies to each once the checkpoint file has its change.

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <idl/arm.h>
#include <idl/world.h>

#include "planner/cell.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/overlaps.hpp"
#include "services/world/world_checkpoint.hpp"
#include "services/world/world_topics.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// The arms of the cell, of which an edit must be clear.
struct EditedCell {
  std::span<const planner::PlannedArm> arms;
  config::MeasuredJoints q;  ///< of each arm
};

/// Applies an edit, or refuses it with one sentence and changes nothing. The rules are those of the cell file: allowed
/// values, clearance from the arms, and an attached obstacle near the arm's tool.
[[nodiscard]] world::EditResult apply_edit(world::BulletWorld& world, const EditedCell& cell,
                                           const msg::WorldEditRequest& request);

/// The reply's cause; CAUSE_NONE when the edit is done.
[[nodiscard]] msg::Cause cause_of(const world::EditResult& result);

/// The name of the obstacle that a request edits.
[[nodiscard]] const std::string& edited_name(const msg::WorldEditRequest& request);

/// Holds replies until the checkpoint file has the edit, or its write has failed, which the reply then says. So an edit
/// that a client knows as done survives the world's process.
class EditReplies {
 public:
  /// `checkpoint`: the number of the checkpoint with the edit; 0: nothing has changed.
  void add(std::uint64_t checkpoint, msg::WorldEditReply reply) { waiting_.emplace_back(checkpoint, std::move(reply)); }

  /// Removes and returns the replies that need not wait any more, in the order of the edits.
  [[nodiscard]] std::vector<msg::WorldEditReply> take(const CheckpointWriter& writer);

 private:
  std::deque<std::pair<std::uint64_t, msg::WorldEditReply>> waiting_;
};

/// Tells repeated requests from new ones: a client repeats its request until the reply arrives, because the world may
/// have discovered the client too late for the first one.
class TakenRequests {
 public:
  /// False: the request was taken before. Requests with number 0 are all new. Remembers the last thousand.
  [[nodiscard]] bool take(const msg::WorldEditRequest& request);

 private:
  std::deque<std::pair<std::string, std::uint64_t>> taken_;
};

/// What edits act on.
struct Edited {
  world::BulletWorld& world;
  EditedCell cell;
  WorldPersistence& persistence;
  ObstaclePublisher& obstacles;
  std::uint64_t term;
};

/// The edit that the state of a gripper asks for: to attach what it grasps, or to detach what it releases. Empty: none
/// is needed, because the obstacles are so already.
[[nodiscard]] std::optional<msg::WorldEditRequest> edit_of(const world::BulletWorld& world,
                                                           const msg::ToolState& state);

/// Attaches what grippers grasp, and detaches what they release, as the drivers' states say. For the loop's thread.
class GraspService {
 public:
  GraspService(bus::Participant& participant, bus::Mailbox& mailbox) : states_(participant, &mailbox) {}
  /// Does nothing while the checkpoint is unusable.
  void apply(const Edited& edited);

 private:
  bus::Reader<msg::ToolState> states_;
};

/// Edits over the bus. For the loop's thread.
class EditService {
 public:
  EditService(bus::Participant& participant, bus::Mailbox& mailbox)
      : requests_(participant, &mailbox), replies_(participant) {}

  /// Applies the edits that have arrived and publishes the changes. Refuses all edits while the checkpoint is unusable.
  void apply(const Edited& edited);
  /// Sends the replies that need not wait any more.
  void reply(const CheckpointWriter& writer);

 private:
  bus::Reader<msg::WorldEditRequest> requests_;
  bus::Writer<msg::WorldEditReply> replies_;
  TakenRequests taken_;
  EditReplies waiting_;
};

}  // namespace hecaton::services
