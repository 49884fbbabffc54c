#pragma once
/// The world's topics beside edits: the arms' measured states in; obstacles, sensor scans and contact reports out. The
/// participant and the cell file must outlive these classes, which are for the loop's thread.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/world.h>

#include "planner/model/kinematics.hpp"
#include "planner/simulation/arm_in_world.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "world/sim/bullet_world.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::services {

/// The newest measured states of the arms.
class MeasuredArms {
 public:
  MeasuredArms(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox);

  /// Moves the world's arms to where they are at `now` by the states that have arrived, at constant velocity. Ignores a
  /// state that does not fit its arm, with a warning.
  void update(world::BulletWorld& world, bus::Clock::time_point now);
  /// Arrival of each arm's newest state; empty: none has arrived.
  [[nodiscard]] const std::vector<std::optional<bus::Clock::time_point>>& arrivals() const { return arrivals_; }
  /// Joint positions of each arm at the last update [rad | m].
  [[nodiscard]] const std::vector<std::optional<planner::JointVector>>& q() const { return q_; }

 private:
  void take();

  const config::CellFile& file_;
  bus::Reader<msg::ArmState> states_;
  planner::Kinematics kinematics_;  ///< scratch
  struct Measured {
    planner::JointVector q;       ///< [rad | m]
    planner::JointVector qd;      ///< [rad/s | m/s]
    std::vector<double> outside;  ///< of the joints outside the chain [rad | m]
  };
  std::vector<Measured> measured_;  ///< the newest state of each arm that is in arrivals_
  std::vector<std::optional<bus::Clock::time_point>> arrivals_;
  std::vector<std::optional<planner::JointVector>> q_;
};

/// Publishes the obstacles' shapes and states. `term`: of the newest cell mode.
class ObstaclePublisher {
 public:
  explicit ObstaclePublisher(bus::Participant& participant) : shapes_(participant), states_(participant) {}

  /// Publishes the obstacle's shapes, or withdraws them when the obstacle does not exist any more.
  void publish_shapes(const world::BulletWorld& world, const std::string& name, std::uint64_t term);
  void publish_states(const world::BulletWorld& world, std::uint64_t term);

 private:
  bus::Writer<msg::ObstacleShapes> shapes_;
  bus::Writer<msg::ObstacleStates> states_;
};

/// Publishes the scans of the arms' simulated range sensors.
class ScanPublisher {
 public:
  ScanPublisher(const config::CellFile& file, bus::Participant& participant);
  void publish(const world::BulletWorld& world, const MeasuredArms& arms);

 private:
  const config::CellFile& file_;
  bus::Writer<msg::RangeScan> scans_;
  world::RayCaster caster_;
  std::optional<std::uint64_t> cast_edition_;    ///< edition of the caster's obstacles
  std::vector<planner::RangeScanner> scanners_;  ///< one for each arm
  std::uint64_t sequence_ = 0;
};

/// A report of the contact monitor as a message. The caller sets term, sequence number and stamp.
[[nodiscard]] msg::ContactReport contact_report(const world::ContactReport& report, double time, bool running);

/// Publishes the contact monitor's report every 100 ms and at once after a contact.
class ContactPublisher {
 public:
  explicit ContactPublisher(bus::Participant& participant) : reports_(participant) {}

  /// An earlier process of the world has already published so many contacts.
  void restore(std::uint64_t contacts) { published_ = contacts; }
  /// True when the report is due. Logs a new contact.
  [[nodiscard]] bool due(const world::ContactReport& report, bus::Clock::time_point now);
  void publish(const world::BulletWorld& world, bool running, std::uint64_t term);
  /// At the end of the service: waits up to 200 ms until readers have the last report.
  void finish() { static_cast<void>(reports_.wait_acknowledged(std::chrono::milliseconds(200))); }

 private:
  bus::Writer<msg::ContactReport> reports_;
  std::uint64_t published_ = 0;  ///< number of published contacts
  bus::Clock::time_point due_{};
  std::uint64_t sequence_ = 0;
};

}  // namespace hecaton::services
