#include "services/replay/marks.hpp"

#include <algorithm>

#include "services/messages/names.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::replay {
namespace {

std::string with_cause(msg::Mode mode, const msg::Cause& cause) {
  return is_none(cause) ? text(mode) : text(mode) + ": " + cause.text();
}

std::string ended_text(const msg::GoalStatus& goal) {
  const std::string text = "goal " + goal.goal() + " " + msg::text(goal.state());
  return is_none(goal.cause()) ? text : text + ": " + goal.cause().text();
}

}  // namespace

void MarkFinder::add(Mark mark) {
  if (counts_[mark.kind] >= kMost) {
    ++left_out_;
    return;
  }
  ++counts_[mark.kind];
  marks_.push_back(std::move(mark));
}

void MarkFinder::take(const bus::Sample<msg::Fault>& sample) {
  if (sample.disposed) return;
  const msg::Fault& fault = sample.value;
  const auto [known, first] = faults_.try_emplace(fault.id());
  if (first && !fault.cleared()) {
    if (counts_[MarkKind::kFault] < kMost) known->second = marks_.size();
    add({MarkKind::kFault, sample.received, std::nullopt, fault.cause().subject(), fault.cause().text(),
         text(fault.severity())});
  } else if (fault.cleared() && known->second && !marks_[*known->second].until) {
    marks_[*known->second].until = sample.received;
  }
}

void MarkFinder::take(const bus::Sample<msg::GoalStatus>& sample) {
  if (sample.disposed) return;
  const msg::GoalStatus& goal = sample.value;
  const auto [known, first] = goals_.try_emplace({goal.arm(), goal.goal()}, goal.state());
  const bool ended_before = !first && is_final(known->second);
  known->second = goal.state();
  if (ended_before) return;
  if (first && !is_final(goal.state())) {
    add({MarkKind::kGoal, sample.received, std::nullopt, goal.arm(), "goal " + goal.goal() + " begun", {}});
  }
  // A goal that had ended when the recorder came is kept for late readers.
  if (is_final(goal.state()) && (!first || goal.state() == msg::GoalState::GOAL_REJECTED)) {
    add({MarkKind::kGoal, sample.received, std::nullopt, goal.arm(), ended_text(goal), {}});
  }
}

void MarkFinder::take_mode(const msg::CellMode& mode, bus::Clock::time_point at) {
  if (mode_ != mode.mode()) {
    mode_ = mode.mode();
    add({MarkKind::kMode, at, std::nullopt, {}, with_cause(mode.mode(), mode.cause()), {}});
  }
  std::map<std::string, msg::Mode> now;
  for (const msg::ArmOrder& order : mode.arms()) {
    now[order.arm()] = order.mode();
    const auto before = arms_.find(order.arm());
    if (before != arms_.end() && before->second == order.mode()) continue;
    add({MarkKind::kMode, at, std::nullopt, order.arm(), with_cause(order.mode(), order.cause()), {}});
  }
  for (const auto& [arm, before] : arms_) {
    if (!now.contains(arm)) add({MarkKind::kMode, at, std::nullopt, arm, text(msg::Mode::MODE_RUN), {}});
  }
  arms_ = std::move(now);
}

std::vector<Mark> MarkFinder::take_marks() {
  std::stable_sort(marks_.begin(), marks_.end(), [](const Mark& a, const Mark& b) { return a.at < b.at; });
  faults_.clear();
  return std::move(marks_);
}

}  // namespace hecaton::services::replay
