#include "services/world/world_topics.hpp"

#include <algorithm>

#include "planner/simulation/arm_in_world.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

constexpr std::chrono::milliseconds kReportPeriod{100};
/// An arm that is not heard for longer is not assumed to move on [s].
constexpr double kLongestExtrapolation = 0.03;

/// Measured positions of the joints outside the chain; the middle of their ranges if there are none.
std::vector<double> outside_of(const planner::Arm& arm, const msg::ArmState& state) {
  std::vector<double> positions;
  for (const planner::MotionRange& range : planner::outside_ranges(*arm.model)) {
    positions.push_back(0.5 * (range.lower + range.upper));
  }
  return state.outside().size() == positions.size() ? state.outside() : positions;
}

}  // namespace

MeasuredArms::MeasuredArms(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox)
    : file_(file),
      states_(participant, &mailbox),
      measured_(file.cell.arms.size()),
      arrivals_(file.cell.arms.size()),
      q_(file.cell.arms.size()) {}

void MeasuredArms::update(world::BulletWorld& world, bus::Clock::time_point now) {
  take();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    if (!arrivals_[i]) continue;
    const double age = std::chrono::duration<double>(now - *arrivals_[i]).count();
    q_[i] = measured_[i].q + std::clamp(age, 0.0, kLongestExtrapolation) * measured_[i].qd;
    planner::set_measured(world, static_cast<int>(i), file_.cell.arms[i].arm, *q_[i], measured_[i].outside,
                          kinematics_);
  }
}

void MeasuredArms::take() {
  for (const auto& sample : states_.take()) {
    const auto& arms = file_.cell.arms;
    const auto found = std::find_if(arms.begin(), arms.end(),
                                    [&](const auto& planned) { return planned.arm.name == sample.value.arm(); });
    if (sample.disposed || found == arms.end()) continue;
    const planner::Arm& arm = found->arm;
    const auto q =
        messages::joints_from_message(sample.value.q(), {"ArmState of ", arm.name, ": q"}, arm.model->joints());
    const auto qd =
        messages::joints_from_message(sample.value.qd(), {"ArmState of ", arm.name, ": qd"}, arm.model->joints());
    if (!q || !qd) {
      log_warning("message ignored", {{"reason", q ? qd.error : q.error}});
      continue;
    }
    const auto index = static_cast<std::size_t>(found - arms.begin());
    measured_[index] = {*q, *qd, outside_of(arm, sample.value)};
    arrivals_[index] = sample.received;
  }
}

void ObstaclePublisher::publish_shapes(const world::BulletWorld& world, const std::string& name, std::uint64_t term) {
  msg::ObstacleShapes message;
  message.name(name);
  message.term(term);
  message.edition(world.edition());
  message.stamp_ns(stamp_now());
  const world::Obstacle* found = world.find(name);
  if (found == nullptr) {
    static_cast<void>(shapes_.retire(message));
    return;
  }
  message.obstacle(messages::to_message(*found));
  if (const auto written = shapes_.write(message); !written) {
    log_error("obstacle not published", {{"obstacle", name}, {"reason", written.reason}});
  }
}

void ObstaclePublisher::publish_states(const world::BulletWorld& world, std::uint64_t term) {
  msg::ObstacleStates message = messages::to_message(world.snapshot(), world.obstacles());
  message.term(term);
  message.stamp_ns(stamp_now());
  static_cast<void>(states_.write(message));  // best effort; the bus logs a refusal
}

ScanPublisher::ScanPublisher(const config::CellFile& file, bus::Participant& participant)
    : file_(file), scans_(participant) {
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) scanners_.emplace_back(file.cell.arms[i], i + 1);
}

void ScanPublisher::publish(const world::BulletWorld& world, const MeasuredArms& arms) {
  if (cast_edition_ != world.edition()) {
    caster_.set_obstacles(world.obstacles());
    cast_edition_ = world.edition();
  }
  caster_.place(world.present());
  for (std::size_t i = 0; i < scanners_.size(); ++i) {
    const auto& q = arms.q()[i];
    if (!q) continue;
    const planner::PlannedArm& planned = file_.cell.arms[i];
    // The arm moves on while its state is on its way: the scan belongs to the time of that state.
    const std::int64_t measured = std::chrono::nanoseconds(arms.arrivals()[i]->time_since_epoch()).count();
    for (const planner::RangeScan& scan : scanners_[i].scan(world.time(), *q, caster_)) {
      const planner::RangeSensor& sensor = planned.sensors[scan.sensor];
      if (!sensor.simulated) continue;
      msg::RangeScan message = messages::to_message(scan, sensor);
      message.sensor(planned.arm.name + "/" + sensor.name);
      message.arm(planned.arm.name);
      message.link(planned.arm.model->links[sensor.link].name);
      message.sequence_number(++sequence_);
      message.stamp_ns(measured);
      static_cast<void>(scans_.write(message));
    }
  }
}

msg::ContactReport contact_report(const world::ContactReport& report, double time, bool running) {
  msg::ContactReport message;
  message.running(running);
  message.time(time);
  message.contacts(report.contacts);
  message.has_smallest(report.has_smallest);
  if (report.has_smallest) message.smallest(messages::to_message(report.smallest));
  for (int kind = 0; kind < world::kContactKinds; ++kind) {
    const world::KindReport& of_kind = report.kinds[static_cast<std::size_t>(kind)];
    msg::KindSummary& summary = message.kinds().emplace_back();
    summary.kind(static_cast<msg::ContactKind>(kind));
    summary.has_smallest(of_kind.has_smallest);
    summary.contacts(of_kind.contacts);
    if (of_kind.has_smallest) summary.smallest(messages::to_message(of_kind.smallest));
  }
  for (const world::Separation& event : report.events) message.events().push_back(messages::to_message(event));
  return message;
}

bool ContactPublisher::due(const world::ContactReport& report, bus::Clock::time_point now) {
  const bool periodic = now >= due_;
  if (!periodic && report.contacts == published_) return false;
  if (report.contacts > published_ && !report.events.empty()) {
    const world::Separation& last = report.events.back();
    log_warning("contact", {{"a", last.a}, {"b", last.b}, {"distance", last.distance}, {"contacts", report.contacts}});
  }
  if (periodic) due_ = now + kReportPeriod;
  published_ = report.contacts;
  return true;
}

void ContactPublisher::publish(const world::BulletWorld& world, bool running, std::uint64_t term) {
  msg::ContactReport message = contact_report(world.contact_monitor().report(), world.time(), running);
  message.term(term);
  message.sequence_number(++sequence_);
  message.stamp_ns(stamp_now());
  static_cast<void>(reports_.write(message));
}

}  // namespace hecaton::services
