#include "services/view/live_feed.hpp"

namespace hecaton::services {

LiveFeed::LiveFeed(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox)
    : participant_(participant),
      modes_(participant, &mailbox),
      states_(participant, &mailbox),
      goals_(participant, &mailbox),
      shapes_(participant, &mailbox),
      obstacle_states_(participant, &mailbox),
      contacts_(participant, &mailbox),
      heartbeats_(participant, &mailbox),
      plans_(participant, &mailbox),
      faults_(participant, &mailbox),
      tools_(participant, &mailbox),
      motions_(participant, &mailbox),
      state_(file, now_) {}

void LiveFeed::update(bus::Clock::time_point now) {
  now_ = now;
  take(modes_);
  take(states_);
  take(goals_);
  take(shapes_);
  take(obstacle_states_);
  take(contacts_);
  take(heartbeats_);
  take(plans_);
  take(faults_);
  take(tools_);
  take(motions_);
  if (participant_.recovering()) state_.forget_order();
}

std::chrono::milliseconds LiveFeed::unix_time() const {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch());
}

}  // namespace hecaton::services
