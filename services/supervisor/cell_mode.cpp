#include "services/supervisor/cell_mode.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::services {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void append(std::string& text, const std::string& part) {
  if (!text.empty()) text += "; ";
  text += part;
}

}  // namespace

std::string_view mode_name(MoveMode mode) {
  switch (mode) {
    case MoveMode::kRun:
      return "run";
    case MoveMode::kHold:
      return "hold";
    case MoveMode::kStop:
      return "stop";
  }
  return "unknown";
}

Orders beyond(const Orders& orders, const Orders& known) {
  Orders rest;
  if (orders.cell > known.cell) rest.cell = orders.cell;
  for (const auto& [arm, mode] : orders.arms) {
    const auto same = known.arms.find(arm);
    if (same == known.arms.end() || mode > same->second) rest.arms[arm] = mode;
  }
  return rest;
}

std::string CellModeState::unknown(const std::vector<std::string>& arms) const {
  for (const std::string& arm : arms) {
    if (std::find(arms_.begin(), arms_.end(), arm) == arms_.end()) {
      return "unknown arm " + arm + ": this cell's arms are " + listed(arms_);
    }
  }
  return {};
}

void CellModeState::order(const std::vector<std::string>& arms, MoveMode mode) {
  if (arms.empty()) orders_.cell = std::max(orders_.cell, mode);
  for (const std::string& arm : arms) {
    MoveMode& own = orders_.arms[arm];
    own = std::max(own, mode);
  }
}

std::string CellModeState::hold(const std::vector<std::string>& arms) {
  std::string refusal = unknown(arms);
  if (refusal.empty()) order(arms, MoveMode::kHold);
  return refusal;
}

std::string CellModeState::stop(const std::vector<std::string>& arms) {
  std::string refusal = unknown(arms);
  if (refusal.empty()) order(arms, MoveMode::kStop);
  return refusal;
}

std::string CellModeState::resume(const std::vector<std::string>& arms) {
  std::string refusal = unknown(arms);
  if (!refusal.empty()) return refusal;
  if (arms.empty()) {
    orders_.cell = MoveMode::kRun;
    std::erase_if(orders_.arms, [](const auto& order) { return order.second != MoveMode::kStop; });
    std::erase_if(causes_, [&](const auto& cause) { return order_of(cause.first) == MoveMode::kRun; });
    return {};
  }
  if (orders_.cell != MoveMode::kRun) {
    const std::string mode(mode_name(orders_.cell));
    return "the whole cell is on " + mode + ": resume the cell, then " + mode + " single arms if you wish";
  }
  for (const std::string& arm : arms) {
    orders_.arms.erase(arm);
    causes_.erase(arm);
  }
  return {};
}

void CellModeState::hold_until_resumed(const std::string& arm, const std::string& why) {
  order(arm.empty() ? std::vector<std::string>{} : std::vector{arm}, MoveMode::kHold);
  causes_[arm] = why;
}

void CellModeState::restore(const Orders& orders, const OrderCauses& causes) {
  orders_ = {};
  orders_.cell = orders.cell;
  for (const auto& [arm, mode] : orders.arms) {
    if (mode != MoveMode::kRun && std::find(arms_.begin(), arms_.end(), arm) != arms_.end()) orders_.arms[arm] = mode;
  }
  causes_.insert(causes.begin(), causes.end());
  std::erase_if(causes_, [&](const auto& cause) { return order_of(cause.first) == MoveMode::kRun; });
}

void CellModeState::add(const Orders& orders) {
  order({}, orders.cell);
  for (const auto& [arm, mode] : orders.arms) {
    if (mode != MoveMode::kRun && unknown({arm}).empty()) order({arm}, mode);
  }
}

MoveMode CellModeState::order_of(std::string_view arm) const {
  if (arm.empty()) return orders_.cell;
  const auto own = orders_.arms.find(arm);
  return own == orders_.arms.end() ? MoveMode::kRun : own->second;
}

std::string CellModeState::order_text(std::string_view arm) const {
  const std::string mode(mode_name(order_of(arm)));
  const auto cause = causes_.find(arm);
  return cause == causes_.end() ? mode + " by operator" : mode + " until resumed: " + cause->second;
}

ModeDecision CellModeState::decide() const {
  ModeDecision decision;
  decision.cell = std::max(orders_.cell, automatic_.cell.empty() ? MoveMode::kRun : MoveMode::kHold);
  if (orders_.cell != MoveMode::kRun) append(decision.reason, order_text({}));
  if (!automatic_.cell.empty()) append(decision.reason, automatic_.cell);
  for (const std::string& arm : arms_) {
    const MoveMode own = order_of(arm);
    const auto held = automatic_.arms.find(arm);
    if (own == MoveMode::kStop) {
      decision.stopped_arms.push_back(arm);
    } else if (own == MoveMode::kHold || held != automatic_.arms.end()) {
      decision.held_arms.push_back(arm);
    }
    if (own != MoveMode::kRun) append(decision.reason, arm + ": " + order_text(arm));
    if (held != automatic_.arms.end()) append(decision.reason, arm + ": " + held->second);
  }
  return decision;
}

MoveMode CellModeState::mode_of(std::string_view arm) const {
  const bool held = !automatic_.cell.empty() || automatic_.arms.contains(arm);
  return std::max({orders_.cell, order_of(arm), held ? MoveMode::kHold : MoveMode::kRun});
}

std::string CellModeState::reason_of(std::string_view arm) const {
  std::string reason;
  if (orders_.cell != MoveMode::kRun) {
    append(reason, "the cell is on " + order_text({}) + (causes_.contains("") ? "" : ": waits for resume"));
  }
  if (const MoveMode own = order_of(arm); own != MoveMode::kRun) {
    append(reason, "on " + order_text(arm) + (causes_.contains(arm) ? "" : ": waits for resume"));
  }
  if (!automatic_.cell.empty()) append(reason, "held: " + automatic_.cell);
  const auto held = automatic_.arms.find(arm);
  if (held != automatic_.arms.end()) append(reason, "held: " + held->second);
  return reason;
}

}  // namespace hecaton::services
