#pragma once
/// The states of a running cell. It only reads topics.

#include "services/bus/endpoint.hpp"
#include "services/view/cell_feed.hpp"

namespace hecaton::services {

class LiveFeed : public CellFeed {
 public:
  /// `file` and the participant must outlive it. Throws std::runtime_error with a sentence when a reader cannot be
  /// made.
  LiveFeed(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox);

  /// Takes what has arrived. Never blocks.
  void update(bus::Clock::time_point now);

  [[nodiscard]] const CellState& state() const override { return state_; }
  [[nodiscard]] bus::Clock::time_point now() const override { return now_; }
  [[nodiscard]] std::chrono::milliseconds unix_time() const override;
  [[nodiscard]] double rate() const override { return 1.0; }
  [[nodiscard]] std::uint64_t leaps() const override { return 0; }

 private:
  template <class T>
  void take(bus::Reader<T>& reader) {
    for (const auto& sample : reader.take()) state_.apply(sample);
  }

  const bus::Participant& participant_;
  bus::Clock::time_point now_ = bus::Clock::now();
  bus::Reader<msg::CellMode> modes_;
  bus::Reader<msg::ArmState> states_;
  bus::Reader<msg::GoalStatus> goals_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Reader<msg::ObstacleStates> obstacle_states_;
  bus::Reader<msg::ContactReport> contacts_;
  bus::Reader<msg::Heartbeat> heartbeats_;
  bus::Reader<msg::CoupledPlan> plans_;
  bus::Reader<msg::Fault> faults_;
  bus::Reader<msg::ToolState> tools_;
  bus::Reader<msg::PlannedMotion> motions_;
  CellState state_;
};

}  // namespace hecaton::services
