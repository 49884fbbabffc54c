#pragma once
/// Reads the topics of a cell into a CellView.

#include <optional>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/ros2_messages/cell_view.hpp"

namespace hecaton::ros2 {

/// For one thread.
class CellReader {
 public:
  /// `file` and `mailbox` must outlive it.
  CellReader(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox);

  /// Takes all that has arrived. `motions`: also what planners want, which they publish only to readers.
  void update(bool motions);

  [[nodiscard]] CellView& view() { return view_; }

 private:
  template <class T>
  void take(bus::Reader<T>& reader) {
    for (auto& sample : reader.take()) view_.apply(std::move(sample));
  }

  bus::Participant& participant_;
  bus::Mailbox& mailbox_;
  CellView view_;
  bus::Reader<msg::ArmState> states_;
  bus::Reader<msg::GoalStatus> goals_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Reader<msg::ObstacleStates> obstacle_states_;
  std::optional<bus::Reader<msg::PlannedMotion>> motions_;
};

}  // namespace hecaton::ros2
