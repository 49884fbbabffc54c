#pragma once
/// Orders that the other supervisor is not known to have heard: given while it was cut off, hung or not there. Who
/// stands back gives them once more to who leads then; a stop would be gone otherwise when a partition heals.
///
/// In doubt an order counts as unheard: what people have resumed on the other side meanwhile may then have to be
/// resumed once more.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "services/runtime/orders.hpp"

namespace hecaton::services {

class OrderLegacy {
 public:
  /// `left`: by an earlier life.
  explicit OrderLegacy(Orders left = {}) : left_(std::move(left)) {}

  /// We lead now, and have what was left. Nobody is known to have heard any order of this term yet.
  void begin_to_lead() {
    left_ = known_ = told_ = {};
    since_ = 0;
    again_ = true;
  }
  /// People gave this order, perhaps not for the first time: somebody may have withdrawn it unheard meanwhile. No arms:
  /// of the whole cell.
  void given(const std::vector<std::string>& arms) {
    again_ = true;
    if (arms.empty()) known_.cell = msg::Mode::MODE_RUN;
    for (const std::string& arm : arms) known_.arms.erase(arm);
  }
  /// The orders in the cell mode of this number.
  void published(const Orders& orders, std::uint64_t mode) {
    if (!std::exchange(again_, false) && orders == told_) return;
    told_ = orders;
    since_ = mode;
  }
  /// The other supervisor stands by and has heard the cell mode of this number. True when it has heard news with it.
  bool heard(std::uint64_t mode) {
    if (again_ || mode < since_ || known_ == told_) return false;
    known_ = told_;
    return true;
  }
  /// Of these orders, those that it is not known to have heard.
  [[nodiscard]] Orders unheard(const Orders& orders) const { return beyond(orders, known_); }

  /// We lead no more.
  void stand_back(const Orders& orders) { left_ = unheard(orders); }
  /// Who leads tells these orders. True when nothing is left of what there was.
  bool strike_out(const Orders& told) {
    if (left_.empty()) return false;
    left_ = beyond(left_, told);
    return left_.empty();
  }
  /// To be given once more to who leads.
  [[nodiscard]] const Orders& left() const { return left_; }

 private:
  Orders left_;
  Orders known_;             // to the other, under our term
  Orders told_;              // in the last cell mode
  std::uint64_t since_ = 0;  // number of the first cell mode with these
  bool again_ = true;        // the next cell mode counts as such
};

}  // namespace hecaton::services
