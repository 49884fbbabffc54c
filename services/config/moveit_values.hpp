#pragma once
/// What MoveIt's files have in common. All functions throw ConfigError.

#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/config/yaml_view.hpp"
#include "world/model/pose.hpp"

namespace hecaton::config::moveit {

inline constexpr std::size_t kMost = 10'000;  ///< items of a list

/// A key that has to be there.
[[nodiscard]] YamlView required(const YamlView& map, std::string_view key);

/// Refuses keys that the message does not have. What is empty may stand for any message.
void check_keys(const YamlView& map, std::span<const std::string_view> keys);

/// Whether something is said: not of an empty value, text or list, nor of a map of such.
[[nodiscard]] bool is_given(const YamlView& view);

/// The text of a key that says something; otherwise empty.
[[nodiscard]] std::string text_if_given(const YamlView& map, std::string_view key);

/// Refuses is_diff = true; `what` is this.
void refuse_diff(const YamlView& map, const std::string& what);

/// Refuses keys that say something, with the sentence "…: has KEY, which …": `which` goes on there.
void refuse_given(const YamlView& map, std::initializer_list<std::string_view> keys, std::string_view which);

/// Three numbers [m], as a list or as a map of x, y and z.
[[nodiscard]] Eigen::Vector3d position(const YamlView& view);
/// A quaternion of length 1, as a list [x, y, z, w] or as a map of them.
[[nodiscard]] Eigen::Quaterniond orientation(const YamlView& view);
/// {position, orientation}
[[nodiscard]] world::Pose pose(const YamlView& view);

/// A RobotState's joints at rest, by name [rad | m]. Refuses bodies attached to it, a base that is not at the origin,
/// and a state that is a difference: what it is different from may carry something.
[[nodiscard]] std::map<std::string, double> robot_state(const YamlView& view);

/// "scene.yaml: a, b are not read: WHY" of those keys that say something; empty when none does.
[[nodiscard]] std::string note_of(const YamlView& map, std::initializer_list<std::string_view> keys,
                                  std::string_view why);

}  // namespace hecaton::config::moveit
