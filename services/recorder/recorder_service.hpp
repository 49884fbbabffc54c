#pragma once
/// The service hecaton-recorder: keeps a recording of the last minutes of a cell. It saves what was before and after a
/// fault, a stop or the order of a person.

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <idl/health.h>

#include "services/bus/endpoint.hpp"
#include "services/bus/participant.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/recorder.hpp"
#include "services/recorder/save_orders.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services::recorder {

/// Events of a cell after which its recording is saved: faults of severity error and above, and stops that people
/// order; and SaveSignal.
class SavingEvents {
 public:
  /// `participant` must outlive it, and be none of RawReaders.
  explicit SavingEvents(bus::Participant& participant);
  /// The newest event since the last call, as words; empty: none.
  [[nodiscard]] std::string take();
  /// Of the newest cell mode; 0: none.
  [[nodiscard]] std::uint64_t term() const { return modes_.view().term(); }

 private:
  bus::Reader<msg::Fault> faults_;
  CellModeListener modes_;
  std::set<std::string> stopped_;  ///< by a person: arms, or the cell
};

/// How the service of a cell records: a row of files that begins with `path`.
[[nodiscard]] RecordingOptions row_of(const config::Record& record, std::string path);

class RecorderService {
 public:
  /// Joins the cell. `file` must have the key record; it and `shutdown` must outlive the object. Throws
  /// std::runtime_error with a sentence when the domain cannot be joined.
  RecorderService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Returns when `shutdown` was requested. When the disk refuses a file, the service reports itself as failed, which
  /// is a fault that holds no arm, and begins another file every ten seconds until the disk takes one.
  void run();

 private:
  void begin(bus::Clock::time_point now);
  /// `event`: after which the recording is saved; empty: none.
  void record(const std::string& event);
  [[nodiscard]] std::string newest_file() const;  ///< of recorder_
  void fail(const std::string& reason);
  void publish_heartbeat();

  const config::CellFile& file_;
  const config::Record& record_;
  bus::Participant participant_;  ///< of the heartbeats and events
  bus::Mailbox mailbox_;
  bus::Participant recording_participant_;  ///< RawReaders allow no typed endpoint beside them
  PeriodicLoop loop_;
  std::optional<HeartbeatPublisher> heartbeat_;  ///< of a service of an agent
  SavingEvents events_;
  SaveOrders orders_;
  std::unique_ptr<Recorder> recorder_;  ///< null: the disk refuses
  std::optional<std::string> refusal_;  ///< why
  bus::Clock::time_point begin_at_{};
};

}  // namespace hecaton::services::recorder
