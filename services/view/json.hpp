#pragma once
/// Values of messages and models as JSON for the page. page/src/protocol.ts has the types of the other side.

#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "world/model/pose.hpp"

namespace hecaton::services::view {

using Json = nlohmann::json;

/// A number with so many decimals, which is short as text.
[[nodiscard]] inline double rounded(double value, double scale = 1e5) {
  return std::round(value * scale) / scale;
}

[[nodiscard]] inline Json vector_json(const Eigen::Vector3d& v) {
  return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}

/// [x, y, z, qx, qy, qz, qw]
[[nodiscard]] inline Json pose_json(const world::Pose& pose) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond(pose.rotation()).normalized();
  const Eigen::Vector3d p = pose.translation();
  return {p.x(), p.y(), p.z(), turn.x(), turn.y(), turn.z(), turn.w()};
}

}  // namespace hecaton::services::view
