#pragma once
/// What became of goals, as a planner that stands by knows it, until the planner in charge has told it: an end that
/// the dead one could not tell any more is told by its successor.

#include <algorithm>
#include <cstddef>
#include <deque>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <idl/goal.h>

#include "services/planner/goal_account.hpp"
#include "services/runtime/goal_state.hpp"

namespace hecaton::services {

class UnsaidStatuses {
 public:
  static constexpr std::size_t kRemembered = 8;  ///< of each kind; a planner's clients are kept no more, either

  /// Would have been told now. What is not an end is not kept: while it lasts it is told again and again.
  void keep(std::vector<msg::GoalStatus> statuses) {
    for (msg::GoalStatus& status : statuses) {
      const bool told = std::find(told_.begin(), told_.end(), status.goal()) != told_.end();
      if (is_over(status.state()) && !told) unsaid_.push_back(std::move(status));
    }
    while (unsaid_.size() > kRemembered) unsaid_.pop_front();
  }

  /// The planner in charge told this.
  void heard(const msg::GoalStatus& status) {
    if (!is_over(status.state())) return;
    std::erase_if(unsaid_, [&](const msg::GoalStatus& own) { return own.goal() == status.goal(); });
    told_.push_back(status.goal());
    if (told_.size() > kRemembered) told_.pop_front();
  }

  /// The ends that are left to be told, the oldest first.
  [[nodiscard]] std::vector<GoalAccount::End> ends() const {
    std::vector<GoalAccount::End> ends;
    for (const msg::GoalStatus& status : unsaid_) ends.push_back({status.goal(), status.state()});
    return ends;
  }

  /// We are in charge now: what is left to be told, oldest first.
  [[nodiscard]] std::vector<msg::GoalStatus> take() {
    auto left = std::exchange(unsaid_, {});
    return {std::make_move_iterator(left.begin()), std::make_move_iterator(left.end())};
  }

 private:
  std::deque<msg::GoalStatus> unsaid_;
  std::deque<std::string> told_;
};

}  // namespace hecaton::services
