#include "services/planner/obstacle_view.hpp"

#include <algorithm>
#include <utility>

#include "services/messages/convert.hpp"

namespace hecaton::services {

ObstacleView::ObstacleView(std::vector<std::string> arms)
    : arms_(std::move(arms)), obstacles_(std::make_shared<const std::vector<world::Obstacle>>()) {}

std::optional<std::string> ObstacleView::apply(const msg::ObstacleShapes& shapes) {
  const auto obstacle = messages::from_message(shapes.obstacle());
  if (!obstacle) return obstacle.error;
  if (obstacle->attachment && std::find(arms_.begin(), arms_.end(), obstacle->attachment->arm) == arms_.end()) {
    return "obstacle \"" + obstacle->name + "\": attached_to = " + obstacle->attachment->arm +
           " must be an arm of the cell";
  }
  shapes_[obstacle->name] = Known{*obstacle};
  shapes_changed_ = true;
  return std::nullopt;
}

std::optional<std::string> ObstacleView::apply(const msg::ObstacleStates& states, const bus::EndpointId& writer,
                                               Clock::time_point received) {
  const bool overtaken = newest_ && newest_->writer == writer && states.sequence_number() <= newest_->snapshot.sequence;
  if (overtaken) return std::nullopt;
  auto snapshot = messages::from_message(states, 0.0);
  if (!snapshot) return snapshot.error;
  SenderClock clock = newest_ && newest_->writer == writer ? newest_->clock : SenderClock();
  const Clock::time_point sent = clock.sent(states.stamp_ns(), received);
  newest_ = Arrived{std::move(snapshot.value->snapshot), std::move(snapshot.value->names), writer, sent, clock};
  waiting_ = true;
  return std::nullopt;
}

void ObstacleView::withdraw(const std::string& name) {
  if (const auto found = shapes_.find(name); found != shapes_.end()) found->second.withdrawn = true;
}

bool ObstacleView::join() {
  if (!newest_ || (!waiting_ && !shapes_changed_)) return false;
  const Arrived& arrived = *newest_;
  for (const std::string& name : arrived.names) {
    if (shapes_.contains(name)) continue;
    missing_ = "the shape of obstacle " + name + " is not known yet";
    return false;
  }
  missing_.clear();
  waiting_ = false;
  states_ = arrived.snapshot.states;
  const bool other_list = shapes_changed_ || arrived.names != names_ || !joined_at_;
  joined_at_ = arrived.at;
  if (!other_list) return false;
  shapes_changed_ = false;
  names_ = arrived.names;
  forget_withdrawn();
  auto obstacles = std::make_shared<std::vector<world::Obstacle>>();
  for (const std::string& name : names_) obstacles->push_back(shapes_.at(name).obstacle);
  obstacles_ = std::move(obstacles);
  return true;
}

void ObstacleView::forget_withdrawn() {
  std::erase_if(shapes_, [this](const auto& entry) {
    return entry.second.withdrawn && std::find(names_.begin(), names_.end(), entry.first) == names_.end();
  });
}

std::span<const world::ObstacleState> ObstacleView::states(Clock::time_point now) {
  const double old = age(now);
  for (world::ObstacleState& state : states_) state.age = old;
  return states_;
}

double ObstacleView::age(Clock::time_point now) const {
  if (!joined_at_) return 0.0;
  return std::max(0.0, std::chrono::duration<double>(now - *joined_at_).count());
}

}  // namespace hecaton::services
