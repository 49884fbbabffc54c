#include "services/arm_driver/arm_driver.hpp"

#include <optional>
#include <utility>
#include <vector>

#include "services/arm_driver/control_setup.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/messages/convert.hpp"
#include "services/messages/names.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/orders.hpp"
#include "services/runtime/process_info.hpp"
#include "services/runtime/run_service.hpp"
#include "services/runtime/state_period.hpp"

namespace hecaton::services {
namespace {

ArmControlSetup driver_setup(const config::CellFile& file, int arm, const device::ArmDevice& device, bool restarted,
                             bool observed) {
  ArmControlSetup setup = control_setup(file, arm);
  setup.observed = observed;
  if (restarted && !device.continues_after_restart()) {
    setup.latched = make_cause(msg::CauseKind::CAUSE_PROGRAM_STOPPED, setup.arm,
                               "its driver was restarted: check the arm, then resume it");
  }
  return setup;
}

device::DeviceOrder device_order(msg::DeviceOrder order) {
  switch (order) {
    case msg::DeviceOrder::DEVICE_POWER_ON:
      return device::DeviceOrder::kPowerOn;
    case msg::DeviceOrder::DEVICE_POWER_OFF:
      return device::DeviceOrder::kPowerOff;
    default:  // orders to the driver itself
      break;
  }
  return device::DeviceOrder::kUnlock;
}

bool is_for_driver(msg::DeviceOrder order) {
  return order == msg::DeviceOrder::DEVICE_OBSERVE || order == msg::DeviceOrder::DEVICE_COMMAND;
}

/// A file beside the driver's checkpoint; empty: nothing is kept.
std::string beside(const std::string& checkpoint, const std::string& ending) {
  return checkpoint.empty() ? std::string() : checkpoint + ending;
}

/// Between two samples of ToolState in which nothing changes.
constexpr std::chrono::milliseconds kToolPeriod{200};
/// Of the names of what the arm carries, in its state [byte]. An intruder may claim any number of them.
constexpr std::size_t kLongestCarried = 4000;

bool is_alike(const msg::ToolState& a, const msg::ToolState& b) {
  return a.moving() == b.moving() && a.grasping() == b.grasping() && a.holding() == b.holding() &&
         a.releasing() == b.releasing() && a.signals() == b.signals();
}

/// The supervisor publishes the cell mode every 25 ms: it is heard while the last one is younger.
constexpr std::chrono::milliseconds kSupervised{100};

std::vector<std::string> names_of(const std::vector<PlacedNode>& nodes) {
  std::vector<std::string> names;
  for (const PlacedNode& node : nodes) names.push_back(node.node);
  return names;
}

std::optional<msg::Cause> hold_of(const CellModeView& mode, const std::string& arm) {
  if (mode.order(arm) == msg::Mode::MODE_RUN) return std::nullopt;
  return mode.why(arm);
}

/// True when a planner, the supervisor and a person would decide the same on both states.
bool decides_alike(const msg::ArmState& a, const msg::ArmState& b) {
  return a.mode() == b.mode() && a.cause().kind() == b.cause().kind() && a.newest_term() == b.newest_term() &&
         a.planner() == b.planner() && a.carried() == b.carried() && a.outside_lower() == b.outside_lower() &&
         a.outside_upper() == b.outside_upper();
}

}  // namespace

int run_arm_driver(int argc, char** argv, std::span<const device::DeviceType> types) {
  return run_service(
      argc, argv, "Drives one arm of a cell: follows its planner's commands and stops the arm when they cease",
      Subject::kArm, [types](const ServiceOptions& options, ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        const int arm = find_arm(file, options.arm);
        auto device = make_device(
            file, arm, beside(options.checkpoint, ".device"), types,
            [](std::string_view event, std::string_view details) {
              log_info(event, {{"details", details}});
            },
            [&file, &options] { return join_as_device(file, options); });
        const LogScope log(driver_node(options.arm), options);
        lock_memory();
        start_exit_notifier(options.exit_fd);
        ArmDriver driver(file, arm, options, shutdown, std::move(device), signal_kinds(file, arm, types));
        raise_service_priority(file, ThreadPriority::kSafety);
        driver.run();
      });
}

ArmDriver::ArmDriver(const config::CellFile& file, int arm, const ServiceOptions& options,
                     const ShutdownSignal& shutdown, std::unique_ptr<device::ArmDevice> device,
                     std::vector<device::SignalKind> signals)
    : name_(file.cell.arms[arm].arm.name),
      participant_(make_participant(file, options, Role::kDriver, driver_node(name_), &mailbox_)),
      modes_(participant_, &mailbox_),
      planners_(names_of(planners_of(file, static_cast<std::size_t>(arm)))),
      readers_{bus::Reader<msg::ArmCommand>(participant_, &mailbox_, {.keys = {name_}}),
               bus::Reader<msg::ObstacleShapes>(participant_, &mailbox_),
               bus::Reader<msg::DeviceRequest>(participant_, &mailbox_)},
      writers_{bus::Writer<msg::ArmState>(participant_, {.key = name_}), bus::Writer<msg::DeviceReply>(participant_)},
      heartbeat_(participant_,
                 {driver_node(name_), msg::NodeKind::NODE_DRIVER, name_,
                  options.host.empty() ? file.arm_hosts[arm].host : options.host},
                 heartbeat_timing(file, options)),
      loop_(nanoseconds(file.cell.timing.driver_period), shutdown),
      command_timeout_(nanoseconds(file.cell.timing.command_timeout)),
      checkpoint_(options.checkpoint),
      observed_(beside(options.checkpoint, ".observed"), 0, "whether others move the arm"),
      device_(std::move(device)),
      control_(driver_setup(file, arm, *device_, checkpoint_.recall().has_value(),
                            observed_.recall().value_or(starts_observed(file.devices[arm]))),
               *device_),
      tool_(file, arm, std::move(signals), beside(options.checkpoint, ".tool"), *device_),
      published_{nanoseconds(state_period(file)), {}, {}} {
  if (const auto last = checkpoint_.recall()) {
    participant_.know_term(last->term);
    control_.observe_lease(*last);
  }
  state_.arm(name_);
  if (tool_.present()) tool_topics_.emplace(participant_, &mailbox_);
}

void ArmDriver::run() {
  log_info("driver started",
           {{"arm", name_}, {"period_ms", std::chrono::duration<double>(loop_.period()).count() * 1e3}});
  while (loop_.next()) {
    control_.read(loop_.now());
    receive();
    note_lease();
    control_.write();
    update_tool();
    publish_tool();  // before the reply to an order, so that its client sees where the fingers are
    handle_orders();
    update_state();
    publish_when_due();
    if (heartbeat_.due(loop_.now(), loop_.period() / 2)) publish_heartbeat();
  }
  log_info("driver shuts down", {{"arm", name_}});
}

void ArmDriver::receive() {
  for (const bus::Event& event : mailbox_.take_events()) planners_.note(event);
  modes_.update();
  control_.observe_lease(modes_.view().lease(name_));
  const bool supervised = modes_.view().heard() && loop_.now() - modes_.view().received() <= kSupervised;
  control_.set_granted(supervised ? std::optional(modes_.view().lease(name_).term) : std::nullopt);
  const CellModeView& mode = modes_.view();
  control_.set_hold(hold_of(mode, name_), mode.heard() && is_held_for_device(mode.mode(), name_));
  for (const auto& sample : readers_.commands.take()) {
    // A command that waited here while this process was stopped is out of date.
    const bool current = sample.age(loop_.now()) <= command_timeout_;
    if (!sample.disposed && sample.value.arm() == name_ && current) take(sample);
  }
  update_carried();
}

void ArmDriver::take(const bus::Sample<msg::ArmCommand>& sample) {
  const bool named = planners_.is_only(sample.writer, sample.value.node());
  const Judgement judgement = control_.command(sample.value, CommandOrigin{sample.writer, sample.received, named});
  if (judgement.verdict == Verdict::kRepeated) return;
  if (judgement.verdict == Verdict::kAccepted) {
    log_.accepted(sample);
  } else if (judgement.verdict != Verdict::kNotGranted || log_.not_granted(sample.received)) {
    log_.refused(sample, judgement);
    report(sample, judgement);
  }
}

void ArmDriver::handle_orders() {
  for (const auto& sample : readers_.orders.take()) {
    const msg::DeviceRequest& request = sample.value;
    if (sample.disposed || request.arm() != name_) continue;
    // A client repeats its request until the reply arrives.
    const msg::DeviceRequest& last = order_.request;
    if (last.client() == request.client() && last.request_id() == request.request_id()) continue;
    log_info("device order", {{"from", request.client()}, {"order", text(request.order())}});
    begin(request);
  }
  const auto end = device_->order_end();
  if (end && order_.runs && !order_.of_tool) {
    order_.runs = false;
    reply(order_.request, end->result);
  }
  const auto tool_end = tool_.end();
  if (tool_end && order_.runs && order_.of_tool) {
    order_.runs = false;
    reply(order_.request, *tool_end);
  }
}

void ArmDriver::begin(const msg::DeviceRequest& request) {
  if (ToolControl::takes(request.order())) {
    const bool busy = order_.runs;
    auto refused = busy
                       ? std::optional(make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, name_,
                                                  "arm " + name_ + ": another order is not finished: wait for its end"))
                       : tool_.begin(request, tool_inputs());
    if (refused) reply(request, *refused);
    if (!busy) order_ = {request, !refused, true};
  } else if (is_for_driver(request.order())) {
    reply(request, observe(request.order() == msg::DeviceOrder::DEVICE_OBSERVE));
    if (!order_.runs) order_.request = request;
  } else if (order_.runs && order_.of_tool) {
    reply(request, device::DeviceFailure{"its gripper carries out an order: wait for its end"});
  } else if (const auto refused = device_->begin(device_order(request.order()))) {
    reply(request, refused);
    if (!order_.runs) order_.request = request;
  } else {
    order_ = {request, true, false};
  }
}

ToolInputs ArmDriver::tool_inputs() {
  return {.now = loop_.now(),
          .q = control_.measured().q,
          .moves = control_.moves(),
          .stopped = modes_.view().order(name_) == msg::Mode::MODE_STOP,
          .attached = attached_,
          .obstacles = [this] { return free_obstacles(); }};
}

std::vector<world::Obstacle> ArmDriver::free_obstacles() {
  std::vector<world::Obstacle> free;
  note_shapes();
  if (!tool_topics_) return free;
  for (const msg::ObstacleState& state : tool_topics_->newest.states()) {
    const auto& shapes = readers_.shapes.latest();
    const auto found = shapes.find(state.name());
    if (found == shapes.end() || !found->second.value.obstacle().attached_to().empty()) continue;
    const auto obstacle = messages::from_message(found->second.value.obstacle());
    const auto X_WO = messages::from_message(state.X_WO(), "ObstacleStates: X_WO");
    if (!obstacle || !X_WO) continue;
    free.push_back(*obstacle);
    free.back().X_WO = *X_WO;
  }
  return free;
}

void ArmDriver::update_tool() {
  if (tool_topics_) {
    for (const auto& sample : tool_topics_->obstacles.take()) {
      if (!sample.disposed) tool_topics_->newest = sample.value;
    }
  }
  tool_.update(tool_inputs());
}

void ArmDriver::publish_tool() {
  if (!tool_topics_) return;
  msg::ToolState state;
  tool_.write(state);
  const bool due = !tool_topics_->at || loop_.now() - *tool_topics_->at >= kToolPeriod;
  if (!due && is_alike(state, tool_topics_->state)) return;
  state.sequence_number(tool_topics_->state.sequence_number() + 1);
  state.stamp_ns(stamp_now());
  tool_topics_->at = loop_.now();
  tool_topics_->state = std::move(state);
  (void)tool_topics_->states.write(tool_topics_->state);  // repeated; the bus logs a refusal
}

// The checkpoint comes first: a driver that is killed now and restarted must not command an arm that a person guides.
device::DeviceResult ArmDriver::observe(bool observed) {
  if (control_.observed() == observed) {
    return device::DeviceFailure{observed ? "others move it already" : "its planner commands it already"};
  }
  if (!observed && control_.moves()) {
    return device::DeviceFailure{"it moves: bring it to rest, then give it back to its planner"};
  }
  observed_.remember(observed);
  control_.set_observed(observed);
  return {};
}

void ArmDriver::reply(const msg::DeviceRequest& to, const device::DeviceResult& result) {
  reply(to, result ? make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, name_, "arm " + name_ + ": " + result->text)
                   : msg::Cause());
}

void ArmDriver::reply(const msg::DeviceRequest& to, const msg::Cause& cause) {
  msg::DeviceReply reply;
  reply.client(to.client());
  reply.request_id(to.request_id());
  reply.arm(name_);
  reply.done(is_none(cause));
  reply.cause(cause);
  (void)writers_.replies.write(reply);  // the bus logs a refusal; the client asks again
}

// Old terms are no news: a planner that was replaced learns of it a moment later. Of a set-point that is too far the
// supervisor learns by the arm's state.
void ArmDriver::report(const bus::Sample<msg::ArmCommand>& sample, const Judgement& judgement) {
  if (judgement.verdict == Verdict::kStaleTerm || judgement.verdict == Verdict::kTooFar) return;
  const auto kind = [&] {
    if (judgement.verdict == Verdict::kSecondWriter) return bus::RefusalKind::kSecondWriter;
    return judgement.verdict == Verdict::kNotGranted ? bus::RefusalKind::kNotGranted : bus::RefusalKind::kMalformed;
  };
  participant_.refuse(
      {.kind = kind(), .topic = "ArmCommand", .sender = sample.writer, .key = name_, .text = judgement.cause.text()});
}

// The checkpoint comes before the log and the next set-point: when this process is killed, its successor must refuse
// commands of older terms, too.
void ArmDriver::note_lease() {
  const ArmLease& newest = control_.gate().lease();
  if (newest == log_.lease()) return;
  checkpoint_.remember(newest);
  log_.lease(newest);
}

void ArmDriver::update_carried() {
  if (!readers_.shapes.take().empty()) note_shapes();
}

void ArmDriver::note_shapes() {
  state_.carried().clear();
  attached_.clear();
  for (const auto& [name, sample] : readers_.shapes.latest()) {
    attached_[name] = sample.value.obstacle().attached_to() == name_;
    const bool fits = state_.carried().size() + name.size() < kLongestCarried;
    if (!attached_[name] || !fits) continue;
    state_.carried().append(state_.carried().empty() ? "" : ", ").append(name);
  }
}

void ArmDriver::update_state() {
  const planner::JointState& measured = control_.measured();
  state_.term(control_.gate().term());
  state_.stamp_ns(std::chrono::nanoseconds(control_.measured_at().time_since_epoch()).count());
  state_.mode(control_.mode());
  messages::to_message(measured.q, state_.q());
  messages::to_message(measured.qd, state_.qd());
  state_.speed_scaling(control_.speed_scaling());
  state_.tracking_delay(control_.tracking_delay());
  state_.command_sequence_number(control_.gate().sequence());
  state_.command_age(control_.command_age_when_measured());
  state_.newest_term(control_.gate().lease().term);
  state_.planner(control_.gate().lease().planner);
  state_.stale_rejected(control_.gate().stale_rejected());
  state_.cause(control_.cause());
  tool_.write(state_);
  log_.state(state_);
}

// No reader's loop is faster than this period, and readers extrapolate.
void ArmDriver::publish_when_due() {
  const bool due = !published_.at || loop_.now() - *published_.at + loop_.period() / 2 >= published_.period;
  if (!due && decides_alike(state_, published_.state)) return;
  state_.sequence_number(state_.sequence_number() + 1);
  published_.at = loop_.now();
  published_.state = state_;
  (void)writers_.states.write(state_);  // best effort; the bus logs a refusal
}

void ArmDriver::publish_heartbeat() {
  HealthReport report;
  report.term = modes_.view().term();
  report.cause = state_.cause();
  const bool runs = control_.mode() == msg::ArmMode::ARM_RUNNING;
  const bool observed = control_.mode() == msg::ArmMode::ARM_OBSERVED;
  const bool as_ordered = runs || observed || modes_.view().order(name_) != msg::Mode::MODE_RUN;
  report.state = as_ordered && modes_.view().heard() ? msg::NodeState::NODE_RUNNING : msg::NodeState::NODE_DEGRADED;
  report.oldest_input = "ArmCommand/" + name_;
  report.oldest_input_age = control_.command_age();
  heartbeat_.publish(loop_.now(), report, loop_.statistics());
}

}  // namespace hecaton::services
