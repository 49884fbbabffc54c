#pragma once
/// The driver of one (simulated) arm on the bus: commands in, measured state out, at the driver's period. Stops the arm
/// by itself when commands cease, and never needs the supervisor to be alive for that.

#include <chrono>
#include <string>

#include <idl/world.h>

#include "services/arm_driver/arm_memory.hpp"
#include "services/arm_driver/command_record.hpp"
#include "services/arm_driver/simulated_drive.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/pulse.hpp"

namespace hecaton::services {

class ArmDriver {
 public:
  /// `arm`: index in the cell. Throws std::runtime_error with a sentence when the bus cannot be joined.
  ArmDriver(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Until the process is to end.
  void run();

 private:
  void listen();
  void take(const bus::Sample<msg::ArmCommand>& sample);
  void note_acceptance(const Commander& commander, bus::Clock::time_point at);
  void note_mandate();
  void note_refusal(const bus::Sample<msg::ArmCommand>& sample, Verdict verdict);
  void look_at_tool();
  void publish();
  void beat();

  std::string name_;
  double period_;  ///< [s]
  std::chrono::nanoseconds command_timeout_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  bus::Reader<msg::ArmCommand> commands_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Writer<msg::ArmState> states_;
  Pulse pulse_;
  PeriodicLoop loop_;
  ArmMemory memory_;
  SimulatedDrive drive_;
  msg::ArmState state_;  ///< reused every period
  msg::ArmMode logged_mode_ = msg::ArmMode::ARM_STARTING;
  CommandRecord record_;
  bus::Clock::time_point accepted_at_{};  ///< when the command that was accepted last arrived
  ArmLease logged_mandate_;
};

}  // namespace hecaton::services
