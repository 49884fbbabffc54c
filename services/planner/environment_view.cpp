#include "services/planner/environment_view.hpp"

#include <algorithm>
#include <utility>

#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

ObstacleView::ObstacleView(std::vector<std::string> arms)
    : arms_(std::move(arms)), obstacles_(std::make_shared<const std::vector<world::Obstacle>>()) {}

// Of further participants the oldest is forgotten, but not the one that sends the states.
ObstacleView::World& ObstacleView::world_of(const bus::EndpointId& writer) {
  const auto is_its = [](const bus::EndpointId& id) {
    return [&id](const World& world) { return world.writer.same_participant(id); };
  };
  const auto known = std::find_if(worlds_.begin(), worlds_.end(), is_its(writer));
  if (known != worlds_.end()) return *known;
  if (worlds_.size() == kMostWorlds) {
    const bool oldest_is_used = newest_ && worlds_.front().writer.same_participant(newest_->writer);
    worlds_.erase(worlds_.begin() + (oldest_is_used ? 1 : 0));
  }
  return worlds_.emplace_back(World{writer, {}});
}

std::optional<std::string> ObstacleView::apply(const msg::ObstacleShapes& shapes, const bus::EndpointId& writer) {
  const auto obstacle = messages::from_message(shapes.obstacle());
  if (!obstacle) return obstacle.error;
  if (obstacle->attachment && std::find(arms_.begin(), arms_.end(), obstacle->attachment->arm) == arms_.end()) {
    return "obstacle \"" + obstacle->name + "\": attached_to = " + obstacle->attachment->arm +
           " must be an arm of the cell";
  }
  World& world = world_of(writer);
  if (world.shapes.size() == kMostDescribed && !world.shapes.contains(obstacle->name)) {
    return "obstacle \"" + obstacle->name + "\": its world has more than " + std::to_string(kMostDescribed) +
           " obstacles";
  }
  world.shapes[obstacle->name] = Known{*obstacle};
  if (!newest_ || newest_->writer.same_participant(writer)) shapes_changed_ = true;
  return std::nullopt;
}

std::optional<std::string> ObstacleView::apply(const msg::ObstacleStates& states, const bus::EndpointId& writer,
                                               Clock::time_point received) {
  const bool overtaken = newest_ && newest_->writer == writer && states.sequence_number() <= newest_->snapshot.sequence;
  if (overtaken) return std::nullopt;
  auto snapshot = messages::from_message(states, 0.0);
  if (!snapshot) return snapshot.error;
  if (newest_ && !newest_->writer.same_participant(writer)) shapes_changed_ = true;
  SenderClock clock = newest_ && newest_->writer == writer ? newest_->clock : SenderClock();
  const Clock::time_point sent = clock.sent(states.stamp_ns(), received);
  newest_ = Arrived{std::move(snapshot.value->snapshot), std::move(snapshot.value->names), writer, sent, clock};
  waiting_ = true;
  return std::nullopt;
}

void ObstacleView::withdraw(const std::string& name, const bus::EndpointId& writer) {
  World& world = world_of(writer);
  if (const auto found = world.shapes.find(name); found != world.shapes.end()) found->second.withdrawn = true;
}

bool ObstacleView::join() {
  if (!newest_ || (!waiting_ && !shapes_changed_)) return false;
  const Arrived& arrived = *newest_;
  World& world = world_of(arrived.writer);
  for (const std::string& name : arrived.names) {
    if (world.shapes.contains(name)) continue;
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
  forget_withdrawn(world);
  auto obstacles = std::make_shared<std::vector<world::Obstacle>>();
  for (const std::string& name : names_) obstacles->push_back(world.shapes.at(name).obstacle);
  obstacles_ = std::move(obstacles);
  return true;
}

void ObstacleView::forget_withdrawn(World& world) {
  std::erase_if(world.shapes, [this](const auto& entry) {
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

SensorView::SensorView(const planner::PlannedArm& arm)
    : arm_(arm.arm.name), sensors_(arm.sensors), received_(arm.sensors.size()) {
  for (const planner::RangeSensor& sensor : sensors_) links_.push_back(arm.arm.model->links[sensor.link].name);
}

std::optional<planner::RangeScan> SensorView::take(const msg::RangeScan& message, const bus::EndpointId& writer,
                                                   Clock::time_point received, const ArmView::ReceivedState& own,
                                                   std::optional<std::string>& error) {
  if (message.arm() != arm_) return std::nullopt;
  const auto found = std::find_if(sensors_.begin(), sensors_.end(), [&](const planner::RangeSensor& sensor) {
    return key(arm_, sensor.name) == message.sensor();
  });
  if (found == sensors_.end()) {
    error = "RangeScan: sensor = " + message.sensor() + " must be a sensor of arm " + arm_ + " in the cell file";
    return std::nullopt;
  }
  const auto index = static_cast<std::size_t>(found - sensors_.begin());
  if (message.link() != links_[index]) {
    error = "RangeScan \"" + message.sensor() + "\": link = " + message.link() + " must be " + links_[index];
    return std::nullopt;
  }
  std::optional<Received>& known = received_[index];
  const bool same_writer = known && known->writer == writer;
  if (same_writer && message.sequence_number() <= known->sequence) return std::nullopt;
  auto readings = messages::from_message(message);
  if (!readings) {
    error = readings.error;
    return std::nullopt;
  }
  SenderClock clock = same_writer ? known->clock : SenderClock();
  const Clock::time_point sent = clock.sent(message.stamp_ns(), received);
  known = Received{writer, message.sequence_number(), sent, clock};
  const double since = std::chrono::duration<double>(sent - own.at).count();
  return planner::RangeScan{static_cast<int>(index), found->link, own.q + since * own.qd, std::move(*readings.value)};
}

std::optional<msg::Cause> SensorView::silent(Clock::time_point now, double limit) const {
  const auto old = [](const planner::RangeSensor& sensor, const std::string& how) {
    return make_cause(msg::CauseKind::CAUSE_SENSOR_OLD, sensor.name, "sensor " + sensor.name + how);
  };
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (!received_[i]) return old(sensors_[i], " has sent no scan");
    const double age = std::chrono::duration<double>(now - received_[i]->at).count();
    if (age > std::max(limit, 3.0 * sensors_[i].period)) return old(sensors_[i], " sends no scans");
  }
  return std::nullopt;
}

}  // namespace hecaton::services
