#include "services/arm_driver/devices/ros2_control/results.hpp"

#include <array>
#include <cstdint>

namespace hecaton::device::ros2_control {
namespace {

constexpr std::size_t kMostOfText = 160;  // of a controller's text

/// A text of the network, for people.
std::string shown(const std::string& text) {
  std::string result;
  for (const char c : text.substr(0, kMostOfText)) result += c >= ' ' && c <= '~' ? c : '?';
  return result;
}

}  // namespace

// Codes of the result of FollowJointTrajectory, and what a person does.
std::string reason_of(const ros2::TrajectoryResult& result) {
  constexpr std::array<const char*, 6> kReasons{
      "",
      "it is no valid goal for the controller: compare the joint limits and the controller's parameters",
      "the controller has other joints: set joints or joint_prefix in the cell file",
      "its start has passed: compare the clocks of the machines",
      "the arm left its tolerance on the path: look what blocks it, and compare the limits",
      "the arm did not arrive within its tolerance: look what blocks it, and compare the limits",
  };
  const std::int64_t code = -std::int64_t{result.error_code};  // in 32 bits the least code has no opposite
  std::string text = code > 0 && code < std::ssize(kReasons) ? kReasons[static_cast<std::size_t>(code)] : "";
  if (!result.error_string.empty()) {
    text += (text.empty() ? "" : " ") + std::string("(\"") + shown(result.error_string) + "\")";
  }
  return text.empty() ? "no reason is given: see the log of the controller" : text;
}

}  // namespace hecaton::device::ros2_control
