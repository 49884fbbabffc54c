#pragma once
/// The names of a cell's nodes in heartbeats, logs and faults.

#include <string>
#include <string_view>

namespace hecaton::services {

[[nodiscard]] inline std::string planner_node(std::string_view arm) {
  return "planner/" + std::string(arm);
}
/// The standby instance of `node` on its standby host.
[[nodiscard]] inline std::string standby_node(const std::string& node, std::string_view host) {
  return node + "@" + std::string(host);
}
[[nodiscard]] inline std::string driver_node(std::string_view arm) {
  return "driver/" + std::string(arm);
}
[[nodiscard]] inline std::string agent_node(std::string_view host) {
  return "agent/" + std::string(host);
}
[[nodiscard]] inline std::string world_node() {
  return "world";
}
[[nodiscard]] inline std::string ros2_node() {
  return "ros2";
}
[[nodiscard]] inline std::string supervisor_node() {
  return "supervisor";
}
[[nodiscard]] inline std::string view_node() {
  return "view";
}
[[nodiscard]] inline std::string recorder_node() {
  return "recorder";
}

}  // namespace hecaton::services
