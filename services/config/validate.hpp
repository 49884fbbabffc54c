#pragma once
/// The checks of `hecaton check`: weaknesses of a cell that can start.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"

namespace hecaton::config {

enum class Severity {
  kNote,     ///< information
  kWarning,  ///< the cell runs, but with lower performance or safety than the file suggests
  kError,    ///< the cell cannot do any task
};

/// "error", "warning" or "note"
[[nodiscard]] const char* name_of(Severity severity);

/// One finding about a cell.
struct Finding {
  Severity severity = Severity::kNote;
  std::string sentence;  ///< begins with the key path: "arms[0].damper.security_distance = 0.005 should be …"
};

/// All findings, errors first. Deterministic; takes up to a second for a large cell.
[[nodiscard]] std::vector<Finding> validate(const CellFile& file);

}  // namespace hecaton::config
