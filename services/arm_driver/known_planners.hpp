#pragma once
/// The participants that discovery has found under the names of an arm's planners.

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::services {

/// For one thread. Its memory is bounded by kMost.
class KnownPlanners {
 public:
  /// A planner has one participant, and those of earlier processes until their lease ends.
  static constexpr std::size_t kMost = 64;

  /// `nodes`: the planners of the arm.
  explicit KnownPlanners(std::vector<std::string> nodes) : nodes_(std::move(nodes)) {}

  /// Takes what discovery tells of participants; other events change nothing.
  void note(const bus::Event& event) {
    if (event.kind != bus::EventKind::kParticipantFound && event.kind != bus::EventKind::kParticipantLost) return;
    std::erase_if(found_, [&](const Found& one) { return one.participant.same_participant(event.peer); });
    if (event.kind == bus::EventKind::kParticipantLost || found_.size() == kMost) return;
    if (std::find(nodes_.begin(), nodes_.end(), event.key) != nodes_.end()) found_.push_back({event.peer, event.key});
  }

  /// True when this endpoint belongs to the only participant that has the name of this planner. Two of them may be the
  /// planner and an intruder, or the planner and its predecessor, and discovery does not tell which is which. With
  /// kMost participants some may be missing here.
  [[nodiscard]] bool is_only(const bus::EndpointId& writer, std::string_view node) const {
    if (found_.size() == kMost) return false;
    const auto named = [&](const Found& one) { return one.node == node; };
    const auto known = std::find_if(found_.begin(), found_.end(), named);
    return known != found_.end() && known->participant.same_participant(writer) &&
           std::find_if(known + 1, found_.end(), named) == found_.end();
  }

 private:
  struct Found {
    bus::EndpointId participant;
    std::string node;
  };
  std::vector<std::string> nodes_;
  std::vector<Found> found_;
};

}  // namespace hecaton::services
