#include "services/arm_driver/devices/ros2_control/ros2_control_arm.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <thread>
#include <utility>

#include "services/arm_driver/devices/duration_text.hpp"
#include "services/arm_driver/devices/largest_step.hpp"
#include "services/arm_driver/devices/ros2_control/commands.hpp"
#include "services/arm_driver/devices/ros2_control/connection.hpp"
#include "services/arm_driver/devices/ros2_control/joint_states.hpp"
#include "services/arm_driver/devices/ros2_control/motion_watch.hpp"
#include "services/arm_driver/devices/ros2_control/results.hpp"
#include "services/arm_driver/devices/ros2_control/velocity_commands.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::device {
namespace ros2_control {
namespace {

/// Nodes on a network find each other within this time.
constexpr std::chrono::seconds kDiscovery{5};
/// Before the first motion the device listens for this time whether another node publishes the same joints.
constexpr std::chrono::seconds kListening{1};
/// An action server accepts or refuses a goal within this time.
constexpr std::chrono::seconds kAnswer{1};
/// Trajectories in the time of the lookahead.
constexpr int kTrajectoriesAhead = 4;
constexpr int kGoalsAhead = 2;               // the same as goals of an action
constexpr std::int32_t kPathTolerance = -4;  // results with it, or below, are failures of the motion
/// Smaller changes of a set-point at rest are not sent [rad | m], [rad/s | m/s].
constexpr double kUnchanged = 1e-6;
/// At a lower speed scaling the lag is not computed any more.
constexpr double kSlowest = 0.05;
constexpr double kLongestDelay = 1.0;  // [s]
/// Time constant with which the lag follows a change of the speed scaling [s].
constexpr double kSettling = 0.3;
/// After a stop of a velocity controller, velocities of zero are sent for this time, and until each joint is slower.
constexpr std::chrono::milliseconds kZeros{500};
constexpr double kAtRest = 0.02;  // [rad/s | m/s]
/// The last messages of a process, in case that one is lost.
constexpr int kLastZeros = 5;

struct Condition {
  DeviceMode mode = DeviceMode::kReady;
  std::string text;
};

class Ros2ControlArm final : public ArmDevice {
 public:
  Ros2ControlArm(const DeviceSetup& setup, Options options)
      : arm_(setup.arm),
        limits_(setup.limits),
        period_(setup.period),
        silence_limit_(setup.command_timeout),
        log_(setup.log),
        options_(std::move(options)),
        outside_(setup.outside),
        fingers_(setup.fingers),
        states_(options_.joints, setup.command_timeout),
        velocities_(limits_, options_.tracking_delay),
        may_move_(options_.interface == Interface::kVelocity ? setup.checkpoint : "", 0,
                  "whether a velocity controller may move the arm") {
    // A driver before this one may have left its last velocity behind.
    if (may_move_.recall().value_or(false)) stops_since_ = Clock::now();
  }

  // Nothing else would stop the arm.
  ~Ros2ControlArm() override {
    if (!stops_since_ || !connection_) return;
    int zeros = 0;
    while (zeros < kLastZeros) {
      send_braking(Clock::now());
      if (velocities_.last().isZero()) ++zeros;
      std::this_thread::sleep_for(period_);
    }
    may_move_.remember(false);
  }
  Ros2ControlArm(const Ros2ControlArm&) = delete;
  Ros2ControlArm& operator=(const Ros2ControlArm&) = delete;

  DeviceResult configure() override {
    now_ = opened_at_ = Clock::now();
    end_following();
    states_.forget();
    measured_since_.reset();
    try {
      if (connection_) {
        (void)connection_->joint_states();
      } else {
        connection_.emplace(options_, silence_limit_);
      }
    } catch (const std::exception& error) {
      return DeviceFailure{"cannot join " + domain() + ": " + error.what()};
    }
    return {};
  }

  DeviceResult activate() override {
    follows_ = true;
    set_point_ = states_.measured().q;
    set_point_at_ = now_;
    sent_.reset();
    if (options_.interface == Interface::kVelocity) {
      velocities_.begin(set_point_, now_);
      stops_since_.reset();
      may_move_.remember(true);
    }
    // A server that refuses its first goal is found before the arm counts as ready.
    if (connection_->action() == nullptr) return {};
    begun_ = false;
    send_trajectory({set_point_, JointVector::Zero(set_point_.size())});
    if (!sent_) return DeviceFailure{"the middleware refuses a goal for " + controller()};
    return {};
  }

  DeviceState read(Clock::time_point now) override {
    const double dt = std::chrono::duration<double>(now - std::exchange(now_, now)).count();
    connection_->update();
    for (const bus::ros2::Sample& sample : connection_->joint_states()) {
      states_.take(sample.bytes, sample.writer, sample.received);
      if (connection_->gripper() != nullptr) connection_->gripper()->take(sample);
    }
    if (connection_->gripper() != nullptr) connection_->gripper()->update(now);
    if (connection_->action() != nullptr) watch_goals();
    const double speed = connection_->speed_scaling(now).value_or(1.0);
    settled_speed_ += (speed - settled_speed_) * std::clamp(dt / kSettling, 0.0, 1.0);
    if (follows_ && options_.interface == Interface::kVelocity && now - set_point_at_ > valid_for_) {
      send_braking(now);
    } else if (stops_since_) {
      stop_moving(now);
    }
    if (auto why = conflict()) return {{}, {}, 1.0, DeviceMode::kFailed, std::move(*why)};
    JointState measured = states_.measured();
    if (measured.q.size() == 0) {
      Condition condition = absent();
      return {{}, {}, 1.0, condition.mode, std::move(condition.text)};
    }
    if (!measured_since_) measured_since_ = now;
    if (!std::exchange(was_heard_, true) && log_) log_("joint states arrive", options_.joint_states);
    const Clock::duration age = std::max(Clock::duration::zero(), now - states_.received());
    if (age >= silence_limit_) return {{}, {}, 1.0, DeviceMode::kFailed, silence()};
    if (follows_) watch_.add(now, set_point_, measured.q, tracking_delay());
    Condition condition = this->condition();
    return {std::move(measured), age, speed, condition.mode, std::move(condition.text)};
  }

  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) override {
    if (!follows_) return {};
    if (auto why = jump(limits_.velocity, set_point_, set_point.q, now_ - set_point_at_ + period_)) {
      return DeviceFailure{std::move(*why)};
    }
    set_point_ = set_point.q;
    set_point_at_ = now_;
    valid_for_ = valid_for;
    if (options_.interface == Interface::kPosition) {
      (void)connection_->send(values_of(set_point.q));  // the next one follows in a period
    } else if (options_.interface == Interface::kVelocity) {
      send_velocity(set_point);
    } else {
      send_trajectory(set_point);
    }
    return {};
  }

  // The last trajectory ends at rest, and a forward controller stays at the last position. A goal is cancelled. A
  // velocity controller gets velocities of the stop profile, and then of zero, while read() is called.
  void stop(std::string_view /*reason*/) override { end_following(); }
  void deactivate() override { end_following(); }

  [[nodiscard]] std::vector<double> outside() const override {
    if (!connection_ || connection_->gripper() == nullptr) return {};
    const std::vector<double> measured = connection_->gripper()->positions(now_);
    if (measured.empty()) return {};
    std::vector<double> positions = outside_;
    for (std::size_t joint = 0, finger = 0; joint < positions.size(); ++joint) {
      if (fingers_[joint]) positions[joint] = measured[finger++];
    }
    return positions;
  }
  DeviceResult move_outside(const std::vector<double>& positions, double force) override {
    if (!connection_ || connection_->gripper() == nullptr) return DeviceFailure{"its gripper is not connected yet"};
    std::vector<double> target;
    for (std::size_t joint = 0; joint < positions.size(); ++joint) {
      if (fingers_[joint]) target.push_back(positions[joint]);
    }
    return connection_->gripper()->move(target, force, now_);
  }
  [[nodiscard]] bool fingers_yield() const override { return options_.gripper.has_value(); }
  [[nodiscard]] std::optional<OrderEnd> outside_end() override {
    if (!connection_ || connection_->gripper() == nullptr) return {};
    return connection_->gripper()->end();
  }

  [[nodiscard]] double tracking_delay() const override {
    const double speed = std::max(kSlowest, settled_speed_);
    const double delay = options_.interface == Interface::kVelocity
                             ? VelocityCommands::delay(options_.tracking_delay, speed)
                             : options_.tracking_delay / speed;
    return std::min(kLongestDelay, delay);
  }

 private:
  struct Sent {
    JointState set_point;
    Clock::time_point at;
  };

  void end_following() {
    if (follows_ && options_.interface == Interface::kVelocity) stops_since_ = now_;
    follows_ = false;
    watch_.forget();
    ended_.reset();
    if (connection_ && connection_->action() != nullptr) connection_->action()->cancel();
  }

  void send_velocity(const JointState& set_point) {
    const JointState measured = states_.measured();
    if (measured.q.size() == 0) return send_braking(now_);
    const double speed = std::min(connection_->speed_scaling(now_).value_or(1.0), settled_speed_);
    const MeasuredPosition position{measured.q, states_.received()};
    (void)connection_->send(values_of(velocities_.follow(set_point, now_ + period_, position, speed, now_)));
  }
  void send_braking(Clock::time_point now) {
    if (velocities_.last().size() == 0) velocities_.begin(JointVector::Zero(limits_.lower.size()), now);
    (void)connection_->send(values_of(velocities_.brake(now)));
  }
  // Another node may use the controller as soon as the arm stands.
  void stop_moving(Clock::time_point now) {
    if (!connection_->has_controller()) stops_since_ = now;
    send_braking(now);
    const JointState measured = states_.measured();
    const bool fresh = measured.q.size() > 0 && now - states_.received() < silence_limit_;
    const bool stands = fresh && (measured.qd.array().abs() < kAtRest).all() && velocities_.last().isZero();
    if (!stands || now - *stops_since_ < kZeros) return;
    stops_since_.reset();
    may_move_.remember(false);
  }

  // Why the goals cannot go on. A server ends each goal that the next one replaces, with its own codes.
  void watch_goals() {
    for (const TrajectoryAction::End& end : connection_->action()->update()) {
      const bool failed = end.accepted && end.result.error_code <= kPathTolerance;
      if (ended_ || end.status == GoalStatus::kSucceeded || (!end.newest && !failed)) continue;
      if (!end.accepted) {
        ended_ = controller() + " refuses a trajectory: activate it in ROS 2, see its log for the reason";
      } else if (end.status == GoalStatus::kCanceled && !failed) {
        ended_ = controller() + " or another node has cancelled the trajectory: " + reason_of(end.result);
      } else if (end.status == GoalStatus::kUnknown) {
        ended_ = controller() + " does not know the trajectory any more: it was restarted";
      } else {
        ended_ = controller() + " has aborted the trajectory: " + reason_of(end.result);
      }
      if (log_) log_("trajectory ended", *ended_);
    }
    if (!ended_ && connection_->action()->accepted()) begun_ = true;
    const auto since = connection_->action()->unanswered_since();
    if (!ended_ && since && now_ - *since > std::max<Clock::duration>(kAnswer, silence_limit_)) {
      ended_ = controller() + " has not answered a trajectory for " + milliseconds(now_ - *since) +
               ": see its log and check the network";
    }
  }

  // The controller begins each trajectory at the measured position. A set-point at rest is sent once: repeating it
  // would let an arm sag that does not reach it.
  void send_trajectory(const JointState& set_point) {
    if (sent_) {
      const JointState& before = sent_->set_point;
      const bool rests = set_point.qd.isZero(kUnchanged) && before.qd.isZero(kUnchanged);
      if (rests && (set_point.q - before.q).isZero(kUnchanged)) return;
      // The server must answer a goal before it gets the next one.
      if (connection_->action() != nullptr && connection_->action()->unanswered_since()) return;
      const int ahead = connection_->action() != nullptr ? kGoalsAhead : kTrajectoriesAhead;
      const std::chrono::duration<double> between(options_.lookahead / ahead);
      if (now_ - sent_->at + period_ / 2 < between) return;
    }
    if (connection_->send(stopping_trajectory(options_.joints, set_point, options_.lookahead, limits_), now_)) {
      sent_ = {set_point, now_};
    }
  }

  [[nodiscard]] std::string resume() const { return "'hecaton resume " + arm_ + "'"; }
  [[nodiscard]] std::string domain() const { return "domain " + std::to_string(options_.domain) + " of ROS 2"; }
  [[nodiscard]] std::string topic() const { return "topic " + options_.joint_states + " in " + domain(); }
  [[nodiscard]] std::string controller() const { return "the controller " + options_.controller; }
  [[nodiscard]] bool is_new() const { return now_ - opened_at_ < kDiscovery; }

  // A lost arm stays lost until it reports again. One that has never reported may not have been started yet.
  [[nodiscard]] Condition absent() const {
    if (was_heard_ || is_new()) return {DeviceMode::kStarting, "waits for joint states on " + topic()};
    if (!states_.was_heard()) {
      return {DeviceMode::kNotReady, "no joint states arrive on " + topic() +
                                         ": start joint_state_broadcaster, and check domain, namespace, firewall and "
                                         "ROS_LOCALHOST_ONLY"};
    }
    const std::string complaint = states_.complaint();
    return {DeviceMode::kNotReady, "no state of the arm on " + topic() + ": " +
                                       (complaint.empty() ? "a joint has no velocity yet" : complaint) +
                                       "; set joints or joint_prefix in the cell file"};
  }

  [[nodiscard]] std::string silence() const {
    const std::string complaint = states_.complaint();
    return "no state of the arm on " + topic() + " for " + milliseconds(silence_limit_) + ": " +
           (complaint.empty() ? "check the machine of its controllers and the network" : complaint) + ", then call " +
           resume();
  }

  [[nodiscard]] std::optional<std::string> conflict() const {
    const auto joint = states_.twice_published(now_);
    if (!joint) return std::nullopt;
    return "two nodes publish joint " + *joint + " on " + topic() +
           ", so the position of the arm is not known: end one of them, such as joint_state_publisher, then call " +
           resume();
  }

  // Why the arm cannot be moved: controller, speed scaling, motion.
  [[nodiscard]] Condition condition() const {
    if (now_ - *measured_since_ < kListening) {
      return {DeviceMode::kStarting, "listens whether another node publishes the joints of the arm"};
    }
    if (!connection_->has_controller())
      return missing((connection_->action() != nullptr ? "nothing serves the action follow_joint_trajectory of "
                                                       : "nothing reads commands of ") +
                     controller());
    if (options_.interface == Interface::kTrajectory && !connection_->controller_runs(now_)) {
      return missing(controller() + " publishes no controller_state, so it is not active");
    }
    if (!connection_->speed_scaling(now_)) {
      return missing("no speed scaling arrives on topic " + *options_.speed_scaling);
    }
    if (ended_) {
      return {DeviceMode::kProgramStopped, *ended_ + "; look at the robot, then call " + resume()};
    }
    if (follows_ && connection_->action() != nullptr && !begun_) {
      return {DeviceMode::kStarting, "waits for the answer of " + controller()};
    }
    if (follows_ && velocities_.lost()) return {DeviceMode::kProgramStopped, lost(*velocities_.lost())};
    if (const auto joint = watch_.idle_joint()) {
      return {DeviceMode::kProgramStopped,
              "joint " + options_.joints[static_cast<std::size_t>(*joint)] +
                  " stands still although its set-points move: look at the robot, activate " + controller() +
                  ", then call " + resume()};
    }
    return {};
  }

  [[nodiscard]] std::string lost(const LostJoint& lost) const {
    char distance[96];
    std::snprintf(distance, sizeof distance, "%.3f from where its set-points lead (limit %.3f)", lost.distance,
                  lost.limit);
    return "joint " + options_.joints[static_cast<std::size_t>(lost.joint)] + " is " + distance +
           ": look at the robot, activate " + controller() +
           ", compare the order of its joints with that of the cell file, then call " + resume();
  }

  [[nodiscard]] Condition missing(const std::string& what) const {
    if (follows_)
      return {DeviceMode::kProgramStopped, what + ": look at the robot, activate it in ROS 2, then call " + resume()};
    if (is_new()) return {DeviceMode::kStarting, "waits, because " + what};
    return {DeviceMode::kNotReady, what + " (" + domain() + "): activate it in ROS 2, then call " + resume()};
  }

  std::string arm_;
  JointLimits limits_;
  Clock::duration period_;
  Clock::duration silence_limit_;
  DeviceLog log_;
  Options options_;
  std::vector<double> outside_;
  std::vector<bool> fingers_;
  JointStates states_;
  std::optional<Connection> connection_;  ///< from the first configure() on
  MotionWatch watch_;
  VelocityCommands velocities_;                        ///< of a velocity controller
  services::MappedRecord<bool> may_move_;              ///< its last velocity may not have been zero
  std::optional<Clock::time_point> stops_since_ = {};  ///< it gets zeros, because the device does not follow
  std::chrono::nanoseconds valid_for_{0};              ///< of the last set-point
  bool follows_ = false;                               ///< active
  bool was_heard_ = false;                             ///< since the object began
  bool begun_ = false;                ///< the server has accepted a goal since the driver activated the device
  std::optional<std::string> ended_;  ///< why the goals of an action cannot go on, while the device follows
  JointVector set_point_;             ///< the last one, or measured when the driver activated the device
  Clock::time_point set_point_at_;
  std::optional<Clock::time_point> measured_since_;  ///< the arm is measured; since configure()
  std::optional<Sent> sent_;                         ///< the last trajectory since then
  double settled_speed_ = 1.0;                       ///< speed scaling to which the lag has settled
  Clock::time_point now_, opened_at_;
};

}  // namespace
}  // namespace ros2_control

std::unique_ptr<ArmDevice> make_ros2_control_arm(const DeviceSetup& setup) {
  return std::make_unique<ros2_control::Ros2ControlArm>(setup, ros2_control::read_options(setup));
}

std::vector<Claim> ros2_control_claims(const DeviceSetup& setup) {
  const ros2_control::Options options = ros2_control::read_options(setup);
  const std::string domain = " in domain " + std::to_string(options.domain) + " of ROS 2";
  std::vector<Claim> claims{{options.controller + domain, "controller"}};
  if (options.gripper) claims.push_back({options.gripper->controller + domain, "gripper_controller"});
  return claims;
}

bool ros2_control_goes_on(const DeviceSetup& setup) {
  return ros2_control::read_options(setup).interface == ros2_control::Interface::kVelocity;
}

std::vector<std::string> ros2_control_notes(const DeviceSetup& setup, const planner::RobotModel& /*model*/) {
  const ros2_control::Options options = ros2_control::read_options(setup);
  using ros2_control::Interface;
  const bool position = options.interface == Interface::kPosition;
  const bool velocity = options.interface == Interface::kVelocity;
  const bool action = options.interface == Interface::kAction;
  std::string joints;
  for (const std::string& joint : options.joints) joints += (joints.empty() ? "" : ", ") + joint;
  std::vector<std::string> notes{"arm " + setup.arm + ": its driver sends to " + options.controller +
                                 (action                 ? "/follow_joint_trajectory"
                                  : position || velocity ? "/commands"
                                                         : "/joint_trajectory") +
                                 " and reads " + options.joint_states + " in domain " + std::to_string(options.domain) +
                                 " of ROS 2; its joints there are " + joints};
  notes.push_back("arm " + setup.arm +
                  ": each node in that domain can move the arm; keep the domain to its own network");
  if (options.gripper) {
    std::string fingers;
    for (const std::string& joint : options.gripper->joints) fingers += (fingers.empty() ? "" : ", ") + joint;
    notes.push_back("arm " + setup.arm + ": its gripper is moved by " + options.gripper->controller +
                    (options.gripper->action ? "/gripper_cmd" : "/commands") + ", and measured by " +
                    options.joint_states + " of " + fingers);
  }
  if (position) {
    notes.push_back("arm " + setup.arm +
                    ": when its driver dies, the controller goes to the last set-point at once and stays there; "
                    "interface: trajectory brakes instead");
  }
  if (velocity) {
    notes.push_back("arm " + setup.arm +
                    ": when its driver dies, or a cable is cut, the arm goes on at its last velocity, until a driver "
                    "that was restarted stops it, or the hardware does; interface: trajectory brakes instead");
  }
  return notes;
}

}  // namespace hecaton::device
