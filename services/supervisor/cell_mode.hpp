#pragma once
/// Whether the cell and each of its arms may move. Standard library only.
///
/// People's orders and automatic holds are kept apart: faults hold and release, people's orders last until people
/// withdraw them. Stop is latched: only resume ends it, and hold does not weaken it. A fault whose recovery is to wait
/// for people gives an order to hold in their place.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::services {

enum class MoveMode : std::uint8_t { kRun, kHold, kStop };  ///< the later, the stricter

[[nodiscard]] std::string_view mode_name(MoveMode mode);

/// People's orders, and those that faults gave in their place.
struct Orders {
  MoveMode cell = MoveMode::kRun;
  std::map<std::string, MoveMode, std::less<>> arms;  ///< those that have an order of their own: kHold or kStop
  bool operator==(const Orders&) const = default;
  [[nodiscard]] bool empty() const { return cell == MoveMode::kRun && arms.empty(); }
};

/// Of `orders`, those that `known` does not have, or has less strictly.
[[nodiscard]] Orders beyond(const Orders& orders, const Orders& known);

/// Of the orders that faults gave: what was seen, by arm; of the cell's under "".
using OrderCauses = std::map<std::string, std::string, std::less<>>;

/// What faults make of it.
struct AutomaticHolds {
  std::string cell;                                      ///< why the whole cell is held; empty: it is not
  std::map<std::string, std::string, std::less<>> arms;  ///< arm → why it is held
  bool operator==(const AutomaticHolds&) const = default;
};

/// What is published.
struct ModeDecision {
  MoveMode cell = MoveMode::kRun;
  std::vector<std::string> held_arms;     ///< beside the cell's mode, in the cell's order
  std::vector<std::string> stopped_arms;  ///< likewise
  std::string reason;                     ///< empty while everything may run
  bool operator==(const ModeDecision&) const = default;
};

class CellModeState {
 public:
  explicit CellModeState(std::vector<std::string> arms) : arms_(std::move(arms)) {}

  /// Orders for some arms, or for the whole cell when `arms` is empty. Returns the sentence that says why it was
  /// refused (nothing has changed then), or nothing.
  [[nodiscard]] std::string hold(const std::vector<std::string>& arms);
  [[nodiscard]] std::string stop(const std::vector<std::string>& arms);
  /// For the whole cell: withdraws its orders and the arms' holds; an arm that was stopped by name stays so until it is
  /// resumed by name, for whoever stopped it may stand beside it. For arms: refused while the whole cell is under an
  /// order.
  [[nodiscard]] std::string resume(const std::vector<std::string>& arms);

  /// For a fault, whose recovery is to wait for resume. `arm` empty: the whole cell.
  void hold_until_resumed(const std::string& arm, const std::string& why);

  void set_automatic(AutomaticHolds holds) { automatic_ = std::move(holds); }
  /// Orders of an earlier life or another's; those of unknown arms are dropped. Their causes, as far as we know any.
  void restore(const Orders& orders, const OrderCauses& causes = {});
  /// Also these orders; what is stricter already stays so. Those of unknown arms are dropped.
  void add(const Orders& orders);

  [[nodiscard]] const Orders& orders() const { return orders_; }
  [[nodiscard]] const OrderCauses& causes() const { return causes_; }
  [[nodiscard]] ModeDecision decide() const;
  /// The stricter of the cell's mode and the arm's own.
  [[nodiscard]] MoveMode mode_of(std::string_view arm) const;
  /// Why the arm may not move; empty when it may.
  [[nodiscard]] std::string reason_of(std::string_view arm) const;

 private:
  [[nodiscard]] std::string unknown(const std::vector<std::string>& arms) const;
  [[nodiscard]] MoveMode order_of(std::string_view arm) const;
  void order(const std::vector<std::string>& arms, MoveMode mode);
  /// "hold by operator", "hold until resumed: …".
  [[nodiscard]] std::string order_text(std::string_view arm) const;

  std::vector<std::string> arms_;
  Orders orders_;
  OrderCauses causes_;
  AutomaticHolds automatic_;
};

}  // namespace hecaton::services
