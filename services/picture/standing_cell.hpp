#pragma once
/// A cell as its file starts it, for a picture: each arm in its start position, each obstacle in its place.

#include <chrono>

#include "planner/cell.hpp"
#include "services/messages/convert.hpp"
#include "services/view/cell_feed.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::services::picture {

/// For one thread.
class StandingCell : public CellFeed {
 public:
  /// `file` must outlive it.
  explicit StandingCell(const config::CellFile& file) : state_(file, now_) {
    for (const planner::PlannedArm& planned : file.cell.arms) {
      bus::Sample<msg::ArmState> sample;
      const planner::JointVector q = planned.start.size() > 0 ? planned.start : planned.arm.home();
      sample.key = planned.arm.name;
      sample.received = now_;
      sample.value.arm(planned.arm.name);
      sample.value.mode(msg::ArmMode::ARM_STOPPED);
      sample.value.q(messages::to_message(q));
      sample.value.qd(std::vector<double>(static_cast<std::size_t>(q.size()), 0.0));
      state_.apply(sample);
    }
    world::ObstacleSnapshot places;
    for (const world::Obstacle& obstacle : file.cell.scene.obstacles) {
      places.states.push_back({world::motion_at(obstacle, 0.0).X_WO, {}, 0.0});
      bus::Sample<msg::ObstacleShapes> sample;
      sample.key = obstacle.name;
      sample.received = now_;
      sample.value.name(obstacle.name);
      sample.value.obstacle(messages::to_message(obstacle));
      state_.apply(sample);
    }
    bus::Sample<msg::ObstacleStates> sample;
    sample.received = now_;
    sample.value = messages::to_message(places, file.cell.scene.obstacles);
    state_.apply(sample);
  }

  [[nodiscard]] const CellState& state() const override { return state_; }
  [[nodiscard]] bus::Clock::time_point now() const override { return now_; }
  [[nodiscard]] std::chrono::milliseconds unix_time() const override { return {}; }
  [[nodiscard]] double rate() const override { return 0.0; }
  [[nodiscard]] std::uint64_t leaps() const override { return 0; }

 private:
  bus::Clock::time_point now_ = bus::Clock::now();
  CellState state_;
};

}  // namespace hecaton::services::picture
