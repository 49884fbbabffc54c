#include "tests/bench/grid_cell.hpp"

#include <cmath>

#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {

std::vector<planner::Arm> grid_of_arms(int count) {
  const int columns = static_cast<int>(std::ceil(std::sqrt(count)));
  const auto model = puma_like("arm", Eigen::Vector3d::Zero()).model;
  std::vector<planner::Arm> arms;
  for (int i = 0; i < count; ++i) {
    planner::Arm& arm = arms.emplace_back();
    arm.name = "arm" + std::to_string(i);
    arm.model = model;
    arm.limits = model->limits;
    const int row = i / columns;
    arm.X_WB.translation() = kGridSpacing * Eigen::Vector3d(i % columns, row, 0.0);
    arm.named["home"] = planner::JointVector::Zero(model->joints());
  }
  return arms;
}

}  // namespace hecaton::bench
