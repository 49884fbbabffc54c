#pragma once
/// What programs that show a cell in the messages of ROS 2 know of it: the newest messages of drivers, planners and the
/// world service. It knows no network.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/planner.h>
#include <idl/world.h>

#include "planner/cell.hpp"
#include "planner/model/kinematics.hpp"
#include "services/bus/endpoint.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "services/runtime/sender_clock.hpp"
#include "world/model/scene.hpp"

namespace hecaton::ros2 {

/// What the clock of a cell counts from.
enum class CellEpoch : std::uint8_t {
  kBoot,  ///< of a live cell: this machine's start (bus::Clock)
  kUnix   ///< of a recording: 1970
};

/// The newest of one arm.
struct ArmSnapshot {
  const planner::Arm* arm = nullptr;
  const bus::Sample<msg::ArmState>* state = nullptr;  ///< null: none received; `received`: when it was measured
  const msg::GoalStatus* goal = nullptr;              ///< of the newest goal; null: none
  const msg::PlannedMotion* motion = nullptr;         ///< null: none received
  const planner::Kinematics* kinematics = nullptr;    ///< at the measured position; null: not known
  Time stamp;                                         ///< of `state`
};

/// For one thread. References that it returns are valid until the next apply().
class CellView {
 public:
  using Clock = bus::Clock;

  /// `cell` must outlive it.
  explicit CellView(const planner::Cell& cell, CellEpoch epoch = CellEpoch::kBoot);

  // Takes a sample, or the withdrawal of its key.
  void apply(bus::Sample<msg::ArmState> sample);
  void apply(bus::Sample<msg::GoalStatus> sample);
  void apply(const bus::Sample<msg::ObstacleShapes>& sample);
  void apply(bus::Sample<msg::ObstacleStates> sample);
  void apply(bus::Sample<msg::PlannedMotion> sample);
  /// Takes the shapes of an obstacle. They are ignored when they are malformed.
  void set_shapes(const std::string& name, const msg::Obstacle& obstacle);
  void forget_shapes() { known_shapes_.clear(); }
  void forget_motions();

  [[nodiscard]] std::size_t size() const { return arms_.size(); }
  [[nodiscard]] ArmSnapshot arm(std::size_t index) const;
  /// The time for ROS 2 of an instant of the cell's clock.
  [[nodiscard]] Time time_at(Clock::time_point at) const;

  struct Obstacle {
    std::vector<world::PlacedShape> shapes;
    world::Pose X_WO;
  };
  /// Places the obstacles at the poses of the newest states.
  void place_obstacles();
  /// By name, as of the last place_obstacles().
  [[nodiscard]] const std::map<std::string, Obstacle>& obstacles() const { return obstacles_; }
  /// The origin in W of a body as a planner names it, "north/forearm" or "crate"; empty: unknown.
  [[nodiscard]] std::optional<Eigen::Vector3d> position_of(const std::string& body) const;

 private:
  struct Known {
    const planner::Arm* arm = nullptr;
    std::optional<bus::Sample<msg::ArmState>> state;
    std::optional<msg::GoalStatus> goal;
    std::optional<msg::PlannedMotion> motion;
    planner::Kinematics kinematics;
    bool placed = false;
    services::SenderClock clock;  ///< of the driver
  };
  [[nodiscard]] static Clock::time_point measured_at(const bus::Sample<msg::ArmState>& sample, Known& known);

  CellEpoch epoch_;
  std::vector<Known> arms_;
  std::map<std::string, std::size_t, std::less<>> index_;
  std::map<std::string, std::vector<world::PlacedShape>> known_shapes_;
  msg::ObstacleStates newest_;
  std::map<std::string, Obstacle> obstacles_;
};

}  // namespace hecaton::ros2
