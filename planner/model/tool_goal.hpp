#pragma once
/// A goal of the tool frame T: its pose, the rotation that stays free, and the tolerances.

#include <cstdint>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// The rotation of T that the planner chooses.
enum class FreeRotation : std::uint8_t {
  kNone,   ///< a goal is position and orientation
  kRoll,   ///< T may turn about its x axis
  kPitch,  ///< T may turn about its y axis
  kYaw,    ///< T may turn about its z axis
  kAll,    ///< a goal is a position
};

struct ToolGoal {
  Pose X_WT = Pose::Identity();
  FreeRotation free_rotation = FreeRotation::kNone;
  double position_tolerance = 1e-3;           ///< largest distance of T's origin from its goal [m]
  double orientation_tolerance = 8.72665e-3;  ///< largest angle from the wanted orientation [rad], 0.5°

  [[nodiscard]] bool operator==(const ToolGoal& other) const {
    return X_WT.matrix() == other.X_WT.matrix() && free_rotation == other.free_rotation &&
           position_tolerance == other.position_tolerance && orientation_tolerance == other.orientation_tolerance;
  }
};

/// Bounds of the tolerances. Inverse kinematics is a tenth more exact than the smallest ones.
inline constexpr double kLeastPositionTolerance = 1e-5;     // [m]
inline constexpr double kMostPositionTolerance = 1.0;       // [m]
inline constexpr double kLeastOrientationTolerance = 1e-4;  // [rad]
inline constexpr double kMostOrientationTolerance = 3.2;    // [rad]: any orientation

/// The shortest rotation vector in W that turns `from` into an orientation that `to` and the free rotation allow [rad].
/// Both map T into W. Zero for kAll.
[[nodiscard]] Eigen::Vector3d rotation_error(FreeRotation free_rotation, const Eigen::Matrix3d& from,
                                             const Eigen::Matrix3d& to);

/// How far a tool frame is from its goal.
struct ToolError {
  double position = 0.0;     ///< [m]
  double orientation = 0.0;  ///< without the free rotation [rad]
};

[[nodiscard]] ToolError tool_error(const ToolGoal& goal, const Pose& X_WT);

[[nodiscard]] inline bool within_tolerance(const ToolGoal& goal, const ToolError& error) {
  return error.position <= goal.position_tolerance && error.orientation <= goal.orientation_tolerance;
}

}  // namespace hecaton::planner
