#pragma once
/// The environment of an arm as its planner knows it: obstacles from the world service, and scans of the arm's own
/// distance sensors. Ages are on the clock of this process.

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/cause.h>
#include <idl/world.h>

#include "planner/cell.hpp"
#include "services/bus/mailbox.hpp"
#include "services/planner/arm_view.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::services {

/// The obstacles of the cell: descriptions (ObstacleShapes) joined with states (ObstacleStates) in one order. Only
/// descriptions of the participant count that sends the states. For one thread.
class ObstacleView {
 public:
  using Clock = std::chrono::steady_clock;
  using Obstacles = std::shared_ptr<const std::vector<world::Obstacle>>;

  /// `arms`: of the cell, to which obstacles may be attached.
  explicit ObstacleView(std::vector<std::string> arms);
  /// Participants whose descriptions are kept: the world, its successor, and one that is neither.
  static constexpr std::size_t kMostWorlds = 3;
  /// Descriptions that are kept of one participant.
  static constexpr std::size_t kMostDescribed = 4096;

  // Each apply() returns a sentence when the message is invalid; it then has no effect.
  std::optional<std::string> apply(const msg::ObstacleShapes& shapes, const bus::EndpointId& writer);
  std::optional<std::string> apply(const msg::ObstacleStates& states, const bus::EndpointId& writer,
                                   Clock::time_point received);
  /// The obstacle was withdrawn. Its description is kept until the states no longer name it.
  void withdraw(const std::string& name, const bus::EndpointId& writer);

  /// Joins the newest states with the descriptions. Call it after all messages of a period. True when obstacles() has
  /// changed. States with an obstacle of unknown shape wait for its description; until then the older states stay.
  bool join();

  /// True once states and all their descriptions have been received.
  [[nodiscard]] bool known() const { return joined_at_.has_value(); }
  /// In the order of states().
  [[nodiscard]] const Obstacles& obstacles() const { return obstacles_; }
  /// States as they were sent, with their age at `now`. Valid until the next call.
  [[nodiscard]] std::span<const world::ObstacleState> states(Clock::time_point now);
  /// Age of the states in use [s]; 0 without states.
  [[nodiscard]] double age(Clock::time_point now) const;
  /// A sentence about what is missing while known() is false.
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  struct Known {
    world::Obstacle obstacle;
    bool withdrawn = false;
  };
  struct Arrived {
    world::ObstacleSnapshot snapshot;
    std::vector<std::string> names;
    bus::EndpointId writer;
    Clock::time_point at;  ///< when they were true, on this process's clock
    SenderClock clock;     ///< of their writer
  };

  /// What one participant has described.
  struct World {
    bus::EndpointId writer;
    std::map<std::string, Known> shapes;
  };
  [[nodiscard]] World& world_of(const bus::EndpointId& writer);
  void forget_withdrawn(World& world);

  std::vector<std::string> arms_;
  std::vector<World> worlds_;  ///< the newest last
  bool shapes_changed_ = false;
  std::optional<Arrived> newest_;
  bool waiting_ = false;  ///< newest_ is not joined yet
  Obstacles obstacles_;
  std::vector<std::string> names_;
  std::vector<world::ObstacleState> states_;
  std::optional<Clock::time_point> joined_at_;
  std::string missing_ = "no message of the world service has been received";
};

/// Scans of the distance sensors of one arm. For one thread.
class SensorView {
 public:
  using Clock = std::chrono::steady_clock;

  explicit SensorView(const planner::PlannedArm& arm);

  /// A scan of the own arm, with the arm's configuration at its time, extrapolated from the last state `own`. Empty for
  /// other arms, for scans older than the last, and for invalid scans: these set `error` to a sentence.
  [[nodiscard]] std::optional<planner::RangeScan> take(const msg::RangeScan& message, const bus::EndpointId& writer,
                                                       Clock::time_point received, const ArmView::ReceivedState& own,
                                                       std::optional<std::string>& error);

  /// The first sensor without a scan for `limit` [s] or for three of its periods, whichever is longer. Empty: none.
  [[nodiscard]] std::optional<msg::Cause> silent(Clock::time_point now, double limit) const;

  /// Name of a sensor in messages.
  [[nodiscard]] static std::string key(const std::string& arm, const std::string& sensor) { return arm + "/" + sensor; }

 private:
  struct Received {
    bus::EndpointId writer;
    std::uint64_t sequence = 0;
    Clock::time_point at;  ///< when it was true, on this process's clock
    SenderClock clock;     ///< of its writer
  };

  std::string arm_;
  std::vector<planner::RangeSensor> sensors_;
  std::vector<std::string> links_;  ///< of the sensors
  std::vector<std::optional<Received>> received_;
};

}  // namespace hecaton::services
