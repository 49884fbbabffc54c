#pragma once
/// A PUMA 560 among random boxes and other shapes.

#include <string>
#include <vector>

#include "planner/collision/model_filter.hpp"
#include "planner/global/validity.hpp"
#include "planner/local/random.hpp"

namespace hecaton::test {

inline planner::Arm puma(const std::string& name = "puma") {
  static const auto model = planner::load_arm_model(HECATON_SOURCE_DIR "/deploy/cells/urdf/puma560.urdf");
  planner::Arm arm;
  arm.name = name;
  arm.model = model;
  arm.limits = model->limits;
  return arm;
}

/// Boxes of up to 0.5 m; centres 0.35 to 1 m from the base's axis.
inline std::vector<planner::global::WorldBody> random_boxes(int count, planner::Random& random) {
  std::vector<planner::global::WorldBody> boxes;
  for (int i = 0; i < count; ++i) {
    const double angle = random.uniform(-3.14, 3.14);
    const double radius = random.uniform(0.35, 1.0);
    planner::global::WorldBody body;
    body.name = "box" + std::to_string(i);
    body.shape = world::Box{{random.uniform(0.02, 0.12), random.uniform(0.02, 0.12), random.uniform(0.02, 0.12)}};
    body.X_WS.translation() =
        Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), random.uniform(0.1, 1.4));
    body.X_WS.linear() = (Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Eigen::Vector3d::UnitX()))
                             .toRotationMatrix();
    boxes.push_back(body);
  }
  return boxes;
}

}  // namespace hecaton::test
