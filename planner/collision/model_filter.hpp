#pragma once
/// The complete way from a URDF to a robot model that can plan: what load_urdf reads, and its self pairs filtered with
/// exact distances.

#include <memory>
#include <string>

#include "planner/model/collision_filter.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner {

/// load_urdf, then automatic_filter. Throws ModelError.
[[nodiscard]] std::shared_ptr<const RobotModel> load_arm_model(const std::string& urdf_path,
                                                               const UrdfOptions& options = {},
                                                               const FilterOptions& filter = {});

}  // namespace hecaton::planner
