#pragma once
/// The types of Universal Robots arms: which one a description is of, and whether a controller has it. Pure.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::device::universal_robots {

/// The types that a controller can have, for messages and for the key `model`.
[[nodiscard]] std::string robot_types();
[[nodiscard]] bool is_robot_type(std::string_view type);

/// The type that these names mention as one of their words: "ur5e" for {"dual_ur5e"}. Empty: none, or several.
[[nodiscard]] std::optional<std::string> mentioned_type(const std::vector<std::string>& names);

/// What a controller says.
struct FoundRobot {
  std::string model;                ///< answer of the dashboard to `get robot model`, such as "UR5"; empty: none
  std::uint32_t major_version = 0;  ///< of the controller: 3 of a CB3, 5 of an e-Series; 0: not known

  /// For people: "UR5e". The dashboard names an e-Series as its CB3. Empty: nothing is known.
  [[nodiscard]] std::string name() const;
  /// False: it is certainly another robot than `expected`.
  [[nodiscard]] bool may_be(std::string_view expected) const;
};

}  // namespace hecaton::device::universal_robots
