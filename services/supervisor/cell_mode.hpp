#pragma once
/// Whether the cell and each of its arms may move. Pure.
///
/// People's orders and automatic holds are kept apart: faults hold and release, people's orders last until people
/// withdraw them. Stop is latched: only resume ends it, and hold does not weaken it. A fault whose recovery is to wait
/// for people gives an order to hold in their place.

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

/// What faults hold.
struct AutomaticHolds {
  std::optional<msg::Cause> cell;  ///< why the whole cell is held; empty: it is not
  CausesByArm arms;                ///< the arms that are held
  bool operator==(const AutomaticHolds&) const = default;
};

class CellModeState {
 public:
  explicit CellModeState(std::vector<std::string> arms) : arms_(std::move(arms)) {}

  /// Orders for some arms, or for the whole cell when `arms` is empty. Returns why the order was refused (then nothing
  /// has changed), or CAUSE_NONE.
  [[nodiscard]] msg::Cause hold(const std::vector<std::string>& arms) { return order(arms, msg::Mode::MODE_HOLD); }
  [[nodiscard]] msg::Cause stop(const std::vector<std::string>& arms) { return order(arms, msg::Mode::MODE_STOP); }
  /// For the whole cell: withdraws its orders and the arms' holds. An arm that was stopped by name stays stopped until
  /// it is resumed by name: the person who stopped it may stand beside it. For arms: refused while the whole cell is
  /// under an order.
  [[nodiscard]] msg::Cause resume(const std::vector<std::string>& arms);

  /// For a fault whose recovery is to wait for resume. `arm` empty: the whole cell.
  void hold_until_resumed(const std::string& arm, const msg::Cause& cause);

  void set_automatic(AutomaticHolds holds) { automatic_ = std::move(holds); }
  /// Replaces the orders by those of an earlier life or of another leader; orders of unknown arms are dropped.
  /// `causes`: of the orders that faults gave, as far as they are known.
  void restore(const Orders& orders, const CausesByArm& causes = {});
  /// Adds these orders; what is stricter already stays so. Orders of unknown arms are dropped.
  void add(const Orders& orders);

  [[nodiscard]] const Orders& orders() const { return orders_; }
  /// Of the orders that faults gave, by arm; the cell's under "".
  [[nodiscard]] const CausesByArm& causes() const { return causes_; }
  /// What is to be published: modes, orders and causes of the cell and of its arms; the rest is left to the caller.
  [[nodiscard]] msg::CellMode decide() const;
  /// The stricter of the cell's mode and the arm's own.
  [[nodiscard]] msg::Mode mode_of(std::string_view arm) const;
  /// Why the arm may not move; CAUSE_NONE when it may.
  [[nodiscard]] msg::Cause cause_of(std::string_view arm) const;

 private:
  [[nodiscard]] msg::Cause unknown(const std::vector<std::string>& arms) const;
  [[nodiscard]] msg::Mode order_of(std::string_view arm) const;
  [[nodiscard]] msg::Cause order(const std::vector<std::string>& arms, msg::Mode mode);
  void tighten(const std::string& arm, msg::Mode mode);
  /// "hold by operator", "hold until resumed: …"; CAUSE_NONE without an order.
  [[nodiscard]] msg::Cause order_cause(std::string_view arm) const;

  std::vector<std::string> arms_;
  Orders orders_;
  CausesByArm causes_;
  AutomaticHolds automatic_;
};

}  // namespace hecaton::services
