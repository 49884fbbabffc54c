#pragma once
/// The world on the bus: obstacles in real time, edits by people and perception, and the referee's account of the arms
/// as they were measured.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/world.h>

#include "planner/model/kinematics.hpp"
#include "planner/simulation/range_scanner.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/pulse.hpp"
#include "services/world/edit_replies.hpp"
#include "services/world/memory_keeper.hpp"
#include "services/world/world_memory.hpp"
#include "world/sim/bullet_world.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::services {

class WorldService {
 public:
  /// Goes on where the last one died that had the same file for its memory.
  /// Throws std::runtime_error or std::invalid_argument with a sentence when the bus cannot be joined or the scene is
  /// impossible. `file` must outlive it.
  WorldService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Until the process is to end.
  void run();

 private:
  using Clock = std::chrono::steady_clock;

  void go_on();
  void set_arms();
  void edit();
  void reply();
  std::uint64_t remember();
  void look_at_memory();
  void publish_shapes(const std::string& name);
  void publish_states();
  void publish_scans();
  void judge();
  void publish_report(const world::RefereeReport& report, bool running);
  void beat();

  const config::CellFile& file_;
  double period_;  ///< [s]
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  bus::Reader<msg::ArmState> arm_states_;
  bus::Reader<msg::WorldEditRequest> requests_;
  bus::Writer<msg::WorldEditReply> replies_;
  bus::Writer<msg::ObstacleShapes> shapes_;
  bus::Writer<msg::ObstacleStates> states_;
  bus::Writer<msg::RangeScan> scans_;
  bus::Writer<msg::RefereeReport> reports_;
  Pulse pulse_;
  PeriodicLoop loop_;
  std::string lost_;  ///< why what was before cannot be recovered, a sentence; empty: it can, or there was nothing
  std::optional<Continuation> before_;  ///< of a world that died
  world::BulletWorld world_;
  MemoryKeeper memory_;
  EditReplies replies_due_;
  std::string forgetful_;           ///< why edits are not remembered, as it was logged; empty: they are
  planner::Kinematics kinematics_;  ///< scratch
  std::vector<std::optional<Clock::time_point>> measured_;  ///< when each arm's last state came
  std::vector<std::optional<planner::JointVector>> q_;      ///< what it said
  world::RayCaster caster_;
  std::optional<std::uint64_t> cast_edition_;    ///< of the obstacles that the caster has
  std::vector<planner::RangeScanner> scanners_;  ///< of the arms
  std::uint64_t scan_sequence_ = 0;
  std::uint64_t contacts_told_ = 0;
  Clock::time_point report_due_{};
  std::uint64_t report_sequence_ = 0;
};

}  // namespace hecaton::services
