#pragma once
/// Operator orders (run, hold, stop, speed override) as values. Standard library and the generated values only.

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <idl/health.h>

#include "services/runtime/cause.hpp"

namespace hecaton::services {

/// "run", "hold" or "stop", as in logs and checkpoints.
[[nodiscard]] inline std::string_view mode_name(msg::Mode mode) {
  switch (mode) {
    case msg::Mode::MODE_RUN:
      return "run";
    case msg::Mode::MODE_HOLD:
      return "hold";
    case msg::Mode::MODE_STOP:
      return "stop";
  }
  return "unknown";
}

/// Limits of a speed override: share of an arm's velocity limits.
inline constexpr double kSlowestSpeed = 0.01;
inline constexpr double kFullSpeed = 1.0;

/// The operators' orders for the cell and its arms. Of two modes the greater is the stricter, of two speeds the lower.
struct Orders {
  msg::Mode cell = msg::Mode::MODE_RUN;
  std::map<std::string, msg::Mode, std::less<>> arms;  ///< arms with an order of their own: hold or stop
  double speed = kFullSpeed;                           ///< of the cell, kSlowestSpeed to kFullSpeed
  std::map<std::string, double, std::less<>> speeds;   ///< arms with an override of their own, below kFullSpeed
  bool operator==(const Orders&) const = default;
  [[nodiscard]] bool empty() const { return *this == Orders{}; }
  /// The lower of the cell's speed and the arm's own.
  [[nodiscard]] double speed_of(std::string_view arm) const {
    const auto own = speeds.find(arm);
    return own == speeds.end() ? speed : std::min(speed, own->second);
  }
};

/// The part of `orders` that `known` lacks or has less strictly.
[[nodiscard]] inline Orders beyond(const Orders& orders, const Orders& known) {
  Orders rest;
  if (orders.cell > known.cell) rest.cell = orders.cell;
  for (const auto& [arm, mode] : orders.arms) {
    const auto same = known.arms.find(arm);
    if (same == known.arms.end() || mode > same->second) rest.arms[arm] = mode;
  }
  if (orders.speed < known.speed) rest.speed = orders.speed;
  for (const auto& [arm, speed] : orders.speeds) {
    const auto same = known.speeds.find(arm);
    if (same == known.speeds.end() || speed < same->second) rest.speeds[arm] = speed;
  }
  return rest;
}

/// The operators' orders in a cell mode.
[[nodiscard]] inline Orders orders_in(const msg::CellMode& mode) {
  Orders orders;
  orders.cell = mode.ordered();
  for (const msg::ArmOrder& arm : mode.arms()) {
    if (arm.ordered() != msg::Mode::MODE_RUN) orders.arms[arm.arm()] = arm.ordered();
  }
  orders.speed = mode.speed();
  for (const msg::ArmSpeed& arm : mode.speeds()) orders.speeds[arm.arm()] = arm.speed();
  return orders;
}

/// The speed override in force for an arm: the lower of the cell's and the arm's own.
[[nodiscard]] inline double speed_in(const msg::CellMode& mode, std::string_view arm) {
  double speed = mode.speed();
  for (const msg::ArmSpeed& own : mode.speeds()) {
    if (own.arm() == arm) speed = std::min(speed, own.speed());
  }
  return speed;
}

/// The arm's own order, null when it has none. Valid as long as `mode`.
[[nodiscard]] inline const msg::ArmOrder* order_in(const msg::CellMode& mode, std::string_view arm) {
  const auto found = std::find_if(mode.arms().begin(), mode.arms().end(),
                                  [&](const msg::ArmOrder& order) { return order.arm() == arm; });
  return found == mode.arms().end() ? nullptr : &*found;
}

/// True when `cause` holds `arm` for a fault of its own device. Such a fault has the arm as its subject.
[[nodiscard]] inline bool is_for_device(const msg::Cause& cause, std::string_view arm) {
  return cause.kind() == msg::CauseKind::CAUSE_HELD_BY_FAULT && cause.subject() == arm;
}

/// True while a fault of the arm's own device holds it, or its hold waits for a person.
[[nodiscard]] inline bool is_held_for_device(const msg::CellMode& mode, std::string_view arm) {
  const msg::ArmOrder* own = order_in(mode, arm);
  return own && is_for_device(own->cause(), arm);
}

/// The arms whose own order is exactly `what`, in the order of the cell file.
[[nodiscard]] inline std::vector<std::string> arms_on(const msg::CellMode& mode, msg::Mode what) {
  std::vector<std::string> names;
  for (const msg::ArmOrder& order : mode.arms()) {
    if (order.mode() == what) names.push_back(order.arm());
  }
  return names;
}

/// Why the cell and its arms do not run: "hold by operator; arm1: stop by operator".
[[nodiscard]] inline std::string causes_text(const msg::CellMode& mode) {
  std::string text = mode.cause().text();
  for (const msg::ArmOrder& order : mode.arms()) {
    text += (text.empty() ? "" : "; ") + order.arm() + ": " + order.cause().text();
  }
  return text;
}

}  // namespace hecaton::services
