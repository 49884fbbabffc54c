#pragma once
/// What an obstacle may be: one set of rules for those of the cell file and for those that are added while the cell
/// runs. Where it may be, among the arms, is obstacle_place.hpp's question.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "services/config/bounds.hpp"
#include "world/model/scene.hpp"

namespace hecaton::config {

inline constexpr std::size_t kMostShapes = 64;  ///< of one obstacle
inline constexpr std::size_t kMostObstacles = 256;

/// What an arm carries is at most this far from its tool frame's origin [m]: a gripper's fingers, no second arm.
inline constexpr double kGrasp = 0.1;

/// What is wrong, in the words of the cell file.
struct Complaint {
  std::string key;      ///< below the obstacle: "shapes[0].radius"
  std::string value;    ///< what stands there: "-1 m"
  std::string must_be;  ///< "between 0.0001 and 100 m"

  /// "shapes[0].radius = -1 m must be between 0.0001 and 100 m"
  [[nodiscard]] std::string sentence() const { return key + " = " + value + " must be " + must_be; }
};

/// Nothing when the obstacle may exist, wherever it is and whoever else is there.
[[nodiscard]] std::optional<Complaint> complain(const world::Obstacle& obstacle);

/// Of a place in the world: every coordinate finite and near enough, the rotation rigid.
[[nodiscard]] std::optional<Complaint> complain(const world::Pose& pose, const std::string& key);

/// Nothing when neither an arm nor another obstacle has this name.
[[nodiscard]] std::optional<Complaint> complain_about_name(const std::string& name, std::span<const std::string> arms,
                                                           std::span<const std::string> obstacles);

}  // namespace hecaton::config
