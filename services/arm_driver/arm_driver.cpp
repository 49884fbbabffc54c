#include "services/arm_driver/arm_driver.hpp"

#include <algorithm>
#include <utility>

#include "services/messages/convert.hpp"
#include "services/messages/names.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

/// A stall longer than this many periods is not simulated in full: by then the arm has stopped.
constexpr std::uint64_t kMostPeriodsAtOnce = 500;

Commander commander_of(const bus::Sample<msg::ArmCommand>& sample) {
  return {{sample.value.node(), sample.value.term()}, sample.writer};
}

/// Where its predecessor left the arm, or else where the cell begins.
planner::JointVector start_of(const planner::PlannedArm& planned, const ArmMemory& memory) {
  if (const auto last = memory.recall()) return last->q;
  return planned.start.size() > 0 ? planned.start : planned.arm.home();
}

}  // namespace

ArmDriver::ArmDriver(const config::CellFile& file, int arm, const ServiceOptions& options,
                     const ShutdownSignal& shutdown)
    : name_(file.cell.arms[arm].arm.name),
      period_(file.cell.timing.driver_period),
      command_timeout_(nanoseconds(file.cell.timing.command_timeout)),
      participant_(make_participant(file, options, driver_node(name_), &mailbox_)),
      modes_(participant_, &mailbox_),
      commands_(participant_, &mailbox_),
      shapes_(participant_, &mailbox_),
      states_(participant_),
      pulse_(participant_,
             {driver_node(name_), msg::NodeKind::NODE_DRIVER, name_,
              options.host.empty() ? file.arm_hosts[arm].host : options.host},
             pulse_timing(file, options)),
      loop_(nanoseconds(period_), shutdown),
      memory_(options.memory, file.cell.arms[arm].arm.model->joints()),
      drive_(file.cell.arms[arm].arm.limits, start_of(file.cell.arms[arm], memory_), file.cell.timing.command_timeout) {
  if (const auto last = memory_.recall()) drive_.saw(last->mandate);
  state_.arm(name_);
}

void ArmDriver::run() {
  log_info("driver started", {{"arm", name_}, {"period_ms", period_ * 1e3}});
  while (loop_.next()) {
    // What a stall swallowed happened without new commands: the arm moved on, or stopped.
    for (auto k = std::min(loop_.skipped(), kMostPeriodsAtOnce); k > 0; --k) drive_.step(period_);
    listen();
    note_mandate();
    drive_.step(period_);
    memory_.remember(drive_.arm().q(), drive_.gate().mandate());
    publish();
    if (pulse_.due(loop_.now(), loop_.period() / 2)) beat();
  }
  log_info("driver ends", {{"arm", name_}});
}

void ArmDriver::listen() {
  (void)mailbox_.take_events();
  modes_.update();
  drive_.saw(modes_.view().lease(name_));
  drive_.order(modes_.view().order(name_), modes_.view().why(name_).text());
  for (const auto& sample : commands_.take()) {
    // What lay here while this process was stopped is no command any more.
    const bool current = sample.age(loop_.now()) <= command_timeout_;
    if (!sample.disposed && sample.value.arm() == name_ && current) take(sample);
  }
  look_at_tool();
}

void ArmDriver::take(const bus::Sample<msg::ArmCommand>& sample) {
  const Verdict verdict = drive_.command(sample.value);
  if (verdict != Verdict::kAccepted && verdict != Verdict::kRepeated) note_refusal(sample, verdict);
  if (verdict != Verdict::kAccepted) return;
  note_acceptance(commander_of(sample), sample.received);
}

// A planner in another's place is told apart from one that goes on in another process or under another term: the gap
// before the first is what a standby costs.
void ArmDriver::note_acceptance(const Commander& commander, bus::Clock::time_point at) {
  const std::chrono::duration<double, std::milli> gap = at - std::exchange(accepted_at_, at);
  const auto before = record_.accepted(commander);
  if (!before) return;
  const bool replaced = commander.mandate.planner != before->mandate.planner;
  log_info(replaced ? "follows" : "goes on with", {{"planner", commander.mandate.planner},
                                                   {"term", commander.mandate.term},
                                                   {"process", commander.writer.text()},
                                                   {"instead_of_term", before->mandate.term},
                                                   {"instead_of", before->mandate.planner},
                                                   {"gap_ms", before->mandate.term > 0 ? gap.count() : 0.0}});
}

// From now on commands of older terms are refused, whether or not one of this term ever comes: also by our successor,
// should we be killed when the arm has just moved by it.
void ArmDriver::note_mandate() {
  const ArmLease& newest = drive_.gate().mandate();
  if (newest == logged_mandate_) return;
  memory_.remember(drive_.arm().q(), newest);
  log_info("mandate", {{"planner", newest.planner}, {"term", newest.term}, {"instead_of_term", logged_mandate_.term}});
  logged_mandate_ = newest;
}

void ArmDriver::note_refusal(const bus::Sample<msg::ArmCommand>& sample, Verdict verdict) {
  const std::uint64_t times = record_.refused(commander_of(sample), static_cast<int>(verdict));
  if (times == 0) return;
  const bool far = verdict == Verdict::kTooFar;
  log_warning("command refused", {{"from", sample.value.node()},
                                  {"term", sample.value.term()},
                                  {"process", sample.writer.text()},
                                  {"refused", times},
                                  {"reason", far ? drive_.complaint() : drive_.gate().complaint()}});
}

void ArmDriver::look_at_tool() {
  if (shapes_.take().empty()) return;
  state_.carried().clear();
  for (const auto& [name, sample] : shapes_.latest()) {
    if (sample.value.obstacle().attached_to() != name_) continue;
    state_.carried().append(state_.carried().empty() ? "" : ", ").append(name);
  }
}

void ArmDriver::publish() {
  state_.term(drive_.gate().term());
  state_.sequence_number(state_.sequence_number() + 1);
  state_.stamp_ns(stamp_now());
  state_.mode(drive_.mode());
  messages::to_message(drive_.arm().q(), state_.q());
  messages::to_message(drive_.arm().qd(), state_.qd());
  state_.command_sequence_number(drive_.gate().sequence());
  state_.command_age(drive_.command_age());
  state_.newest_term(drive_.gate().mandate().term);
  state_.planner(drive_.gate().mandate().planner);
  state_.stale_rejected(drive_.gate().stale_rejected());
  state_.reason(drive_.reason());
  (void)states_.write(state_);  // best effort, and the bus has logged a refusal
  if (logged_mode_ == state_.mode()) return;
  logged_mode_ = state_.mode();
  log_info("arm mode",
           {{"mode", text(logged_mode_)}, {"reason", state_.reason()}, {"command_age_ms", drive_.command_age() * 1e3}});
}

void ArmDriver::beat() {
  Vital vital;
  vital.term = modes_.view().term();
  vital.heard_mode = modes_.view().number();
  const bool runs = drive_.mode() == msg::ArmMode::ARM_RUNNING;
  const bool as_told = runs || modes_.view().order(name_) != msg::Mode::MODE_RUN;
  vital.state = as_told && modes_.view().heard() ? msg::NodeState::NODE_RUNNING : msg::NodeState::NODE_DEGRADED;
  if (!runs) vital.cause = make_cause(msg::CauseKind::CAUSE_COMMANDS_CEASED, name_, state_.reason());
  vital.oldest_input = "ArmCommand/" + name_;
  vital.oldest_input_age = drive_.command_age();
  pulse_.beat(loop_.now(), vital, loop_.statistics());
}

}  // namespace hecaton::services
