#include "planner/collision/model_filter.hpp"

#include <map>

#include "planner/collision/exact_distance.hpp"
#include "planner/collision/swept_core.hpp"

namespace hecaton::planner {

std::shared_ptr<const RobotModel> load_arm_model(const std::string& urdf_path, const UrdfOptions& options,
                                                 const FilterOptions& filter) {
  const auto model = std::make_shared<RobotModel>(*load_urdf(urdf_path, options));
  std::map<const world::Shape*, SweptCore> cores;  // prepared once: a hull takes longer than a distance
  for (const LinkGeometry& geometry : model->geometry) cores.emplace(&geometry.shape, make_swept_core(geometry.shape));
  const auto distance = [&cores](const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
    return prepared_distance(cores.at(&a), X_WA, cores.at(&b), X_WB).distance;
  };
  automatic_filter(*model, distance, filter);
  return model;
}

}  // namespace hecaton::planner
