#include "planner/collision/model_filter.hpp"

#include "planner/collision/exact_distance.hpp"

namespace hecaton::planner {

std::shared_ptr<const RobotModel> load_arm_model(const std::string& urdf_path, const UrdfOptions& options,
                                                 const FilterOptions& filter) {
  const auto model = std::make_shared<RobotModel>(*load_urdf(urdf_path, options));
  const auto distance = [](const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
    return shape_distance(a, X_WA, b, X_WB).distance;
  };
  automatic_filter(*model, distance, filter);
  return model;
}

}  // namespace hecaton::planner
