#include "services/supervisor/cell_mode.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "services/supervisor/clipped_text.hpp"

namespace hecaton::services {
namespace {

constexpr std::size_t kTextOfMode = 32768;  ///< of all causes of a cell mode, half of what its readers accept [byte]

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Appends a cause: the first one gives the kind, all give text.
void add_cause(msg::Cause& causes, msg::Cause cause) {
  if (is_none(cause)) return;
  if (is_none(causes)) {
    causes = std::move(cause);
  } else {
    causes.text() += "; " + cause.text();
  }
}

msg::Cause with_text(msg::Cause cause, std::string text) {
  cause.text(std::move(text));
  return cause;
}

/// Between the mode and the fault that ordered it.
constexpr std::string_view kUntilResumed = " until resumed: ";

}  // namespace

CausesByArm device_causes_in(const msg::CellMode& mode) {
  CausesByArm causes;
  for (const msg::ArmOrder& order : mode.arms()) {
    if (order.ordered() == msg::Mode::MODE_RUN || !is_for_device(order.cause(), order.arm())) continue;
    std::string text = order.cause().text();
    const std::string prefix = std::string(mode_name(order.ordered())) + std::string(kUntilResumed);
    if (text.starts_with(prefix)) text.erase(0, prefix.size());
    causes[order.arm()] = with_text(order.cause(), std::move(text));
  }
  return causes;
}

msg::Cause CellModeState::unknown(const std::vector<std::string>& arms) const {
  for (const std::string& arm : arms) {
    if (std::find(arms_.begin(), arms_.end(), arm) != arms_.end()) continue;
    return make_cause(msg::CauseKind::CAUSE_UNKNOWN_NAME, arm,
                      "unknown arm " + arm + ": this cell's arms are " + listed(arms_));
  }
  return {};
}

void CellModeState::tighten(const std::string& arm, msg::Mode mode) {
  msg::Mode& own = arm.empty() ? orders_.cell : orders_.arms[arm];
  own = std::max(own, mode);
}

msg::Cause CellModeState::order(const std::vector<std::string>& arms, msg::Mode mode) {
  msg::Cause refusal = unknown(arms);
  if (!is_none(refusal)) return refusal;
  if (arms.empty()) tighten({}, mode);
  for (const std::string& arm : arms) tighten(arm, mode);
  return refusal;
}

msg::Cause CellModeState::resume(const std::vector<std::string>& arms) {
  msg::Cause refusal = unknown(arms);
  if (!is_none(refusal)) return refusal;
  if (arms.empty()) {
    orders_.cell = msg::Mode::MODE_RUN;
    std::erase_if(orders_.arms, [&](const auto& order) {
      return order.second != msg::Mode::MODE_STOP && !is_for_device(order_cause(order.first), order.first);
    });
    std::erase_if(causes_, [&](const auto& cause) { return order_of(cause.first) == msg::Mode::MODE_RUN; });
    return refusal;
  }
  if (orders_.cell != msg::Mode::MODE_RUN) {
    const std::string mode(mode_name(orders_.cell));
    return make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, {},
                      "the whole cell is on " + mode + ": resume the cell, then " + mode + " single arms if needed");
  }
  for (const std::string& arm : arms) {
    const auto held = automatic_.arms.find(arm);
    if (held == automatic_.arms.end() || !is_for_device(held->second, arm)) continue;
    return make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, arm,
                      "the fault of its device lasts, so that no arm was resumed: " + held->second.text());
  }
  for (const std::string& arm : arms) {
    orders_.arms.erase(arm);
    causes_.erase(arm);
  }
  return refusal;
}

msg::Cause CellModeState::refuse_speed(const std::vector<std::string>& arms, double speed) const {
  msg::Cause refusal = unknown(arms);
  if (!is_none(refusal)) return refusal;
  if (speed >= kSlowestSpeed && speed <= kFullSpeed) return refusal;  // false for NaN
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "speed %.6g %% must be 1 %% to 100 %%; nothing was changed", 100.0 * speed);
  return make_cause(msg::CauseKind::CAUSE_INVALID_VALUE, {}, text.data());
}

msg::Cause CellModeState::set_speed(const std::vector<std::string>& arms, double speed) {
  msg::Cause refusal = refuse_speed(arms, speed);
  if (!is_none(refusal)) return refusal;
  if (arms.empty()) orders_.speed = speed;
  for (const std::string& arm : arms) {
    orders_.speeds.erase(arm);
    lower_speed(arm, speed);
  }
  return refusal;
}

msg::Cause CellModeState::slow_down(const std::vector<std::string>& arms, double speed) {
  msg::Cause refusal = refuse_speed(arms, speed);
  if (!is_none(refusal)) return refusal;
  if (arms.empty()) lower_speed({}, speed);
  for (const std::string& arm : arms) lower_speed(arm, speed);
  return refusal;
}

void CellModeState::lower_speed(const std::string& arm, double speed) {
  if (!(speed >= kSlowestSpeed && speed < kFullSpeed)) return;
  double& own = arm.empty() ? orders_.speed : orders_.speeds.try_emplace(arm, kFullSpeed).first->second;
  own = std::min(own, speed);
}

void CellModeState::hold_until_resumed(const std::string& arm, const msg::Cause& cause) {
  tighten(arm, msg::Mode::MODE_HOLD);
  add_order_cause(arm, cause);
}

void CellModeState::add_order_cause(const std::string& arm, const msg::Cause& cause) {
  msg::Cause& own = causes_[arm];
  if (!is_for_device(own, arm) || is_for_device(cause, arm)) own = cause;
}

void CellModeState::restore(const Orders& orders, const CausesByArm& causes) {
  orders_ = {};
  add(orders);
  for (const auto& [arm, cause] : causes) add_order_cause(arm, cause);
  std::erase_if(causes_, [&](const auto& cause) { return order_of(cause.first) == msg::Mode::MODE_RUN; });
}

void CellModeState::add(const Orders& orders) {
  tighten({}, orders.cell);
  for (const auto& [arm, mode] : orders.arms) {
    if (mode != msg::Mode::MODE_RUN && is_none(unknown({arm}))) tighten(arm, mode);
  }
  lower_speed({}, orders.speed);
  for (const auto& [arm, speed] : orders.speeds) {
    if (is_none(unknown({arm}))) lower_speed(arm, speed);
  }
}

msg::Mode CellModeState::order_of(std::string_view arm) const {
  if (arm.empty()) return orders_.cell;
  const auto own = orders_.arms.find(arm);
  return own == orders_.arms.end() ? msg::Mode::MODE_RUN : own->second;
}

msg::Cause CellModeState::order_cause(std::string_view arm) const {
  const msg::Mode order = order_of(arm);
  if (order == msg::Mode::MODE_RUN) return {};
  const std::string mode(mode_name(order));
  const auto cause = causes_.find(arm);
  if (cause != causes_.end()) return with_text(cause->second, mode + std::string(kUntilResumed) + cause->second.text());
  const bool stop = order == msg::Mode::MODE_STOP;
  return make_cause(stop ? msg::CauseKind::CAUSE_STOP_ORDERED : msg::CauseKind::CAUSE_HOLD_ORDERED, std::string(arm),
                    mode + " by operator");
}

bool CellModeState::is_ordered_for(const msg::Cause& cause, std::string_view arm) const {
  const auto ordered = causes_.find(arm);
  return ordered != causes_.end() && ordered->second == cause;
}

msg::CellMode CellModeState::decide() const {
  const auto strictest = [](msg::Mode ordered, bool held) {
    return std::max(ordered, held ? msg::Mode::MODE_HOLD : msg::Mode::MODE_RUN);
  };
  msg::CellMode decision;
  decision.mode(strictest(orders_.cell, automatic_.cell.has_value()));
  decision.ordered(orders_.cell);
  decision.cause(order_cause({}));
  if (automatic_.cell) add_cause(decision.cause(), *automatic_.cell);
  for (const std::string& arm : arms_) {
    const msg::Mode own = order_of(arm);
    const auto held = automatic_.arms.find(arm);
    if (own == msg::Mode::MODE_RUN && held == automatic_.arms.end()) continue;
    msg::ArmOrder& order = decision.arms().emplace_back();
    order.arm(arm);
    order.mode(strictest(own, held != automatic_.arms.end()));
    order.ordered(own);
    order.cause(order_cause(arm));
    if (held != automatic_.arms.end() && !is_ordered_for(held->second, arm)) add_cause(order.cause(), held->second);
  }
  const std::size_t most = std::min(kLongestReason, kTextOfMode / (decision.arms().size() + 1));
  decision.cause().text() = clipped(decision.cause().text(), most);
  for (msg::ArmOrder& order : decision.arms()) order.cause().text() = clipped(order.cause().text(), most);
  decision.speed(orders_.speed);
  for (const auto& [arm, speed] : orders_.speeds) {
    msg::ArmSpeed& own = decision.speeds().emplace_back();
    own.arm(arm);
    own.speed(speed);
  }
  return decision;
}

msg::Mode CellModeState::mode_of(std::string_view arm) const {
  const bool held = automatic_.cell || automatic_.arms.contains(arm);
  return std::max({orders_.cell, order_of(arm), held ? msg::Mode::MODE_HOLD : msg::Mode::MODE_RUN});
}

msg::Cause CellModeState::cause_of(std::string_view arm) const {
  msg::Cause causes;
  const auto add_order = [&](std::string_view whose, const char* prefix) {
    msg::Cause cause = order_cause(whose);
    std::string text = prefix + cause.text() + (causes_.contains(whose) ? "" : ": waits for resume");
    if (!is_none(cause)) add_cause(causes, with_text(std::move(cause), std::move(text)));
  };
  add_order({}, "the cell is on ");
  add_order(arm, "on ");
  if (automatic_.cell) add_cause(causes, with_text(*automatic_.cell, "held: " + automatic_.cell->text()));
  const auto held = automatic_.arms.find(arm);
  if (held != automatic_.arms.end() && !is_ordered_for(held->second, arm)) {
    add_cause(causes, with_text(held->second, "held: " + held->second.text()));
  }
  return causes;
}

}  // namespace hecaton::services
