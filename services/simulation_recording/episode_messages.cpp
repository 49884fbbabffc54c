#include "services/simulation_recording/episode_messages.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/planner.h>
#include <idl/world.h>

#include "services/bus/recorded_sample.hpp"
#include "services/messages/convert.hpp"
#include "services/planner/coordination_messages.hpp"
#include "services/planner/goal_manager.hpp"
#include "services/planner/motion_report.hpp"
#include "services/planner/progress_reporter.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/node_name.hpp"
#include "services/tick_log/program.hpp"
#include "services/tick_log/tick_writer.hpp"
#include "services/world/world_topics.hpp"

namespace hecaton::services {
namespace {

using msg::CauseKind;
using Samples = EpisodeMessages::Samples;

constexpr double kModePeriod = 0.025;   // of CellMode [s]
constexpr double kReportPeriod = 0.1;   // of ContactReport [s]
constexpr double kRounding = 1e-9;      // must not delay a message by a period [s]
constexpr double kNeverReceived = 1e9;  // age of an input, as in heartbeats [s]
constexpr const char* kClient = "simulate";

std::int64_t nanoseconds_of(double seconds) {
  return std::llround(seconds * 1e9);
}

/// Virtual time on the clock of live planners.
GoalManager::Clock::time_point at(double seconds) {
  return GoalManager::Clock::time_point(std::chrono::nanoseconds(nanoseconds_of(seconds)));
}

template <class T>
std::size_t topic_index() {
  std::size_t index = 0;
  while (bus::kTopics[index].name != bus::Topic<T>::kInfo.name) ++index;
  return index;
}

/// True once in each period of virtual time.
class Due {
 public:
  explicit Due(double period) : period_(period) {}
  bool operator()(double now) {
    if (now < next_ - kRounding) return false;
    next_ = std::max(next_ + period_, now);
    return true;
  }

 private:
  double period_;
  double next_ = 0.0;
};

/// A node of the cell, with its identity in the file.
struct Node {
  std::uint32_t number = 0;  ///< its process, in the identity of its writers
  std::string name;
  std::string host;
  msg::NodeKind kind = msg::NodeKind::NODE_OTHER;
  std::string arm;  ///< that it serves; empty: none
};

template <class T>
void add(Samples& samples, const Node& node, double time, const T& message) {
  static const std::size_t kTopic = topic_index<T>();
  recorder::RecordedSample& recorded = samples.emplace_back();
  recorded.sample.topic = kTopic;
  recorded.sample.bytes = bus::encode_recorded(message);
  recorded.sample.key = bus::key_of(message);
  const std::uint32_t process = node.number + 1;  // zeros are the identity of an unknown writer
  std::memcpy(recorded.sample.writer.bytes.data(), &process, sizeof process);
  recorded.sample.writer.bytes.back() = static_cast<std::uint8_t>(kTopic + 1);
  recorded.node = node.name;
  recorded.log_time = static_cast<std::uint64_t>(nanoseconds_of(time));
}

/// The input that a planner has longest been without.
struct OldestInput {
  double age = 0.0;  ///< [s]
  std::string topic_and_key;
  CauseKind kind = CauseKind::CAUSE_NONE;
};

OldestInput oldest_input(const planner::PlannerPeriod& period, const planner::Cell& cell) {
  OldestInput oldest{0.0, "ArmState/" + cell.arms[static_cast<std::size_t>(period.arm)].arm.name,
                     CauseKind::CAUSE_ARM_STATE_OLD};
  for (std::size_t i = 0; i < period.inputs.arms.size(); ++i) {
    if (static_cast<int>(i) == period.arm) continue;
    const planner::ArmObservation& arm = period.inputs.arms[i];
    const double age = arm.known ? arm.age : kNeverReceived;
    if (age > oldest.age) oldest = {age, "ArmState/" + cell.arms[i].arm.name, CauseKind::CAUSE_ARM_STATE_OLD};
  }
  for (const world::ObstacleState& obstacle : period.inputs.obstacles) {
    if (obstacle.age > oldest.age) oldest = {obstacle.age, "ObstacleStates", CauseKind::CAUSE_OBSTACLES_OLD};
  }
  return oldest;
}

/// The planner of one arm. Planners of different arms may work in different threads.
class PlannerMessages {
 public:
  PlannerMessages(const planner::Cell& cell, int arm, Node node, std::uint64_t term)
      : cell_(cell),
        arm_(arm),
        node_(std::move(node)),
        term_(term),
        names_(names_of(cell)),
        obstacles_(std::make_shared<const std::vector<world::Obstacle>>(cell.scene.obstacles)),
        goals_(name(), node_.name),
        ticks_(name(), arm, node_.name),
        motion_(name(), node_.name) {}

  void begin(const msg::Goal& goal, const planner::JointVector& q_goal) {
    goals_.receive(goal, at(0.0));
    if (const auto taken = goals_.next_to_resolve()) goals_.answer({.goal = *taken, .q_goal = q_goal}, at(0.0));
    static_cast<void>(goals_.take_change());
    write_statuses(0.0);
  }

  void plan(const planner::PlannerPeriod& period, bool heartbeat) {
    write_scans(period);
    write_tick(period);
    write_command(period);
    write_coordination(period);
    write_motion(period);
    report(period);
    write_statuses(period.time);
    if (heartbeat) write_heartbeat(period);
  }

  void end(const planner::ArmOutcome& outcome, double time) {
    if (!goals_.has_active()) return;
    Progress last = last_.value_or(Progress{});
    if (outcome.outcome == planner::TaskOutcome::kReached) {
      last.state = msg::GoalState::GOAL_REACHED;
      goals_.progress(last, at(time));
    } else if (time > cell_.tasks.time_limit - 0.5 * cell_.timing.control_period) {
      goals_.progress(last, at(std::max(time, cell_.tasks.time_limit) + 1e-3));
    } else {
      goals_.end_all(make_cause(CauseKind::CAUSE_PATH_BLOCKED, last.binding_other,
                                "the simulation ended the goal: " + outcome.reason),
                     at(time));
    }
    write_statuses(time);
  }

  void move_to(Samples& samples) {
    std::move(samples_.begin(), samples_.end(), std::back_inserter(samples));
    samples_.clear();
  }
  [[nodiscard]] const Node& node() const { return node_; }

 private:
  [[nodiscard]] const planner::PlannedArm& planned() const { return cell_.arms[static_cast<std::size_t>(arm_)]; }
  [[nodiscard]] const std::string& name() const { return planned().arm.name; }

  /// The simulation has no other reason to hold an arm.
  static std::optional<msg::Cause> hold_of(const planner::PlannerPeriod& period) {
    if (!period.inputs.hold) return std::nullopt;
    return make_cause(CauseKind::CAUSE_OBSTACLES_OLD, world_node(), "no state of the obstacles has been received");
  }

  void write_scans(const planner::PlannerPeriod& period) {
    for (const planner::RangeScan& scan : period.events.scans) {
      const planner::RangeSensor& sensor = planned().sensors[static_cast<std::size_t>(scan.sensor)];
      msg::RangeScan message = messages::to_message(scan, sensor);
      message.sensor(name() + "/" + sensor.name);
      message.arm(name());
      message.link(planned().arm.model->links[static_cast<std::size_t>(sensor.link)].name);
      message.sequence_number(++scans_);
      message.stamp_ns(nanoseconds_of(period.time));
      add(samples_, node_, period.time, message);
    }
  }

  void write_tick(const planner::PlannerPeriod& period) {
    if (!begun_) snapshot_ = TickWriter::Snapshot{{}, program_text(), period.options, obstacles_};
    begun_ = true;
    ticks_.begin(nanoseconds_of(period.time), period.events, snapshot_);
    ticks_.finish(period.inputs, period.result);
    add(samples_, node_, period.time, ticks_.message());
    if (snapshot_) snapshot_due_ = period.time + TickWriter::kSnapshotPeriod;
    snapshot_.reset();
    if (period.time + period.options.control_period < snapshot_due_) return;
    std::vector<std::uint32_t> memory = period.planner.save();
    if (memory.empty()) return;
    snapshot_ = TickWriter::Snapshot{std::move(memory), program_text(), period.options, obstacles_};
  }

  void write_command(const planner::PlannerPeriod& period) {
    msg::ArmCommand message;
    message.arm(name());
    message.term(term_);
    message.sequence_number(period.inputs.number);
    message.stamp_ns(nanoseconds_of(period.time));
    message.node(node_.name);
    message.period(period.options.control_period);
    message.q(messages::to_message(period.result.q));
    message.qd(messages::to_message(period.result.qd));
    add(samples_, node_, period.time, message);
  }

  void write_coordination(const planner::PlannerPeriod& period) {
    const auto& proposal = period.planner.proposal();
    if (!coordinated_ || proposal != proposal_) {
      proposal_ = proposal;
      msg::CoupledPlan message = coupled_plan_message(proposal.get(), names_);
      message.arm(name());
      message.node(node_.name);
      message.stamp_ns(nanoseconds_of(period.time));
      add(samples_, node_, period.time, message);
    }
    if (!coordinated_ || period.planner.progress() != progress_) {
      progress_ = period.planner.progress();
      msg::CoupledPlanProgress message = progress_message(progress_, names_);
      message.arm(name());
      message.node(node_.name);
      message.stamp_ns(nanoseconds_of(period.time));
      add(samples_, node_, period.time, message);
    }
    coordinated_ = true;
  }

  void write_motion(const planner::PlannerPeriod& period) {
    const auto& rollout = period.inputs.answers.rollout;
    if (!motion_.update(period.time, period.planner, rollout ? &*rollout : nullptr)) return;
    motion_.message().stamp_ns(nanoseconds_of(period.time));
    add(samples_, node_, period.time, motion_.message());
  }

  void report(const planner::PlannerPeriod& period) {
    const msg::Cause follows;
    const std::optional planned(
        ProgressReporter::Planned{period.inputs, period.result, period.inputs.own.state.q, follows});
    const std::optional<msg::Cause> hold = hold_of(period);
    auto progress = reporter_.report({.planner = period.planner,
                                      .planned = planned,
                                      .hold = hold,
                                      .q_goal = goals_.has_active() ? &goals_.q_goal() : nullptr});
    if (!progress) return;
    goals_.progress(*progress, at(period.time));
    last_ = std::move(progress);
  }

  void write_statuses(double time) {
    for (msg::GoalStatus& status : goals_.take_statuses()) {
      status.term(term_);
      status.stamp_ns(nanoseconds_of(time));
      add(samples_, node_, time, status);
    }
  }

  void write_heartbeat(const planner::PlannerPeriod& period) {
    const OldestInput oldest = oldest_input(period, cell_);
    const bool starved = oldest.age > planned().parameters.state_age_limit || period.inputs.hold;
    msg::Heartbeat message;
    message.state(starved ? msg::NodeState::NODE_DEGRADED : msg::NodeState::NODE_RUNNING);
    if (starved) {
      message.cause(hold_of(period).value_or(
          make_cause(oldest.kind, oldest.topic_and_key, oldest.topic_and_key + " is old or missing")));
    }
    message.oldest_input(oldest.topic_and_key);
    message.oldest_input_age(oldest.age);
    message.ticks(period.inputs.number);
    message.node(node_.name);
    message.kind(node_.kind);
    message.subject(node_.arm);
    message.host(node_.host);
    message.term(term_);
    message.sequence_number(++heartbeats_);
    message.stamp_ns(nanoseconds_of(period.time));
    add(samples_, node_, period.time, message);
  }

  const planner::Cell& cell_;
  int arm_;
  Node node_;
  std::uint64_t term_;
  std::vector<std::string> names_;
  planner::SharedObstacles obstacles_;
  GoalManager goals_;
  ProgressReporter reporter_;
  std::optional<Progress> last_;  ///< of the goal
  TickWriter ticks_;
  MotionReport motion_;
  bool begun_ = false;                            ///< a tick was written
  std::optional<TickWriter::Snapshot> snapshot_;  ///< of the next period
  double snapshot_due_ = 0.0;                     ///< [s]
  bool coordinated_ = false;                      ///< plans below were published
  std::shared_ptr<const planner::CoupledPlan> proposal_;
  planner::CoupledPlanProgress progress_;
  std::uint64_t scans_ = 0;  ///< sequence numbers
  std::uint64_t heartbeats_ = 0;
  Samples samples_;
};

}  // namespace

class EpisodeMessages::Impl {
 public:
  Impl(const config::CellFile& file, const planner::Cell& cell, int episode)
      : cell_(cell),
        goal_("episode-" + std::to_string(episode + 1)),
        term_(static_cast<std::uint64_t>(episode) + 1),
        heartbeat_due_(0.5e-9 * static_cast<double>(file.supervision.host_lease.count())) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < cell.arms.size(); ++i) {
      const std::string& arm = cell.arms[i].arm.name;
      const PlacedNode planner = planners_of(file, i).front();
      planners_.push_back(std::make_unique<PlannerMessages>(
          cell, static_cast<int>(i), Node{number++, planner.node, planner.host, msg::NodeKind::NODE_PLANNER, arm},
          term_));
      drivers_.push_back({number++, driver_node(arm), file.arm_hosts[i].host, msg::NodeKind::NODE_DRIVER, arm});
    }
    const PlacedNode supervisor = supervisors_of(file).front();
    world_ = {number++, world_node(), file.world_host, msg::NodeKind::NODE_WORLD, {}};
    supervisor_ = {number++, supervisor.node, supervisor.host, msg::NodeKind::NODE_SUPERVISOR, {}};
    client_ = {number++, kClient, {}, msg::NodeKind::NODE_CLIENT, {}};
  }

  void begin(const planner::CellConfiguration& goals) {
    write_mode(0.0);
    for (const world::Obstacle& obstacle : cell_.scene.obstacles) {
      msg::ObstacleShapes message;
      message.name(obstacle.name);
      message.term(term_);
      message.obstacle(messages::to_message(obstacle));
      add(samples_, world_, 0.0, message);
    }
    for (std::size_t i = 0; i < planners_.size(); ++i) {
      msg::Goal goal;
      goal.arm(cell_.arms[i].arm.name);
      goal.goal(goal_);
      goal.sequence_number(i + 1);
      goal.client(kClient);
      goal.kind(msg::GoalKind::GOAL_JOINTS);
      goal.q(messages::to_message(goals[i]));
      goal.time_limit(cell_.tasks.time_limit);
      add(samples_, client_, 0.0, goal);
      planners_[i]->begin(goal, goals[i]);
    }
    take_planned();
  }

  void publish(const planner::CellMoment& moment) {
    take_planned();
    heartbeats_ = heartbeat_due_(moment.time);
    if (mode_due_(moment.time)) write_mode(moment.time);
    for (std::size_t i = 0; i < drivers_.size(); ++i) write_arm(i, moment);
    write_obstacles(moment);
    write_contacts(moment);
    if (heartbeats_) {
      for (const Node& driver : drivers_) write_heartbeat(driver, moment.time);
      write_heartbeat(world_, moment.time);
      write_heartbeat(supervisor_, moment.time);
    }
    ++periods_;
  }

  void plan(const planner::PlannerPeriod& period) {
    planners_[static_cast<std::size_t>(period.arm)]->plan(period, heartbeats_);
  }

  void end(const planner::EpisodeOutcome& outcome) {
    if (outcome.ended_early) return;
    for (std::size_t i = 0; i < planners_.size(); ++i) planners_[i]->end(outcome.arms[i], outcome.duration);
    take_planned();
  }

  [[nodiscard]] Samples take() { return std::exchange(samples_, {}); }

 private:
  void take_planned() {
    for (const auto& planner : planners_) planner->move_to(samples_);
  }

  void write_mode(double time) {
    msg::CellMode message;
    message.term(term_);
    message.sequence_number(++modes_);
    message.stamp_ns(nanoseconds_of(time));
    message.node(supervisor_.name);
    message.mode(msg::Mode::MODE_RUN);
    message.ordered(msg::Mode::MODE_RUN);
    add(samples_, supervisor_, time, message);
  }

  void write_arm(std::size_t i, const planner::CellMoment& moment) {
    const std::string& name = cell_.arms[i].arm.name;
    const bool commanded = periods_ > 0;
    msg::ArmState message;
    message.arm(name);
    message.sequence_number(periods_ + 1);
    message.stamp_ns(nanoseconds_of(moment.time));
    message.q(messages::to_message(moment.arms[i].q));
    message.qd(messages::to_message(moment.arms[i].qd));
    message.carried(carried(name));
    message.newest_term(term_);
    message.mode(commanded ? msg::ArmMode::ARM_RUNNING : msg::ArmMode::ARM_STARTING);
    if (commanded) {
      message.term(term_);
      message.planner(planners_[i]->node().name);
      message.command_sequence_number(periods_);
      message.command_age(cell_.timing.control_period);
    } else {
      message.cause(make_cause(CauseKind::CAUSE_STARTING, name, "no command received yet"));
    }
    add(samples_, drivers_[i], moment.time, message);
  }

  [[nodiscard]] std::string carried(const std::string& arm) const {
    std::string names;
    for (const world::Obstacle& obstacle : cell_.scene.obstacles) {
      if (!obstacle.attachment || obstacle.attachment->arm != arm) continue;
      names.append(names.empty() ? "" : ", ").append(obstacle.name);
    }
    return names;
  }

  void write_obstacles(const planner::CellMoment& moment) {
    msg::ObstacleStates message = messages::to_message(moment.obstacles, cell_.scene.obstacles);
    message.term(term_);
    message.sequence_number(periods_ + 1);
    message.stamp_ns(nanoseconds_of(moment.time));
    add(samples_, world_, moment.time, message);
  }

  void write_contacts(const planner::CellMoment& moment) {
    const std::uint64_t before = std::exchange(contacts_, moment.contacts.contacts);
    const bool periodic = report_due_(moment.time);
    if (!periodic && contacts_ == before) return;
    msg::ContactReport message = contact_report(moment.contacts, moment.obstacles.time, true);
    message.term(term_);
    message.sequence_number(++reports_);
    message.stamp_ns(nanoseconds_of(moment.time));
    add(samples_, world_, moment.time, message);
    for (std::uint64_t i = before; i < std::min<std::uint64_t>(contacts_, moment.contacts.events.size()); ++i) {
      write_fault(moment.contacts.events[i], i + 1, moment.time);
    }
  }

  /// As the supervisor reports a contact: it is over at once.
  void write_fault(const world::Separation& contact, std::uint64_t number, double time) {
    msg::Fault message;
    message.id("f" + std::to_string(term_) + "-" + std::to_string(number));
    message.term(term_);
    message.stamp_ns(nanoseconds_of(time));
    message.severity(msg::Severity::SEVERITY_CRITICAL);
    message.cause(make_cause(CauseKind::CAUSE_CONTACT, contact.a, contact.a + " touched " + contact.b));
    message.since_ns(nanoseconds_of(time));
    message.since_unix_ms(nanoseconds_of(time) / 1'000'000);
    message.sequence_number(++faults_);
    add(samples_, supervisor_, time, message);
    message.sequence_number(++faults_);
    message.cleared(true);
    message.cleared_ns(nanoseconds_of(time));
    add(samples_, supervisor_, time, message);
  }

  void write_heartbeat(const Node& node, double time) {
    msg::Heartbeat message;
    message.node(node.name);
    message.kind(node.kind);
    message.subject(node.arm);
    message.host(node.host);
    message.state(msg::NodeState::NODE_RUNNING);
    message.term(term_);
    message.sequence_number(periods_ + 1);
    message.stamp_ns(nanoseconds_of(time));
    message.ticks(periods_);
    add(samples_, node, time, message);
  }

  const planner::Cell& cell_;
  std::string goal_;  ///< its id, the same for all arms
  std::uint64_t term_;
  std::vector<std::unique_ptr<PlannerMessages>> planners_;
  std::vector<Node> drivers_;
  Node world_;
  Node supervisor_;
  Node client_;
  Due heartbeat_due_;
  Due mode_due_{kModePeriod};
  Due report_due_{kReportPeriod};
  bool heartbeats_ = false;  ///< are due in this period
  std::uint64_t periods_ = 0;
  std::uint64_t contacts_ = 0;
  std::uint64_t modes_ = 0;  ///< sequence numbers
  std::uint64_t reports_ = 0;
  std::uint64_t faults_ = 0;
  Samples samples_;
};

EpisodeMessages::EpisodeMessages(const config::CellFile& file, const planner::Cell& cell, int episode)
    : impl_(std::make_unique<Impl>(file, cell, episode)) {}

EpisodeMessages::~EpisodeMessages() = default;

void EpisodeMessages::begin(const planner::CellConfiguration& goals) {
  impl_->begin(goals);
}

void EpisodeMessages::publish(const planner::CellMoment& moment) {
  impl_->publish(moment);
}

void EpisodeMessages::plan(const planner::PlannerPeriod& period) {
  impl_->plan(period);
}

void EpisodeMessages::end(const planner::EpisodeOutcome& outcome) {
  impl_->end(outcome);
}

EpisodeMessages::Samples EpisodeMessages::take() {
  return impl_->take();
}

}  // namespace hecaton::services
