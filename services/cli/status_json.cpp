#include <algorithm>
#include <string_view>

#include "services/cli/status_output.hpp"
#include "services/command_line/options.hpp"
#include "services/config/validate.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services::cli {
namespace {

Json age(double seconds) {
  return seconds < 0.0 ? Json(nullptr) : Json(seconds);
}

Json vector(const msg::Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Json pose(const msg::Pose& pose) {
  const auto value = messages::from_message(pose, "pose");
  return value ? Json(xyz_rpy_of(*value)) : Json(nullptr);
}

/// The names in "crate, lid".
Json names(const std::string& list) {
  constexpr std::string_view kComma = ", ";
  Json json = Json::array();
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(kComma, begin), list.size());
    json.push_back(list.substr(begin, end - begin));
    begin = end + kComma.size();
  }
  return json;
}

}  // namespace

Json to_json(const msg::GoalStatus& goal) {
  Json json{
      {"arm", goal.arm()}, {"goal", goal.goal()}, {"state", text(goal.state())}, {"cause", to_json(goal.cause())}};
  const std::string reason = reason_text(goal);
  json["reason"] = reason.empty() ? Json(nullptr) : Json(reason);
  json["binding"] = nullptr;
  if (goal.has_binding()) {
    json["binding"] = {
        {"own", goal.binding_own()}, {"other", goal.binding_other()}, {"distance_m", goal.binding_distance()}};
  }
  json["recovery_action"] = goal.recovery_action();
  json["blocked_duration_s"] = goal.blocked_duration();
  json["distance_to_goal"] = goal.distance_to_goal();
  json["elapsed_s"] = goal.elapsed();
  json["planner"] = goal.node();
  std::vector<config::Finding> findings;
  if (!goal.note().empty()) findings.push_back({config::Severity::kNote, goal.note()});
  json["findings"] = findings_json(findings);
  json["tool_error"] = nullptr;
  if (goal.has_tool() && goal.position_error() >= 0.0) {
    json["tool_error"] = {{"position_m", goal.position_error()}, {"orientation_rad", goal.orientation_error()}};
  }
  json["nearest"] = nullptr;
  if (goal.has_nearest()) {
    json["nearest"] = {{"xyz_rpy", pose(goal.X_WT_nearest())}, {"angle_rad", goal.nearest_angle()}};
  }
  return json;
}

Json to_json(const msg::ArmStatus& arm) {
  const msg::ArmState& state = arm.state();
  Json json{{"name", arm.arm()},
            {"mode", text(arm.mode())},
            {"speed", arm.speed()},
            {"driver_alive", arm.driver_alive()},
            {"planner_alive", arm.planner_alive()},
            {"planner", arm.planner()},
            {"standby", arm.standby()},
            {"term", arm.term()},
            {"waiting_for", to_json(arm.waiting_for())}};
  json["state"] = {{"mode", text(state.mode())},
                   {"q", state.q()},
                   {"qd", state.qd()},
                   {"speed_scaling", state.speed_scaling()},
                   {"carried", names(state.carried())},
                   {"cause", to_json(state.cause())},
                   {"term", state.term()},
                   {"command_age_s", age(state.command_age())},
                   {"newest_term", state.newest_term()},
                   {"planner", state.planner()},
                   {"stale_rejected", state.stale_rejected()},
                   {"age_s", age(arm.state_age())}};
  json["goal"] = nullptr;
  if (arm.has_goal()) {
    json["goal"] = to_json(arm.goal());
    json["goal"]["age_s"] = age(arm.goal_age());
  }
  return json;
}

Json to_json(const msg::Cause& cause) {
  if (is_none(cause)) return nullptr;
  return {{"kind", cause_name(cause.kind())}, {"subject", cause.subject()}, {"text", cause.text()}};
}

Json to_json(const msg::NodeStatus& node) {
  const msg::Heartbeat& heartbeat = node.heartbeat();
  return {{"node", heartbeat.node()},
          {"kind", text(heartbeat.kind())},
          {"subject", heartbeat.subject()},
          {"host", heartbeat.host()},
          {"pid", heartbeat.pid()},
          {"alive", node.alive()},
          {"state", text(heartbeat.state())},
          {"cause", to_json(heartbeat.cause())},
          {"term", heartbeat.term()},
          {"ticks", heartbeat.ticks()},
          {"tick_us",
           {{"p50", heartbeat.tick_p50_us()}, {"p99", heartbeat.tick_p99_us()}, {"max", heartbeat.tick_max_us()}}},
          {"lateness_max_us", heartbeat.lateness_max_us()},
          {"oldest_input", heartbeat.oldest_input()},
          {"oldest_input_age_s", age(heartbeat.oldest_input_age())},
          {"rss_bytes", heartbeat.rss_bytes()},
          {"age_s", age(node.age())}};
}

Json to_json(const msg::HostStatus& host) {
  Json json{{"host", host.host()}, {"agent_alive", host.agent_alive()}, {"age_s", age(host.age())}};
  json["processes"] = Json::array();
  for (const msg::ProcessEvent& process : host.processes()) {
    json["processes"].push_back({{"name", process.name()},
                                 {"node", process.node()},
                                 {"pid", process.pid()},
                                 {"running", process.kind() == msg::ProcessEventKind::PROCESS_STARTED},
                                 {"wanted", process.wanted()},
                                 {"exit_code", process.exit_code()},
                                 {"signal", process.signal_number()},
                                 {"restarts", process.restarts()}});
  }
  return json;
}

Json to_json(const msg::Fault& fault) {
  return {{"id", fault.id()},
          {"severity", text(fault.severity())},
          {"kind", cause_name(fault.cause().kind())},
          {"subject", fault.cause().subject()},
          {"description", fault.cause().text()},
          {"since_unix_ms", fault.since_unix_ms()},
          {"cleared", fault.cleared()},
          {"duration_s", fault_duration(fault)},
          {"detection_latency_bound_s", age(fault.detection_latency_bound())}};
}

Json to_json(const msg::ObstacleStatus& obstacle) {
  return {{"name", obstacle.name()},          {"shape", obstacle.shape()},
          {"motion", obstacle.motion()},      {"attached_to", obstacle.attached_to()},
          {"xyz_rpy", pose(obstacle.X_WO())}, {"velocity", vector(obstacle.velocity().linear())},
          {"age_s", age(obstacle.age())}};
}

Json to_json(const msg::Separation& separation) {
  return {{"kind", text(separation.kind())},
          {"a", separation.a()},
          {"b", separation.b()},
          {"distance_m", separation.distance()},
          {"time_s", separation.time()}};
}

Json to_json(const msg::ContactReport& report) {
  Json json{{"contacts", report.contacts()},
            {"min_separation_m", report.has_smallest() ? Json(report.smallest().distance()) : Json(nullptr)},
            {"closest_pair", report.has_smallest() ? to_json(report.smallest()) : Json(nullptr)},
            {"time_s", report.time()}};
  json["kinds"] = Json::array();
  for (const msg::KindSummary& kind : report.kinds()) {
    json["kinds"].push_back({{"kind", text(kind.kind())},
                             {"contacts", kind.contacts()},
                             {"closest_pair", kind.has_smallest() ? to_json(kind.smallest()) : Json(nullptr)}});
  }
  json["events"] = list_json(report.events());
  return json;
}

Json orders_json(const msg::CellMode& mode) {
  Json json = Json::array();
  for (const msg::ArmOrder& order : mode.arms()) {
    json.push_back({{"arm", order.arm()},
                    {"mode", text(order.mode())},
                    {"ordered", text(order.ordered())},
                    {"cause", to_json(order.cause())}});
  }
  return json;
}

Json speeds_json(const msg::CellMode& mode) {
  Json json = Json::array();
  for (const msg::ArmSpeed& own : mode.speeds()) json.push_back({{"arm", own.arm()}, {"speed", own.speed()}});
  return json;
}

Json to_json(const msg::LostArm& lost) {
  return {
      {"arm", lost.arm()}, {"q", lost.q()}, {"qd", lost.qd()}, {"braking_delay_bound_s", lost.braking_delay_bound()}};
}

Json to_json(const msg::CellMode& mode) {
  return {{"mode", text(mode.mode())},
          {"held_arms", arms_on(mode, msg::Mode::MODE_HOLD)},
          {"lost_arms", list_json(mode.lost_arms())},
          {"stopped_arms", arms_on(mode, msg::Mode::MODE_STOP)},
          {"cause", to_json(mode.cause())},
          {"speed", mode.speed()},
          {"arm_speeds", speeds_json(mode)},
          {"arm_orders", orders_json(mode)},
          {"term", mode.term()}};
}

Json to_json(const msg::ToolState& tool) {
  return {{"arm", tool.arm()},
          {"moving", tool.moving()},
          {"width", tool.width() >= 0.0 ? Json(tool.width()) : Json(nullptr)},
          {"holding", tool.holding().empty() ? Json(nullptr) : Json(tool.holding())}};
}

void add_tools(Json& arms, const Tools& tools) {
  for (Json& arm : arms) {
    const auto tool = tools.find(arm["name"].get<std::string>());
    arm["tool"] = tool == tools.end() ? Json(nullptr) : to_json(tool->second);
  }
}

Json to_json(const msg::CellStatus& status) {
  Json json{{"cell", status.cell()}};
  json.update(to_json(status.mode()));
  json["supervisor"] = status.supervisor();
  json["standby"] = status.standby();
  json["uptime_s"] = status.uptime();
  json["arms"] = list_json(status.arms());
  json["nodes"] = list_json(status.nodes());
  json["hosts"] = list_json(status.hosts());
  json["faults"] = list_json(status.faults());
  json["contact_report"] = nullptr;
  if (status.has_contact_report()) {
    json["contact_report"] = to_json(status.contact_report());
    json["contact_report"]["age_s"] = age(status.contact_report_age());
  }
  json["obstacles"] = list_json(status.obstacles());
  return json;
}

}  // namespace hecaton::services::cli
