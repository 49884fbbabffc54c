#pragma once
/// The picture of the cell as the supervisor answers it.

#include <idl/supervisor.h>

#include "services/config/cell_file.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/messages.hpp"
#include "services/supervisor/picture.hpp"
#include "services/supervisor/succession.hpp"

namespace hecaton::services {

struct StatusSource {
  const config::CellFile& file;
  const FaultDetector& watch;
  const Picture& picture;
  const Succession& succession;
  const msg::CellMode& mode;  ///< as last published
};
/// `uptime` is left to the caller.
[[nodiscard]] msg::CellStatus cell_status(const StatusSource& source, const Clocks& clocks);

}  // namespace hecaton::services
