#pragma once
/// The rules for obstacles, both of the cell file and added while the cell runs. overlaps.hpp checks their poses
/// against the arms.

#include <optional>
#include <span>
#include <string>

#include "services/config/text.hpp"
#include "world/model/scene.hpp"

namespace hecaton::config {

inline constexpr std::size_t kMostShapes = 64;  ///< of one obstacle
inline constexpr std::size_t kMostObstacles = 256;

/// A carried obstacle is at most this far from the tool frame's origin [m]: the length of a gripper's fingers.
inline constexpr double kGrasp = 0.1;

/// A violated rule, in the words of the cell file.
struct Complaint {
  std::string key;      ///< below the obstacle: "shapes[0].radius"
  std::string value;    ///< "-1 m"
  std::string must_be;  ///< "between 0.0001 and 100 m"

  /// "shapes[0].radius = -1 m must be between 0.0001 and 100 m"
  [[nodiscard]] std::string sentence() const { return key + " = " + value + " must be " + must_be; }
};

/// Checks an obstacle alone, without the rest of the cell. Empty when it is allowed.
[[nodiscard]] std::optional<Complaint> complain(const world::Obstacle& obstacle);

/// Checks a pose in the world: finite, at most kFarthest from the origin, rigid. Empty when it is allowed.
[[nodiscard]] std::optional<Complaint> complain(const world::Pose& pose, const std::string& key);

/// Empty when neither an arm nor another obstacle has this name.
[[nodiscard]] std::optional<Complaint> complain_about_name(const std::string& name, std::span<const std::string> arms,
                                                           std::span<const std::string> obstacles);

}  // namespace hecaton::config
