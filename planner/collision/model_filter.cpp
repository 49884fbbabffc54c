#include "planner/collision/model_filter.hpp"

#include <map>
#include <utility>

#include "planner/collision/exact_distance.hpp"
#include "planner/collision/filter_cache.hpp"
#include "planner/collision/swept_core.hpp"

namespace hecaton::planner {
namespace {

void filter_exactly(RobotModel& model, const FilterOptions& filter) {
  std::map<const world::Shape*, SweptCore> cores;  // prepared once: a hull takes longer than a distance
  for (const LinkGeometry& geometry : model.geometry) cores.emplace(&geometry.shape, make_swept_core(geometry.shape));
  const auto distance = [&cores](const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
    return prepared_distance(cores.at(&a), X_WA, cores.at(&b), X_WB).distance;
  };
  automatic_filter(model, distance, filter);
}

}  // namespace

std::shared_ptr<const RobotModel> load_arm_model(const std::string& urdf_path, const UrdfOptions& options,
                                                 const FilterOptions& filter) {
  const auto loaded = load_urdf(urdf_path, options);
  const std::filesystem::path& folder = folder_of_filter_results();
  const std::string inputs = folder.empty() ? std::string() : filter_inputs(*loaded, filter);
  if (!inputs.empty()) {
    if (auto kept = kept_filter_result(folder, inputs, *loaded)) return std::make_shared<RobotModel>(std::move(*kept));
  }
  const auto model = std::make_shared<RobotModel>(*loaded);
  filter_exactly(*model, filter);
  if (!inputs.empty()) keep_filter_result(folder, inputs, *loaded, *model);
  return model;
}

}  // namespace hecaton::planner
