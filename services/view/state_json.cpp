#include "services/view/state_json.hpp"

#include <algorithm>
#include <chrono>

#include "services/messages/convert.hpp"
#include "services/messages/names.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/standstill.hpp"
#include "services/view/cell_json.hpp"

namespace hecaton::services::view {
namespace {

using Milliseconds = std::chrono::duration<double, std::milli>;

/// The page shows so many faults at most, the newest.
constexpr std::size_t kMostFaults = 256;

double milliseconds(bus::Clock::duration duration) {
  return rounded(Milliseconds(duration).count(), 10.0);
}

Json rounded_list(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(rounded(value));
  return json;
}

/// As pose_json(), from a message.
Json message_pose(const msg::Pose& pose) {
  const msg::Vec3& p = pose.position();
  return rounded_list({p.x(), p.y(), p.z(), pose.qx(), pose.qy(), pose.qz(), pose.qw()});
}

Json cause(const msg::Cause& cause) {
  if (is_none(cause)) return nullptr;
  return {{"kind", cause_name(cause.kind())}, {"subject", cause.subject()}, {"text", cause.text()}};
}

Json goal(const msg::GoalStatus& goal) {
  Json json{{"id", goal.goal()},
            {"state", text(goal.state())},
            {"final", is_final(goal.state())},
            {"cause", cause(goal.cause())},
            {"action", goal.recovery_action()},
            {"blocked", rounded(goal.blocked_duration(), 10.0)},
            {"distance", rounded(goal.distance_to_goal(), 1e3)},
            {"elapsed", rounded(goal.elapsed(), 10.0)},
            {"note", goal.note()},
            {"q", rounded_list(goal.q_goal())}};
  json["binding"] = nullptr;
  if (goal.has_binding()) {
    json["binding"] = {
        {"own", goal.binding_own()}, {"other", goal.binding_other()}, {"distance", rounded(goal.binding_distance())}};
  }
  return json;
}

Json arm(const CellState& cell, const std::string& name, bus::Clock::time_point now) {
  Json json{{"name", name},
            {"mode", text(cell.mode().order(name))},
            {"speed_override", cell.mode().speed(name)},
            {"waiting", cause(cell.waiting_for(name, now))},
            {"planner", cell.planner_of(name)},
            {"drive", nullptr},
            {"goal", nullptr},
            {"tool", nullptr},
            {"lost", cell.mode().lost(name) != nullptr}};
  if (const auto* state = cell.state(name)) {
    double speed = 0.0;
    for (const double v : state->value.qd()) speed = std::max(speed, std::abs(v));
    json["drive"] = text(state->value.mode());
    json["moving"] = moves(state->value, cell.mode().speed(name));
    json["speed"] = rounded(speed, 1e3);
    json["carried"] = state->value.carried();
    json["command_age"] = rounded(state->value.command_age(), 1e4);
  }
  if (const auto* tool = cell.tool(name); tool != nullptr && tool->value.has_gripper()) {
    const msg::ToolState& value = tool->value;
    json["tool"] = {{"moving", value.moving()},
                    {"width", value.width() >= 0.0 ? Json(rounded(value.width())) : Json(nullptr)},
                    {"holding", value.holding()}};
  }
  if (const auto* newest = cell.goal(name)) json["goal"] = goal(newest->value);
  return json;
}

Json node(const CellState& cell, const bus::Sample<msg::Heartbeat>& sample, bus::Clock::time_point now) {
  const msg::Heartbeat& heartbeat = sample.value;
  return {{"name", heartbeat.node()},
          {"kind", text(heartbeat.kind())},
          {"host", heartbeat.host()},
          {"pid", heartbeat.pid()},
          {"state", text(heartbeat.state())},
          {"alive", cell.alive(sample, now)},
          {"age", milliseconds(sample.age(now))},
          {"cause", cause(heartbeat.cause())},
          {"tick", {rounded(heartbeat.tick_p50_us(), 10), rounded(heartbeat.tick_p99_us(), 10)}},
          {"late", rounded(heartbeat.lateness_max_us(), 10)},
          {"input", heartbeat.oldest_input()},
          {"input_age", rounded(heartbeat.oldest_input_age(), 1e4)},
          {"memory", heartbeat.rss_bytes()}};
}

/// The newest first.
Json faults(const LatestFaults& latest) {
  std::vector<const msg::Fault*> all;
  for (const auto& [id, fault] : latest.all()) all.push_back(&fault);
  std::sort(all.begin(), all.end(),
            [](const auto* a, const auto* b) { return a->since_unix_ms() > b->since_unix_ms(); });
  Json json = Json::array();
  for (const msg::Fault* fault : all) {
    if (json.size() == kMostFaults) break;
    const double end = fault->cleared() ? static_cast<double>(fault->cleared_ns() - fault->since_ns()) * 1e-9 : -1.0;
    json.push_back({{"id", fault->id()},
                    {"severity", text(fault->severity())},
                    {"kind", cause_name(fault->cause().kind())},
                    {"subject", fault->cause().subject()},
                    {"text", fault->cause().text()},
                    {"since", fault->since_unix_ms()},
                    {"duration", fault->cleared() ? Json(rounded(end, 1e3)) : Json(nullptr)}});
  }
  return json;
}

Json separation(const msg::Separation& separation) {
  return {{"a", separation.a()}, {"b", separation.b()}, {"distance", rounded(separation.distance())}};
}

Json contacts(const CellState& cell) {
  const auto* report = cell.contacts();
  if (report == nullptr) return nullptr;
  return {{"count", report->value.contacts()},
          {"smallest", report->value.has_smallest() ? separation(report->value.smallest()) : Json(nullptr)}};
}

}  // namespace

Json frame_json(const CellFeed& feed, bus::Clock::duration t) {
  const CellState& cell = feed.state();
  const auto now = feed.now();
  Json json{{"type", "frame"}, {"t", milliseconds(t)}, {"rate", feed.rate()}, {"leaps", feed.leaps()}};
  Json arms = Json::array();
  for (const planner::PlannedArm& planned : cell.file().cell.arms) {
    const auto* state = cell.state(planned.arm.name);
    // An age of null: nothing was received. Then the page shows the start position as unknown.
    arms.push_back(state == nullptr ? Json{nullptr, Json::array(), 0}
                                    : Json{milliseconds(state->age(now)), rounded_list(state->value.q()),
                                           state->value.sequence_number()});
  }
  json["arms"] = std::move(arms);
  json["obstacle_age"] = nullptr;
  json["obstacles"] = Json::object();
  if (const auto* states = cell.obstacle_states()) {
    json["obstacle_age"] = milliseconds(states->age(now));
    for (const msg::ObstacleState& state : states->value.states())
      json["obstacles"][state.name()] = message_pose(state.X_WO());
  }
  return json;
}

Json status_json(const CellFeed& feed, bus::Clock::duration t) {
  const CellState& cell = feed.state();
  const auto now = feed.now();
  const msg::CellMode& mode = cell.mode().mode();
  Json json{{"type", "status"},
            {"t", milliseconds(t)},
            {"wall", feed.unix_time().count()},
            {"mode", cell.mode().heard() ? Json(text(mode.mode())) : Json(nullptr)},
            {"mode_age", cell.mode().heard() ? Json(milliseconds(now - cell.mode().received())) : Json(nullptr)},
            {"cause", cause(mode.cause())},
            {"speed_override", cell.mode().heard() ? Json(mode.speed()) : Json(nullptr)},
            {"term", mode.term()},
            {"supervisor", mode.node()},
            {"contacts", contacts(cell)},
            {"faults", faults(cell.faults())}};
  json["arms"] = Json::array();
  for (const planner::PlannedArm& planned : cell.file().cell.arms) {
    json["arms"].push_back(arm(cell, planned.arm.name, now));
  }
  json["nodes"] = Json::array();
  for (const auto& [name, sample] : cell.heartbeats()) json["nodes"].push_back(node(cell, sample, now));
  return json;
}

Json obstacles_json(const CellState& cell) {
  Json json{{"type", "obstacles"}, {"obstacles", Json::array()}};
  for (const auto& [name, message] : cell.obstacles()) {
    const auto obstacle = messages::from_message(message);
    if (!obstacle) continue;
    Json shapes = Json::array();
    for (const world::PlacedShape& placed : obstacle->shapes) shapes.push_back(shape_json(placed.shape, placed.X_BS));
    json["obstacles"].push_back({{"name", name},
                                 {"shapes", shapes},
                                 {"pose", pose_json(obstacle->X_WO)},
                                 {"motion", text(message.motion().kind())},
                                 {"attached_to", message.attached_to()}});
  }
  return json;
}

}  // namespace hecaton::services::view
