#pragma once
/// Robot models of a cell's arms; arms that say the same share one.

#include <memory>
#include <string>
#include <vector>

#include "planner/model/urdf_loader.hpp"
#include "services/config/arm_view.hpp"

namespace hecaton::config {

class ArmModels {
 public:
  /// Throws ConfigError, also for what the model's loader rejects, with the arm's key in front.
  [[nodiscard]] std::shared_ptr<const planner::RobotModel> load(const ArmView& arm);

 private:
  struct Loaded {
    std::string path;
    planner::UrdfOptions options;
    std::shared_ptr<const planner::RobotModel> model;
  };
  std::vector<Loaded> loaded_;
};

}  // namespace hecaton::config
