#pragma once
/// A pose that is a place only.

#include "world/model/pose.hpp"

namespace hecaton::world {

inline Pose at_point(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

}  // namespace hecaton::world
