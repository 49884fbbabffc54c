#include "services/ros2/cell_reader.hpp"

namespace hecaton::ros2 {

CellReader::CellReader(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox)
    : view_(file.cell),
      states_(participant, &mailbox),
      goals_(participant, &mailbox),
      shapes_(participant, &mailbox),
      obstacle_states_(participant, &mailbox),
      plans_(participant, &mailbox) {}

void CellReader::update() {
  take(states_);
  take(goals_);
  take(shapes_);
  take(obstacle_states_);
  take(plans_);
}

}  // namespace hecaton::ros2
