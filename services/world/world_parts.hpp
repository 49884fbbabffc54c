#pragma once
/// What the world service does on the bus beside edits: it takes the arms' measured states into the world, and
/// publishes obstacles, sensor scans and the contact monitor's report. The participant and the cell file must outlive
/// every part; each belongs to the service's loop.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/world.h>

#include "planner/model/kinematics.hpp"
#include "planner/simulation/range_scanner.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "world/sim/bullet_world.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::services {

/// The arms as they were measured last.
class MeasuredArms {
 public:
  MeasuredArms(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox);

  /// Moves the world's arms to the states that have arrived; ignores states that do not fit the arm, with a warning.
  void update(world::BulletWorld& world);
  /// When each arm's last state arrived; empty: none did.
  [[nodiscard]] const std::vector<std::optional<bus::Clock::time_point>>& arrivals() const { return arrivals_; }
  /// The joint positions in it [rad | m].
  [[nodiscard]] const std::vector<std::optional<planner::JointVector>>& q() const { return q_; }

 private:
  const config::CellFile& file_;
  bus::Reader<msg::ArmState> states_;
  planner::Kinematics kinematics_;  ///< scratch
  std::vector<std::optional<bus::Clock::time_point>> arrivals_;
  std::vector<std::optional<planner::JointVector>> q_;
};

/// Publishes what the obstacles are and where they are. `term`: of the cell mode that the world follows.
class ObstaclePublisher {
 public:
  explicit ObstaclePublisher(bus::Participant& participant) : shapes_(participant), states_(participant) {}

  /// An obstacle that is no longer there is withdrawn.
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
  std::optional<std::uint64_t> cast_edition_;    ///< of the obstacles that the caster has
  std::vector<planner::RangeScanner> scanners_;  ///< of the arms
  std::uint64_t sequence_ = 0;
};

/// The contact monitor's account as a message; term, sequence number and stamp are left to the caller.
[[nodiscard]] msg::RefereeReport contact_report(const world::RefereeReport& report, double time, bool running);

/// Publishes the contact monitor's account periodically, and at once after a contact.
class ContactPublisher {
 public:
  explicit ContactPublisher(bus::Participant& participant) : reports_(participant) {}

  /// A world that goes on has published so many contacts already.
  void go_on(std::uint64_t contacts) { published_ = contacts; }
  /// True when the account is to be published now; a new contact is logged.
  [[nodiscard]] bool due(const world::RefereeReport& report, bus::Clock::time_point now);
  void publish(const world::BulletWorld& world, bool running, std::uint64_t term);
  /// When the service ends: waits a moment for readers of the last report.
  void finish() { static_cast<void>(reports_.wait_acknowledged(std::chrono::milliseconds(200))); }

 private:
  bus::Writer<msg::RefereeReport> reports_;
  std::uint64_t published_ = 0;  ///< contacts
  bus::Clock::time_point due_{};
  std::uint64_t sequence_ = 0;
};

}  // namespace hecaton::services
