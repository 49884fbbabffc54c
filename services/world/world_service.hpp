#pragma once
/// The world on the bus: obstacles in real time, edits by people and perception, and the contact monitor's account of
/// the arms as they were measured.

#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/pulse.hpp"
#include "services/world/world_checkpoint.hpp"
#include "services/world/world_edit.hpp"
#include "services/world/world_parts.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

class WorldService {
 public:
  /// Goes on where the last world died that had the same file for its memory. Throws std::runtime_error or
  /// std::invalid_argument with a sentence when the bus cannot be joined or the scene is impossible. `file` must
  /// outlive it.
  WorldService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Until the process is to end.
  void run();

 private:
  void step();
  void beat();
  [[nodiscard]] std::uint64_t term() const { return modes_.view().term(); }

  const config::CellFile& file_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  Pulse pulse_;
  PeriodicLoop loop_;
  WorldPersistence persistence_;
  world::BulletWorld world_;
  MeasuredArms arms_;
  EditService edits_;
  ObstaclePublisher obstacles_;
  ScanPublisher scans_;
  ContactPublisher contacts_;
};

}  // namespace hecaton::services
