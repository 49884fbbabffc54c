#pragma once
/// Loads a complete robot model for planning: load_urdf, then automatic_filter with exact distances.

#include <memory>
#include <string>

#include "planner/model/collision_filter.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner {

/// Throws ModelError.
[[nodiscard]] std::shared_ptr<const RobotModel> load_arm_model(const std::string& urdf_path,
                                                               const UrdfOptions& options = {},
                                                               const FilterOptions& filter = {});

}  // namespace hecaton::planner
