#include "services/world/world_service.hpp"

#include <algorithm>

#include "planner/simulation/arm_bodies.hpp"
#include "services/bus/message_file.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/process_info.hpp"
#include "services/world/referee_message.hpp"
#include "services/world/world_edit.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr auto kReportPeriod = 100ms;
/// Longer stalls cost the world time instead of making obstacles jump [s].
constexpr double kLongestStep = 0.1;
/// How long the last report may wait for its readers when the service ends.
constexpr auto kFarewell = 200ms;

std::vector<world::ArmBodies> bodies_of(const planner::Cell& cell) {
  std::vector<world::ArmBodies> bodies;
  for (const planner::PlannedArm& planned : cell.arms) bodies.push_back(planner::arm_bodies(planned.arm));
  return bodies;
}

/// What a world that died has left. `lost` gets a sentence when there is something that cannot be used.
std::optional<Continuation> recall(const config::CellFile& file, const std::string& path, std::string& lost) {
  if (path.empty()) return std::nullopt;
  const bus::ReadMessage read = bus::read_message(path);
  if (!read.error.empty()) lost = read.error;
  if (!read.message) return std::nullopt;
  if (read.message->cell() != file.cell.name) {
    lost = path + " is of cell " + read.message->cell();
    return std::nullopt;
  }
  auto before = continuation(*read.message, file.cell.scene);
  if (!before) lost = path + ": " + before.error;
  return before.value;
}

}  // namespace

WorldService::WorldService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown)
    : file_(file),
      period_(file.cell.timing.world_period),
      participant_(make_participant(file, options, world_node(), &mailbox_)),
      modes_(participant_, &mailbox_),
      arm_states_(participant_, &mailbox_),
      requests_(participant_, &mailbox_),
      replies_(participant_),
      shapes_(participant_),
      states_(participant_),
      scans_(participant_),
      reports_(participant_),
      pulse_(participant_,
             {world_node(), msg::NodeKind::NODE_WORLD, "", options.host.empty() ? file.world_host : options.host},
             pulse_timing(file, options)),
      loop_(nanoseconds(period_), shutdown),
      before_(recall(file, options.memory, lost_)),
      world_(before_ ? before_->scene : file.cell.scene, bodies_of(file.cell)),
      memory_(lost_.empty() ? options.memory : std::string()),
      measured_(file.cell.arms.size()),
      q_(file.cell.arms.size()) {
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) scanners_.emplace_back(file.cell.arms[i], i + 1);
}

void WorldService::run() {
  log_info("world started", {{"obstacles", world_.obstacles().size()}, {"period_ms", period_ * 1e3}});
  if (lost_.empty()) {
    go_on();
  } else {
    lost_ = "what was edited in the world before it died cannot be recovered (" + lost_ +
            "): end the cell and start it again";
    log_error("world forgot", {{"reason", lost_}});
  }
  while (loop_.next()) {
    (void)mailbox_.take_events();
    modes_.update();
    if (pulse_.due(loop_.now(), loop_.period() / 2)) beat();
    // Who was cut off knows neither where the arms are nor who sees its obstacles: no time passes in its world.
    if (participant_.away()) continue;
    set_arms();
    edit();
    look_at_memory();
    reply();
    if (!lost_.empty()) continue;  // planners stand still without a world, and the supervisor says why
    world_.step(std::min(period_ * static_cast<double>(1 + loop_.skipped()), kLongestStep));
    publish_states();
    publish_scans();
    judge();
  }
  publish_report(world_.referee().report(), false);
  (void)reports_.wait_acknowledged(kFarewell);
  log_info("world ends", {{"contacts", world_.referee().report().contacts}});
}

// Between the last memory and the end of the world that died lies at most a report's period; a longer gap costs the
// world time instead of making obstacles jump, as a stall does.
void WorldService::go_on() {
  if (before_) {
    const double since = 1e-9 * static_cast<double>(stamp_now() - before_->stamp_ns);
    world_.go_on(before_->time + std::clamp(since, 0.0, kLongestStep), before_->edition, before_->account);
    contacts_told_ = world_.referee().report().contacts;
    log_info("world goes on",
             {{"time", world_.time()}, {"contacts", contacts_told_}, {"remembered_s_ago", std::max(since, 0.0)}});
    before_.reset();
  }
  for (const world::Obstacle& obstacle : world_.obstacles()) publish_shapes(obstacle.name);
}

void WorldService::set_arms() {
  for (const auto& sample : arm_states_.take()) {
    const auto& arms = file_.cell.arms;
    const auto found = std::find_if(arms.begin(), arms.end(),
                                    [&](const auto& planned) { return planned.arm.name == sample.value.arm(); });
    if (sample.disposed || found == arms.end()) continue;
    const planner::Arm& arm = found->arm;
    const auto q =
        messages::joints_from_message(sample.value.q(), {"ArmState of ", arm.name, ": q"}, arm.model->joints());
    if (!q) {
      log_warning("message ignored", {{"reason", q.error}});
      continue;
    }
    const auto index = found - arms.begin();
    planner::set_measured(world_, static_cast<int>(index), arm, *q, kinematics_);
    measured_[static_cast<std::size_t>(index)] = sample.received;
    q_[static_cast<std::size_t>(index)] = *q;
  }
}

void WorldService::edit() {
  for (const auto& sample : requests_.take()) {
    if (sample.disposed) continue;
    const msg::WorldEditRequest& request = sample.value;
    const world::EditResult result =
        lost_.empty() ? apply_edit(world_, {file_.cell.arms, q_}, request) : world::EditResult{false, lost_};
    if (result.done) publish_shapes(edited_name(request));
    msg::WorldEditReply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.done(result.done);
    reply.reason(result.reason);
    reply.edition(world_.snapshot().edition);
    replies_due_.owe(result.done ? remember() : 0, std::move(reply));
    log_info("world edit", {{"client", request.client()},
                            {"obstacle", edited_name(request)},
                            {"done", result.done},
                            {"reason", result.reason}});
  }
}

void WorldService::reply() {
  for (const msg::WorldEditReply& reply : replies_due_.take(memory_)) (void)replies_.write(reply);
}

std::uint64_t WorldService::remember() {
  msg::WorldMemory memory = memory_of(world_);
  memory.cell(file_.cell.name);
  memory.stamp_ns(stamp_now());
  return memory_.keep(std::move(memory));
}

void WorldService::look_at_memory() {
  memory_.look(loop_.now());
  std::string failure = memory_.failure();
  if (failure.empty() != forgetful_.empty()) {
    if (failure.empty()) {
      log_info("edits are remembered again");
    } else {
      log_error("edits are not remembered", {{"reason", failure}});
    }
  }
  forgetful_ = std::move(failure);
}

// Also right for an obstacle that is no longer there: it is withdrawn.
void WorldService::publish_shapes(const std::string& name) {
  msg::ObstacleShapes message;
  message.name(name);
  message.term(modes_.view().term());
  message.edition(world_.snapshot().edition);
  message.stamp_ns(stamp_now());
  const auto& obstacles = world_.obstacles();
  const auto found = std::find_if(obstacles.begin(), obstacles.end(),
                                  [&](const world::Obstacle& obstacle) { return obstacle.name == name; });
  if (found == obstacles.end()) {
    (void)shapes_.retire(message);
    return;
  }
  message.obstacle(messages::to_message(*found));
  if (const auto written = shapes_.write(message); !written) {
    log_error("obstacle not published", {{"obstacle", name}, {"reason", written.reason}});
  }
}

void WorldService::publish_states() {
  msg::ObstacleStates message = messages::to_message(world_.snapshot(), world_.obstacles());
  message.term(modes_.view().term());
  message.stamp_ns(stamp_now());
  (void)states_.write(message);  // best effort, and the bus has logged a refusal
}

void WorldService::publish_scans() {
  const world::ObstacleSnapshot now = world_.snapshot();
  if (cast_edition_ != now.edition) {
    caster_.set_obstacles(world_.obstacles());
    cast_edition_ = now.edition;
  }
  for (std::size_t i = 0; i < scanners_.size(); ++i) {
    if (!q_[i]) continue;
    const planner::PlannedArm& planned = file_.cell.arms[i];
    // The arm moves on while its state is under way: a scan is true of when it was where the beams were cast from.
    const std::int64_t measured = std::chrono::nanoseconds(measured_[i]->time_since_epoch()).count();
    for (const planner::RangeScan& scan : scanners_[i].scan(world_.time(), *q_[i], caster_, now.states)) {
      const planner::RangeSensor& sensor = planned.sensors[scan.sensor];
      if (!sensor.simulated) continue;
      msg::RangeScan message = messages::to_message(scan, sensor);
      message.sensor(planned.arm.name + "/" + sensor.name);
      message.arm(planned.arm.name);
      message.link(planned.arm.model->links[sensor.link].name);
      message.sequence_number(++scan_sequence_);
      message.stamp_ns(measured);
      (void)scans_.write(message);
    }
  }
}

void WorldService::judge() {
  const bool due = loop_.now() >= report_due_;
  const world::RefereeReport report = world_.referee().report();
  if (!due && report.contacts == contacts_told_) return;
  if (report.contacts > contacts_told_ && !report.events.empty()) {
    const world::Separation& last = report.events.back();
    log_warning("contact", {{"a", last.a}, {"b", last.b}, {"distance", last.distance}, {"contacts", report.contacts}});
  }
  if (due) report_due_ = loop_.now() + kReportPeriod;
  contacts_told_ = report.contacts;
  remember();
  publish_report(report, true);
}

void WorldService::publish_report(const world::RefereeReport& report, bool running) {
  msg::RefereeReport message = referee_message(report, world_.time(), running);
  message.term(modes_.view().term());
  message.sequence_number(++report_sequence_);
  message.stamp_ns(stamp_now());
  (void)reports_.write(message);
}

void WorldService::beat() {
  Vital vital;
  vital.term = modes_.view().term();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const std::string& name = file_.cell.arms[i].arm.name;
    if (!measured_[i]) {
      vital.state = msg::NodeState::NODE_DEGRADED;
      vital.detail = "the state of arm " + name + " was never heard: the referee does not judge it";
      continue;
    }
    const double age = std::chrono::duration<double>(loop_.now() - *measured_[i]).count();
    if (age <= vital.oldest_input_age) continue;
    vital.oldest_input_age = age;
    vital.oldest_input = "ArmState/" + name;
  }
  if (!forgetful_.empty()) {
    vital.state = msg::NodeState::NODE_DEGRADED;
    vital.detail = "edits are " + not_remembered(forgetful_);
  }
  if (!lost_.empty()) {
    vital.state = msg::NodeState::NODE_FAILED;
    vital.detail = lost_;
  }
  pulse_.beat(loop_.now(), vital, loop_.statistics());
}

}  // namespace hecaton::services
