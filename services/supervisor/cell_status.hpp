#pragma once
/// The picture of the cell as the supervisor answers it.

#include <cstdint>
#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/config/cell_file.hpp"
#include "services/supervisor/cell_watch.hpp"
#include "services/supervisor/picture.hpp"

namespace hecaton::services {

/// Relates the watch's time (the steady clock since its epoch) to the wall clock, for people.
struct Clocks {
  Time now{0};
  std::int64_t now_unix_ms = 0;
};
[[nodiscard]] Clocks read_clocks();

/// Term, sequence number and stamp are left to the caller.
[[nodiscard]] msg::CellMode mode_message(const ModeDecision& decision, const std::string& node);
/// Term, sequence number and stamp are left to the caller.
[[nodiscard]] msg::Fault fault_message(const FaultRecord& record, const Clocks& clocks);

struct StatusSource {
  const config::CellFile& file;
  const CellWatch& watch;
  const Picture& picture;
  const msg::CellMode& mode;  ///< as last published
};
/// `supervisor`, `standby` and `uptime` are left to the caller.
[[nodiscard]] msg::CellStatus cell_status(const StatusSource& source, const Clocks& clocks);

}  // namespace hecaton::services
