#pragma once
/// Replies to edits. Each waits until what it has changed is remembered, or is known not to be, which it then says: who
/// was told no more than that an edit is done does not lose it with the world's process.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/world.h>

#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"
#include "services/world/memory_keeper.hpp"

namespace hecaton::services {

/// `what`: "the edit is "; `why`: as of MemoryKeeper.
[[nodiscard]] inline msg::Cause not_remembered(const std::string& what, const std::string& why) {
  return make_cause(msg::CauseKind::CAUSE_NOT_PERSISTED, world_node(),
                    what + "not remembered, and lost with the world's process: " + why);
}

class EditReplies {
 public:
  /// `memory`: the number of the one that has the edit; 0: nothing has changed.
  void owe(std::uint64_t memory, msg::WorldEditReply reply) { due_.emplace_back(memory, std::move(reply)); }

  /// Those that have waited long enough, in the order of the edits.
  [[nodiscard]] std::vector<msg::WorldEditReply> take(const MemoryKeeper& keeper) {
    std::vector<msg::WorldEditReply> ready;
    while (!due_.empty()) {
      const std::optional<std::string> outcome = keeper.outcome(due_.front().first);
      if (!outcome) break;
      ready.push_back(std::move(due_.front().second));
      due_.pop_front();
      if (!outcome->empty()) ready.back().cause(not_remembered("the edit is ", *outcome));
    }
    return ready;
  }

 private:
  std::deque<std::pair<std::uint64_t, msg::WorldEditReply>> due_;
};

}  // namespace hecaton::services
