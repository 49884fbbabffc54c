#include "services/planner/sensor_view.hpp"

#include <algorithm>

#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

SensorView::SensorView(const planner::PlannedArm& arm)
    : arm_(arm.arm.name), sensors_(arm.sensors), heard_(arm.sensors.size()) {
  for (const planner::RangeSensor& sensor : sensors_) links_.push_back(arm.arm.model->links[sensor.link].name);
}

std::optional<planner::RangeScan> SensorView::take(const msg::RangeScan& message, const bus::EndpointId& writer,
                                                   Clock::time_point received, const ArmView::Heard& own,
                                                   std::optional<std::string>& complaint) {
  if (message.arm() != arm_) return std::nullopt;
  const auto found = std::find_if(sensors_.begin(), sensors_.end(), [&](const planner::RangeSensor& sensor) {
    return key(arm_, sensor.name) == message.sensor();
  });
  if (found == sensors_.end()) {
    complaint = "RangeScan: sensor = " + message.sensor() + " must be one that the cell file gives arm " + arm_;
    return std::nullopt;
  }
  const auto index = static_cast<std::size_t>(found - sensors_.begin());
  if (message.link() != links_[index]) {
    complaint = "RangeScan \"" + message.sensor() + "\": link = " + message.link() + " must be " + links_[index];
    return std::nullopt;
  }
  std::optional<Heard>& heard = heard_[index];
  const bool same_writer = heard && heard->writer == writer;
  if (same_writer && message.sequence_number() <= heard->sequence) return std::nullopt;
  auto readings = messages::from_message(message);
  if (!readings) {
    complaint = readings.error;
    return std::nullopt;
  }
  SenderClock clock = same_writer ? heard->clock : SenderClock();
  const Clock::time_point sent = clock.sent(message.stamp_ns(), received);
  heard = Heard{writer, message.sequence_number(), sent, clock};
  const double since = std::chrono::duration<double>(sent - own.at).count();
  return planner::RangeScan{static_cast<int>(index), found->link, own.q + since * own.qd, std::move(*readings.value)};
}

std::optional<msg::Cause> SensorView::silent(Clock::time_point now, double limit) const {
  const auto old = [](const planner::RangeSensor& sensor, const std::string& how) {
    return make_cause(msg::CauseKind::CAUSE_SENSOR_OLD, sensor.name, "sensor " + sensor.name + how);
  };
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (!heard_[i]) return old(sensors_[i], " was never heard");
    const double age = std::chrono::duration<double>(now - heard_[i]->at).count();
    if (age > std::max(limit, 3.0 * sensors_[i].period)) return old(sensors_[i], " is silent");
  }
  return std::nullopt;
}

}  // namespace hecaton::services
