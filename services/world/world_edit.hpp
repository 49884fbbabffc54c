#pragma once
/// Edits of the world: obeys requests, and answers each once the checkpoint has its change.

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <idl/world.h>

#include "planner/cell.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/obstacle_place.hpp"
#include "services/world/world_checkpoint.hpp"
#include "services/world/world_parts.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// Among whom an edit is made.
struct EditedCell {
  std::span<const planner::PlannedArm> arms;
  config::MeasuredJoints q;  ///< of each arm
};

/// Done, or one sentence that says why not; then nothing has changed. The rules are those of the cell file: what an
/// obstacle may be, that it must be clear of the arms, and that what an arm takes must be near its tool.
[[nodiscard]] world::EditResult apply_edit(world::BulletWorld& world, const EditedCell& cell,
                                           const msg::WorldEditRequest& request);

/// As in the reply: CAUSE_NONE when it was done.
[[nodiscard]] msg::Cause cause_of(const world::EditResult& result);

/// The obstacle that a request is about.
[[nodiscard]] const std::string& edited_name(const msg::WorldEditRequest& request);

/// Replies to edits. Each waits until the checkpoint file has what it has changed, or is known not to have it, which
/// the reply then says: a client that was told no more than that an edit is done does not lose it with the world's
/// process.
class EditReplies {
 public:
  /// `memory`: the number of the one that has the edit; 0: nothing has changed.
  void owe(std::uint64_t memory, msg::WorldEditReply reply) { due_.emplace_back(memory, std::move(reply)); }

  /// Those that have waited long enough, in the order of the edits.
  [[nodiscard]] std::vector<msg::WorldEditReply> take(const CheckpointWriter& writer);

 private:
  std::deque<std::pair<std::uint64_t, msg::WorldEditReply>> due_;
};

class EditService {
 public:
  EditService(bus::Participant& participant, bus::Mailbox& mailbox)
      : requests_(participant, &mailbox), replies_(participant) {}

  /// What the edits change.
  struct Edited {
    world::BulletWorld& world;
    EditedCell cell;
    WorldPersistence& persistence;
    ObstaclePublisher& obstacles;
    std::uint64_t term;
  };
  /// Makes the edits that have arrived, and publishes what they change. Refuses all of them while what was edited
  /// before is lost.
  void obey(const Edited& edited);
  /// Sends the replies that have waited long enough.
  void reply(const CheckpointWriter& writer);

 private:
  bus::Reader<msg::WorldEditRequest> requests_;
  bus::Writer<msg::WorldEditReply> replies_;
  EditReplies due_;
};

}  // namespace hecaton::services
