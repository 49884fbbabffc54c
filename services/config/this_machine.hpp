#pragma once
/// Which host of a cell file this machine is.

#include <string>

#include "services/config/cell_file.hpp"

namespace hecaton::config {

/// Whether this machine is `host` of the cell file; in a cell with one host, always. False also for a host with a name
/// instead of an IPv4 address, in a cell with several hosts.
[[nodiscard]] bool is_this_machine(const CellFile& file, const std::string& host);

}  // namespace hecaton::config
