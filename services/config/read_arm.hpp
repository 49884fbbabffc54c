#pragma once
/// The cell file's sections `defaults` and `arms`: robot models loaded, limits tightened, poses checked.

#include <memory>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

/// Appends to cell.cell.arms and cell.arm_hosts. cell.hosts must be there already. `methods`: what `method` may name.
void read_arms(const MapView& root, const planner::MethodRegistry& methods, CellFile& cell);

}  // namespace hecaton::config
