#pragma once
/// Whether the cell and each of its arms may move. Pure.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/runtime/orders.hpp"

namespace hecaton::services {

/// Causes by arm.
using CausesByArm = std::map<std::string, msg::Cause, std::less<>>;

/// The causes of those orders in a published cell mode that faults of devices gave, by arm.
[[nodiscard]] CausesByArm device_causes_in(const msg::CellMode& mode);

/// What faults hold, derived again in each turn.
struct AutomaticHolds {
  std::optional<msg::Cause> cell;  ///< why the whole cell is held; empty: it is not
  CausesByArm arms;                ///< held arms
  bool operator==(const AutomaticHolds&) const = default;
};

/// People's orders and automatic holds. They are independent: an automatic hold ends with its fault, an order when a
/// person resumes. Stop is latched: only resume ends it, and hold does not weaken it. A fault that waits for resume
/// orders hold as a person does.
class CellModeState {
 public:
  explicit CellModeState(std::vector<std::string> arms) : arms_(std::move(arms)) {}

  /// Orders for some arms; `arms` empty: for the whole cell. Returns CAUSE_NONE, or why the order was refused; then
  /// nothing has changed.
  [[nodiscard]] msg::Cause hold(const std::vector<std::string>& arms) { return order(arms, msg::Mode::MODE_HOLD); }
  [[nodiscard]] msg::Cause stop(const std::vector<std::string>& arms) { return order(arms, msg::Mode::MODE_STOP); }
  /// Of the whole cell: withdraws its order and the holds of arms. An arm that was stopped by name, or that is held for
  /// a fault of its device, must be resumed by name, because a person may stand beside it. Of arms: refused while the
  /// whole cell is under an order, and while the fault of a device lasts.
  [[nodiscard]] msg::Cause resume(const std::vector<std::string>& arms);

  /// Sets the speed override of the cell or of some arms, from kSlowestSpeed to kFullSpeed. Hold, stop and resume do
  /// not change it. The override of the cell does not change those of arms: the lower one is in force. Returns
  /// CAUSE_NONE, or why the order was refused; then nothing has changed.
  [[nodiscard]] msg::Cause set_speed(const std::vector<std::string>& arms, double speed);
  /// The same, but lowers overrides only.
  [[nodiscard]] msg::Cause slow_down(const std::vector<std::string>& arms, double speed);

  /// Orders hold for a fault that waits for resume. `arm` empty: the whole cell.
  void hold_until_resumed(const std::string& arm, const msg::Cause& cause);

  void set_automatic(AutomaticHolds holds) { automatic_ = std::move(holds); }
  /// Replaces the orders by those of a checkpoint or of another leader. Ignores unknown arms. `causes`: of orders that
  /// faults gave.
  void restore(const Orders& orders, const CausesByArm& causes = {});
  /// Adds orders; stricter ones stay. Ignores unknown arms.
  void add(const Orders& orders);

  [[nodiscard]] const Orders& orders() const { return orders_; }
  /// Causes of the orders that faults gave, by arm; "": of the cell.
  [[nodiscard]] const CausesByArm& causes() const { return causes_; }
  /// Modes, orders, causes and speed overrides of the cell and its arms. The caller sets the other fields.
  [[nodiscard]] msg::CellMode decide() const;
  /// The stricter of the cell's mode and the arm's own.
  [[nodiscard]] msg::Mode mode_of(std::string_view arm) const;
  /// The lower of the cell's speed override and the arm's own.
  [[nodiscard]] double speed_of(std::string_view arm) const { return orders_.speed_of(arm); }
  /// Why the arm may not move; CAUSE_NONE when it may.
  [[nodiscard]] msg::Cause cause_of(std::string_view arm) const;

 private:
  [[nodiscard]] msg::Cause unknown(const std::vector<std::string>& arms) const;
  [[nodiscard]] msg::Mode order_of(std::string_view arm) const;
  [[nodiscard]] msg::Cause order(const std::vector<std::string>& arms, msg::Mode mode);
  [[nodiscard]] msg::Cause refuse_speed(const std::vector<std::string>& arms, double speed) const;
  void tighten(const std::string& arm, msg::Mode mode);
  void lower_speed(const std::string& arm, double speed);
  /// A cause of the arm's device stays until the arm is resumed by name: no other kind replaces it.
  void add_order_cause(const std::string& arm, const msg::Cause& cause);
  /// Text: "hold by operator" or "hold until resumed: …". CAUSE_NONE without an order.
  [[nodiscard]] msg::Cause order_cause(std::string_view arm) const;
  /// The fault that gave the arm's order has this cause: the text has it once.
  [[nodiscard]] bool is_ordered_for(const msg::Cause& cause, std::string_view arm) const;

  std::vector<std::string> arms_;
  Orders orders_;
  CausesByArm causes_;
  AutomaticHolds automatic_;
};

}  // namespace hecaton::services
