#pragma once
/// The driver of one arm on the bus: commands in, measured state out, at the driver's period. Below it, the device
/// moves the arm (devices/arm_device.hpp). The driver stops the arm by itself when commands cease; it needs no
/// supervisor for that.

#include <memory>
#include <span>
#include <string>

#include <idl/world.h>

#include "services/arm_driver/arm_control.hpp"
#include "services/arm_driver/driver_log.hpp"
#include "services/arm_driver/lease_checkpoint.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/pulse.hpp"

namespace hecaton::services {

/// main() of a driver: parses the command line, loads the cell file and drives its arm until the process is to end. The
/// exit code. A program with devices of its own passes more types than device_types().
[[nodiscard]] int run_arm_driver(int argc, char** argv, std::span<const device::DeviceType> types);

class ArmDriver {
 public:
  /// `arm`: index in the cell. Throws std::runtime_error with a sentence when the bus cannot be joined.
  ArmDriver(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown,
            std::unique_ptr<device::ArmDevice> device);

  /// Until the process is to end.
  void run();

 private:
  void listen();
  void take(const bus::Sample<msg::ArmCommand>& sample);
  void note_lease();
  void look_at_tool();
  void publish();
  void beat();

  std::string name_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  bus::Reader<msg::ArmCommand> commands_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Writer<msg::ArmState> states_;
  Pulse pulse_;
  PeriodicLoop loop_;
  std::chrono::nanoseconds command_timeout_;
  LeaseCheckpoint checkpoint_;
  std::unique_ptr<device::ArmDevice> device_;
  ArmControl control_;
  msg::ArmState state_;  ///< reused every period
  DriverLog log_;
};

}  // namespace hecaton::services
