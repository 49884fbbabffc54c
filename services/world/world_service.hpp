#pragma once
/// The world node.

#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/world/world_checkpoint.hpp"
#include "services/world/world_edit.hpp"
#include "services/world/world_topics.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// Moves the obstacles in real time, applies edits of operators and perception, and checks the measured arms for
/// contacts.
class WorldService {
 public:
  /// Continues from the checkpoint in options.checkpoint. Throws std::runtime_error or std::invalid_argument with a
  /// sentence when the bus cannot be joined or the scene is impossible. `file` must outlive it.
  WorldService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Runs until the process shall end.
  void run();

 private:
  void step();
  void publish_heartbeat();
  [[nodiscard]] std::uint64_t term() const { return modes_.view().term(); }

  const config::CellFile& file_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  HeartbeatPublisher heartbeat_;
  PeriodicLoop loop_;
  WorldPersistence persistence_;
  world::BulletWorld world_;
  MeasuredArms arms_;
  EditService edits_;
  GraspService grasps_;
  ObstaclePublisher obstacles_;
  ScanPublisher scans_;
  ContactPublisher contacts_;
};

}  // namespace hecaton::services
