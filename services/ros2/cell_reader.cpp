#include "services/ros2/cell_reader.hpp"

namespace hecaton::ros2 {

CellReader::CellReader(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox)
    : participant_(participant),
      mailbox_(mailbox),
      view_(file.cell),
      states_(participant, &mailbox),
      goals_(participant, &mailbox),
      shapes_(participant, &mailbox),
      obstacle_states_(participant, &mailbox) {}

void CellReader::update(bool motions) {
  take(states_);
  take(goals_);
  take(shapes_);
  take(obstacle_states_);
  if (motions != motions_.has_value()) {
    motions_.reset();
    view_.forget_motions();
    if (motions) motions_.emplace(participant_, &mailbox_);
  }
  if (motions_) take(*motions_);
}

}  // namespace hecaton::ros2
