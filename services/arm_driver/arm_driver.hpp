#pragma once
/// The driver node of one arm.

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <idl/world.h>

#include "services/arm_driver/arm_control.hpp"
#include "services/arm_driver/driver_log.hpp"
#include "services/arm_driver/known_planners.hpp"
#include "services/arm_driver/tool_control.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"

namespace hecaton::services {

/// main() of a driver: parses the command line, loads the cell file and drives the arm until the process shall end.
/// Returns the exit code. A program with its own devices passes their types beside device_types().
[[nodiscard]] int run_arm_driver(int argc, char** argv, std::span<const device::DeviceType> types);

/// Receives commands and publishes the measured state in each period of the driver; its device moves the arm
/// (devices/arm_device.hpp). It stops the arm by itself when commands cease, without a supervisor.
class ArmDriver {
 public:
  /// `arm`: index in the cell. `signals`: kinds of the arm's signals. Throws std::runtime_error with a sentence when
  /// the bus cannot be joined.
  ArmDriver(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown,
            std::unique_ptr<device::ArmDevice> device, std::vector<device::SignalKind> signals);

  /// Runs until the process shall end.
  void run();

 private:
  void receive();
  void take(const bus::Sample<msg::ArmCommand>& sample);
  void handle_orders();
  /// Others move the arm from now on, or its planner does. Returns why not; empty: done.
  [[nodiscard]] device::DeviceResult observe(bool observed);
  void reply(const msg::DeviceRequest& to, const device::DeviceResult& result);
  void reply(const msg::DeviceRequest& to, const msg::Cause& cause);
  void begin(const msg::DeviceRequest& request);
  [[nodiscard]] ToolInputs tool_inputs();
  /// Obstacles that no arm carries, where they are now.
  [[nodiscard]] std::vector<world::Obstacle> free_obstacles();
  void update_tool();
  void publish_tool();
  void report(const bus::Sample<msg::ArmCommand>& sample, const Judgement& judgement);
  void note_lease();
  void update_carried();
  void note_shapes();
  void update_state();
  /// Publishes the state once in published_.period, and at once when what others decide on has changed.
  void publish_when_due();
  void publish_heartbeat();

  std::string name_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  KnownPlanners planners_;
  struct Readers {
    bus::Reader<msg::ArmCommand> commands;
    bus::Reader<msg::ObstacleShapes> shapes;
    bus::Reader<msg::DeviceRequest> orders;
  } readers_;
  struct Writers {
    bus::Writer<msg::ArmState> states;
    bus::Writer<msg::DeviceReply> replies;
  } writers_;
  HeartbeatPublisher heartbeat_;
  PeriodicLoop loop_;
  std::chrono::nanoseconds command_timeout_;
  LeaseCheckpoint checkpoint_;
  MappedRecord<bool> observed_;  ///< the last order: others move the arm
  std::unique_ptr<device::ArmDevice> device_;
  ArmControl control_;
  ToolControl tool_;
  std::map<std::string, bool, std::less<>> attached_;  ///< each obstacle: whether it is attached to the arm
  struct ToolTopics {
    explicit ToolTopics(bus::Participant& participant, bus::Mailbox* mailbox)
        : states(participant), obstacles(participant, mailbox) {}
    bus::Writer<msg::ToolState> states;
    bus::Reader<msg::ObstacleStates> obstacles;
    msg::ObstacleStates newest;                               ///< last received
    msg::ToolState state;                                     ///< last published
    std::optional<std::chrono::steady_clock::time_point> at;  ///< when it was published
  };
  std::optional<ToolTopics> tool_topics_;  ///< of an arm with a gripper or signals
  msg::ArmState state_;                    ///< reused every period
  struct Published {
    std::chrono::nanoseconds period;  ///< of states in which nothing decisive changes
    std::optional<std::chrono::steady_clock::time_point> at;
    msg::ArmState state;
  } published_;
  struct Order {
    msg::DeviceRequest request;  ///< the last one
    bool runs = false;           ///< the device carries it out
    bool of_tool = false;        ///< tool_ carries it out
  } order_;
  DriverLog log_;
};

}  // namespace hecaton::services
