#pragma once
/// What is doubtful about a cell that can start: the checks behind `hecaton check`.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"

namespace hecaton::config {

enum class Severity {
  kNote,     ///< worth knowing
  kWarning,  ///< runs, but not as well or not as safely as the file may make believe
  kError,    ///< will not work: no task can be done
};

struct Finding {
  Severity severity = Severity::kNote;
  std::string sentence;  ///< begins with the key path: "arms[0].damper.security_distance = 0.005 should be …"
};

/// All findings, errors first. Deterministic; takes up to a second for a large cell.
[[nodiscard]] std::vector<Finding> validate(const CellFile& file);

}  // namespace hecaton::config
