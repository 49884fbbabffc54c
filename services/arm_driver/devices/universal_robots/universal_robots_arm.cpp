#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "planner/model/robot_model.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/arm_driver/devices/duration_text.hpp"
#include "services/arm_driver/devices/universal_robots/calibration.hpp"
#include "services/arm_driver/devices/universal_robots/dashboard.hpp"
#include "services/arm_driver/devices/universal_robots/io_ports.hpp"
#include "services/arm_driver/devices/universal_robots/options.hpp"
#include "services/arm_driver/devices/universal_robots/primary.hpp"
#include "services/arm_driver/devices/universal_robots/program.hpp"
#include "services/arm_driver/devices/universal_robots/robot_state.hpp"
#include "services/arm_driver/devices/universal_robots/robot_type.hpp"
#include "services/arm_driver/devices/universal_robots/rtde_client.hpp"
#include "services/arm_driver/devices/universal_robots/tcp.hpp"

namespace hecaton::device {
namespace {

using namespace universal_robots;

constexpr int kPrimaryPort = 30001;
constexpr int kJoints = 6;
/// From sending the program to its connection.
constexpr std::chrono::seconds kProgramStart{5};
/// The robot's state says why a program has ended, at the latest this long after its connection has closed.
constexpr std::chrono::milliseconds kExplanation{50};
/// A program that the driver has ended stops the arm, and needs less time beside that. One that plays longer is another
/// one.
constexpr std::chrono::seconds kOtherProgram{2};
constexpr std::chrono::seconds kRemoteControlPeriod{1};
constexpr std::string_view kAskModel = "get robot model";
/// A robot whose dashboard does not name its model within this time is moved all the same. One that has no dashboard is
/// moved sooner.
constexpr std::chrono::seconds kModelLimit{10};
constexpr std::chrono::seconds kDashboardLimit{1};
/// A robot that does not send its calibration within this time of a connection is moved all the same.
constexpr std::chrono::seconds kCalibrationLimit{3};
/// A flange that is farther from where the description expects it belongs to another type of robot. The nearest ones,
/// UR10 and UR10e, are 11.5 mm apart. A calibration moves it by some millimetres [m].
constexpr double kOtherRobot = 0.010;
/// Below this a description has the calibration of its robot [m].
constexpr double kSameCalibration = 0.0005;
/// At a lower speed scaling the lag is not computed any more.
constexpr double kSlowest = 0.05;
constexpr double kLongestDelay = 1.0;  // [s]
/// Time constant with which the lag follows a change of the speed scaling [s].
constexpr double kSettling = 0.3;

/// The ports of the signals. signal_kinds() has refused others.
std::vector<IoPort> ports_of(const DeviceSetup& setup) {
  std::vector<IoPort> ports;
  for (const std::string& port : setup.signals) ports.push_back(parse_port(port).value_or(IoPort{}));
  return ports;
}

std::string millimetres(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f mm", length * 1e3);
  return text.data();
}

class UniversalRobotsArm final : public ArmDevice {
 public:
  UniversalRobotsArm(const DeviceSetup& setup, Options options)
      : arm_(setup.arm),
        limits_(setup.limits),
        longest_end_(kOtherProgram + std::chrono::duration_cast<Clock::duration>(
                                         std::chrono::duration<double>(planner::longest_stop_time(setup.limits)))),
        options_(std::move(options)),
        ports_(ports_of(setup)),
        description_(setup.model),
        rtde_({options_.robot_ip, 1.0 / std::chrono::duration<double>(setup.period).count(), options_.speed_slider,
               ports_},
              setup.log),
        log_(setup.log) {}

  DeviceResult configure() override {
    now_ = Clock::now();
    close_program();
    brakes_.cancel();
    if (order_.runs)
      end_order(
          DeviceFailure{"the connection to its robot was lost before the robot answered: look at "
                        "the robot, then call again"});
    if (auto failure = listener_.listen(options_.reverse_port)) return failure;
    rtde_.open(now_);
    connect_primary();
    dashboard_.open(options_.robot_ip, now_);
    remote_control_ = {};
    configured_at_ = now_;
    model_.clear();
    model_answered_ = false;
    flange_difference_.reset();
    return {};
  }

  DeviceResult activate() override {
    close_program();
    if (primary_.state() == TcpConnection::State::kClosed) connect_primary();
    program_.phase = Program::Phase::kSending;
    program_.since = now_;
    remote_control_ = {};
    return {};
  }

  DeviceState read(Clock::time_point now) override {
    const double dt = std::chrono::duration<double>(now - std::exchange(now_, now)).count();
    rtde_.update(now);
    update_primary();
    dashboard_.update(now);
    update_program();
    if (rtde_.failed()) return {{}, {}, 1.0, DeviceMode::kFailed, rtde_.error()};
    if (!rtde_.data()) return {{}, {}, 1.0, DeviceMode::kStarting, "connects to the robot at " + options_.robot_ip};
    settled_speed_ += (speed() - settled_speed_) * std::clamp(dt / kSettling, 0.0, 1.0);
    update_remote_control();
    update_order();
    DeviceState state = measured();
    Condition condition = this->condition();
    state.mode = condition.mode;
    state.text = std::move(condition.text);
    // The driver would say so, too, but not of which robot.
    if (state.mode == DeviceMode::kReady && state.age > options_.command_timeout) {
      state.mode = DeviceMode::kFailed;
      state.text = "the newest data of the robot at " + options_.robot_ip + " are " + milliseconds(state.age) +
                   " old (limit " + milliseconds(options_.command_timeout) +
                   ", timing.command_timeout): is its cable out, or is its controller off?";
    }
    return state;
  }

  // A set-point that the socket does not take at once is out of date: the next one follows in a period.
  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) override {
    if (program_.phase != Program::Phase::kRunning || !reverse_.has_sent_all()) return {};
    reverse_.send(set_point_packet(set_point, std::max(options_.timeout, valid_for), valid_for));
    return {};
  }

  void stop(std::string_view /*reason*/) override {
    brakes_.cancel();
    close_program();
  }
  void deactivate() override { close_program(); }

  DeviceResult begin(DeviceOrder order) override {
    if (order_.runs) return DeviceFailure{"another order to its robot is not finished: wait some seconds"};
    if (!rtde_.data()) return DeviceFailure{"its robot at " + options_.robot_ip + " is not connected"};
    if (!dashboard_.is_open() && dashboard_.has_greeted()) {
      return DeviceFailure{
          "the connection to its robot's dashboard server (port 29999) was lost and is being opened "
          "again: call again in some seconds, or act at the teach pendant"};
    }
    if (!dashboard_.is_open()) {
      return DeviceFailure{"its robot has no dashboard server (port 29999): act at the teach pendant"};
    }
    return begin_connected(order);
  }

  std::optional<OrderEnd> order_end() override { return std::exchange(order_.end, std::nullopt); }

  // What the controller reports, also for outputs: a program or a person at the pendant may have set them.
  [[nodiscard]] std::optional<double> signal(std::size_t index) const override {
    if (!rtde_.data() || index >= ports_.size()) return std::nullopt;
    const RobotData& data = *rtde_.data();
    const IoPort& port = ports_[index];
    const auto pin = static_cast<std::size_t>(port.pin);
    switch (port.bank) {
      case IoBank::kAnalogInput:
        return data.analog_inputs[pin];
      case IoBank::kToolAnalogInput:
        return data.tool_analog_inputs[pin];
      case IoBank::kAnalogOutput:
        return data.analog_outputs[pin];
      default:
        break;
    }
    const auto& bits = kind_of(port.bank) == SignalKind::kDigitalInput ? data.digital_inputs : data.digital_outputs;
    if (!bits) return std::nullopt;
    return (*bits >> static_cast<unsigned>(bit_of(port)) & 1U) != 0 ? 1.0 : 0.0;
  }
  DeviceResult set_signal(std::size_t index, double value) override { return rtde_.set_output(ports_[index], value); }

  [[nodiscard]] double tracking_delay() const override {
    return std::min(kLongestDelay, options_.tracking_delay / std::max(kSlowest, settled_speed_));
  }

 private:
  struct Program {
    enum class Phase {
      kNone,     ///< no program of ours runs, or it ends
      kSending,  ///< waits for the primary port, and asks whether the robot is in remote control
      kAwaited,  ///< sent; it shall connect
      kRunning,  ///< connected
      kLost,     ///< it has closed its connection
    };
    Phase phase = Phase::kNone;
    Clock::time_point since;                       ///< of kSending, kAwaited and kRunning together, and of kLost
    std::optional<Clock::time_point> plays_since;  ///< a program plays while the phase is kNone
    bool has_played = false;                       ///< since it was sent
  };
  struct RemoteControl {
    bool off = false;  ///< an e-Series says that it is in local control; a CB3 has no such state
    bool answered = false;
    Clock::time_point ask_at;
  };
  struct Order {
    bool runs = false;
    std::string command, expected;  ///< the dashboard's command, and the beginning of its answer
    std::optional<OrderEnd> end;
  };

  void connect_primary() {
    primary_.connect(options_.robot_ip, kPrimaryPort);
    primary_since_ = now_;
    primary_broken_ = {};
  }

  void update_primary() {
    primary_.update();
    std::string& bytes = primary_.received();
    while (primary_broken_.empty()) {
      const PrimaryPackage next = next_primary_package(bytes);
      primary_broken_ = next.broken;
      if (next.kinematics) take_calibration(*next.kinematics);
      if (next.size == 0) break;
      bytes.erase(0, next.size);
    }
    if (!primary_broken_.empty()) bytes.clear();
    const bool awaited = description_ && !flange_difference_ && primary_.is_open() && primary_broken_.empty();
    if (!awaited || now_ - primary_since_ < kCalibrationLimit) return;
    tell_calibration("the robot has sent none within 3 s: it is not compared with the description");
  }

  void take_calibration(const DhParameters& robot) {
    if (!description_) return;
    flange_difference_ = flange_difference(robot, *description_);
    if (!flange_difference_) {
      description_ = nullptr;
      return tell_calibration("it cannot be compared with a description whose joints follow others");
    }
    const std::string difference = millimetres(*flange_difference_);
    const double lengths = length_difference(robot, *description_, kOtherRobot).value_or(0.0);
    std::string wrong = "the flange is up to " + difference + " from where the planner expects it";
    if (*flange_difference_ <= kSameCalibration) {
      if (lengths <= kSameCalibration) {
        return tell_calibration("the description has it: the flange differs by " + difference);
      }
      wrong = "the height of the shoulder, or the length from the wrist to tool0, differs by " + millimetres(lengths);
    }
    tell_calibration("the description does not have it: " + wrong +
                     "; extract this robot's calibration, for example with the ROS package ur_calibration, and give it "
                     "to the urdf of arm " +
                     arm_);
  }

  // A connection that is opened again brings no news.
  void tell_calibration(const std::string& text) {
    if (std::exchange(told_calibration_, text) == text || !log_) return;
    log_("robot calibration", text);
  }

  void close_program() {
    if (reverse_.is_open()) reverse_.send(end_packet());
    reverse_.close();
    program_ = {};
  }

  void update_program() {
    reverse_.update();
    reverse_.received().clear();
    auto connected = listener_.accept(options_.robot_ip);
    switch (program_.phase) {
      case Program::Phase::kSending:
        if (primary_.is_open() && rtde_.data() && may_be_sent()) send_program();
        break;
      case Program::Phase::kAwaited:
        if (rtde_.data() && plays()) program_.has_played = true;
        if (!connected) break;
        has_connected_ = true;
        reverse_.adopt(std::move(*connected));
        program_.phase = Program::Phase::kRunning;
        if (log_) log_("robot program runs", options_.robot_ip);
        break;
      case Program::Phase::kRunning:
        if (reverse_.is_open()) break;
        program_.phase = Program::Phase::kLost;
        program_.since = now_;
        break;
      case Program::Phase::kNone:
        if (!rtde_.data() || !plays()) {
          program_.plays_since.reset();
        } else if (!program_.plays_since) {
          program_.plays_since = now_;
        }
        break;
      case Program::Phase::kLost:
        break;
    }
  }

  [[nodiscard]] bool may_be_sent() const {
    const bool remote = !dashboard_.has_greeted() || (remote_control_.answered && !remote_control_.off);
    return remote && condition_of_calibration().mode == DeviceMode::kReady;
  }

  void send_program() {
    ProgramSetup setup;
    setup.address = options_.pc_ip.value_or(rtde_.own_address());
    setup.port = options_.reverse_port;
    setup.lookahead_time = options_.lookahead_time;
    setup.gain = options_.gain;
    setup.velocity = limits_.velocity;
    setup.acceleration = limits_.acceleration;
    primary_.send(program_text(setup));
    program_.phase = Program::Phase::kAwaited;
  }

  [[nodiscard]] double speed() const {
    const auto& data = rtde_.data();
    return data ? std::clamp(data->speed_scaling * data->target_speed_fraction, 0.0, 1.0) : 1.0;
  }

  [[nodiscard]] DeviceState measured() const {
    const RobotData& data = *rtde_.data();
    DeviceState state;
    state.measured.q = Eigen::Map<const Eigen::Vector<double, kJoints>>(data.q.data());
    state.measured.qd = Eigen::Map<const Eigen::Vector<double, kJoints>>(data.qd.data());
    state.age = std::max(Clock::duration::zero(), now_ - rtde_.measured_at());
    state.speed_scaling = speed();
    return state;
  }

  [[nodiscard]] bool plays() const {
    const auto state = static_cast<RuntimeState>(rtde_.data()->runtime_state);
    return state == RuntimeState::kPlaying || state == RuntimeState::kResuming;
  }

  // Why the arm cannot be moved: its safety and robot, then remote control, then the program.
  [[nodiscard]] Condition condition() const {
    Condition robot = condition_of(*rtde_.data(), arm_);
    if (robot.mode != DeviceMode::kReady) return robot;
    Condition other = condition_of_model();
    if (other.mode != DeviceMode::kReady) return other;
    Condition calibration = condition_of_calibration();
    if (calibration.mode != DeviceMode::kReady) return calibration;
    const std::string resume = "'hecaton resume " + arm_ + "'";
    if (remote_control_.off && program_.phase != Program::Phase::kRunning) {
      return {DeviceMode::kRemoteControlOff,
              "the robot is in local control: switch it to remote control at the teach pendant, then call " + resume};
    }
    switch (program_.phase) {
      case Program::Phase::kNone:
        if (!plays()) return {};
        if (now_ - program_.plays_since.value_or(now_) < longest_end_) {
          return {DeviceMode::kStarting, "waits for the end of a program"};
        }
        return {DeviceMode::kNotReady,
                "another program runs on the robot: stop it at the teach pendant, then call " + resume};
      case Program::Phase::kSending:
      case Program::Phase::kAwaited:
        if (now_ - program_.since < kProgramStart) return {DeviceMode::kStarting, "starts the program on the robot"};
        return {DeviceMode::kFailed, missing_program()};
      case Program::Phase::kRunning:
        if (plays() || now_ - program_.since < kProgramStart) return paused();
        return stopped(resume);
      case Program::Phase::kLost:
        if (now_ - program_.since < kExplanation) return {};
        return stopped(resume);
    }
    return {};
  }

  // Its description decides where the planner expects the arm. The model is known before the first program is sent.
  [[nodiscard]] Condition condition_of_model() const {
    const FoundRobot found{model_, rtde_.major_version()};
    if (options_.model && !found.may_be(*options_.model)) {
      return {DeviceMode::kNotReady, "the controller says that its robot is a " + found.name() +
                                         ", but the cell file describes a " + *options_.model +
                                         ": connect that robot, or correct robot or urdf of arm " + arm_ +
                                         ", or the key model of its device if only the name there is wrong"};
    }
    const auto limit = dashboard_.has_greeted() ? kModelLimit : kDashboardLimit;
    const bool awaited = !model_answered_ && now_ - configured_at_ < limit;
    if (!awaited || program_.phase != Program::Phase::kNone) return {};
    return {DeviceMode::kStarting, "asks the robot for its model"};
  }

  // A robot sends its calibration before the first program is sent to it, if at all.
  [[nodiscard]] Condition condition_of_calibration() const {
    if (flange_difference_.value_or(0.0) > kOtherRobot) {
      return {DeviceMode::kNotReady, "by the kinematics that the robot reports, its flange is up to " +
                                         millimetres(*flange_difference_) +
                                         " from where the cell file expects it (limit " + millimetres(kOtherRobot) +
                                         "): correct robot or urdf of arm " + arm_ +
                                         "; it must be of this type of robot, with its calibration"};
    }
    const bool begins = program_.phase == Program::Phase::kNone || program_.phase == Program::Phase::kSending;
    if (!description_ || flange_difference_ || !begins) return {};
    if (!primary_broken_.empty()) {
      return {DeviceMode::kFailed, "the robot at " + options_.robot_ip + " sends " + std::string(primary_broken_) +
                                       " on port 30001: restart its controller, and update its software"};
    }
    if (primary_.state() == TcpConnection::State::kClosed || now_ - primary_since_ >= kCalibrationLimit) return {};
    return {DeviceMode::kStarting, "waits for the calibration of the robot"};
  }

  [[nodiscard]] Condition paused() const {
    const auto state = static_cast<RuntimeState>(rtde_.data()->runtime_state);
    if (state != RuntimeState::kPausing && state != RuntimeState::kPaused) return {};
    return {
        DeviceMode::kProgramStopped,
        "the program on the robot is paused: stop it at the teach pendant, then call 'hecaton resume " + arm_ + "'"};
  }

  [[nodiscard]] Condition stopped(const std::string& resume) const {
    Condition pause = paused();
    if (pause.mode != DeviceMode::kReady) return pause;
    return {DeviceMode::kProgramStopped,
            "the program on the robot has stopped, by a person or because set-points ceased for " +
                std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(options_.timeout).count()) +
                " ms: look at the arm, then call " + resume};
  }

  [[nodiscard]] std::string missing_program() const {
    const std::string robot = "the robot at " + options_.robot_ip;
    if (program_.phase == Program::Phase::kSending) {
      return primary_.is_open() ? robot + " does not answer on its dashboard server (port 29999)"
                                : robot + " takes no program on port 30001: " + primary_.error();
    }
    if (plays() || program_.has_played) {
      return robot + " runs the program, but it does not connect to " + options_.pc_ip.value_or(rtde_.own_address()) +
             ", port " + std::to_string(options_.reverse_port) +
             (has_connected_
                  ? ": after a cut a robot may keep the old connection for some time; wait a minute, then call "
                    "'hecaton resume " +
                        arm_ + "'"
                  : ": allow this port in the firewall of this machine, or set pc_ip");
    }
    return robot + " has not started the program: is it in remote control?";
  }

  void update_remote_control() {
    // A lost connection says nothing about remote control.
    const bool polls = dashboard_.is_open() && program_.phase != Program::Phase::kRunning;
    if (!polls || now_ < remote_control_.ask_at || !dashboard_.is_idle()) return;
    dashboard_.send("is in remote control", now_);
    if (model_.empty()) dashboard_.send(std::string(kAskModel), now_);
    remote_control_.ask_at = now_ + kRemoteControlPeriod;
  }

  DeviceResult begin_connected(DeviceOrder order) {
    const auto robot = static_cast<RobotMode>(rtde_.data()->robot_mode);
    const auto safety = static_cast<SafetyMode>(rtde_.data()->safety_mode);
    switch (order) {
      case DeviceOrder::kPowerOn:
        if (robot == RobotMode::kRunning) return DeviceFailure{"its robot is on already"};
        if (robot == RobotMode::kIdle) {
          send_order("brake release", "Brake releasing");
        } else {
          send_order("power on", "Powering on");
          brakes_.begin(now_);
        }
        return {};
      case DeviceOrder::kPowerOff:
        if (robot == RobotMode::kPowerOff) return DeviceFailure{"its robot is off already"};
        send_order("power off", "Powering off");
        return {};
      case DeviceOrder::kUnlock:
        if (safety != SafetyMode::kProtectiveStop) return DeviceFailure{"its robot is in no protective stop"};
        send_order("unlock protective stop", "Protective stop releasing");
        return {};
    }
    return {};
  }

  void send_order(const std::string& command, const std::string& expected) {
    order_ = {true, command, expected, {}};
    brakes_.cancel();
    dashboard_.send(command, now_);
  }

  void update_order() {
    while (const auto answer = dashboard_.take()) {
      if (answer->command == "is in remote control") {
        remote_control_.off = answer->text == "false";
        remote_control_.answered = true;
      } else if (answer->command == kAskModel) {
        take_model(answer->text);
      } else if (order_.runs && answer->command == order_.command) {
        const bool taken = answer->text.starts_with(order_.expected);
        if (!taken) brakes_.cancel();
        end_order(taken ? DeviceResult{} : DeviceFailure{"the robot answers: " + readable(answer->text)});
      }
    }
    if (order_.runs && !dashboard_.is_open()) {
      brakes_.cancel();
      end_order(DeviceFailure{"the robot does not answer on its dashboard server (port 29999)"});
    }
    if (!brakes_.due(*rtde_.data(), now_) || order_.runs || !dashboard_.is_open()) return;
    dashboard_.send("brake release", now_);
    brakes_.cancel();
  }

  // Old controllers do not know the command.
  void take_model(const std::string& answer) {
    model_answered_ = true;
    if (!answer.starts_with("UR")) return;
    model_ = readable(answer);
    const std::string name = FoundRobot{model_, rtde_.major_version()}.name();
    if (log_) log_("robot model", options_.model ? name : name + "; the cell file does not say which it should be");
  }

  void end_order(DeviceResult result) {
    order_.runs = false;
    order_.end = OrderEnd{std::move(result)};
  }

  std::string arm_;
  JointLimits limits_;
  Clock::duration longest_end_;  ///< of a program that the driver has ended
  Options options_;
  std::vector<IoPort> ports_;                               ///< of the signals
  std::shared_ptr<const planner::RobotModel> description_;  ///< null: nothing is compared with it
  RtdeClient rtde_;
  DeviceLog log_;
  TcpConnection primary_;
  Clock::time_point primary_since_;          ///< when it was connected
  std::string_view primary_broken_;          ///< what it has sent instead of states; the rest is not read
  std::optional<double> flange_difference_;  ///< between robot and description [m]; empty: not known
  std::string told_calibration_;
  Dashboard dashboard_;
  TcpListener listener_;
  TcpConnection reverse_;
  Program program_;
  bool has_connected_ = false;  ///< this or an earlier program
  RemoteControl remote_control_;
  std::string model_;  ///< as the dashboard names it; empty: not known
  bool model_answered_ = false;
  Clock::time_point configured_at_;
  Order order_;
  BrakeRelease brakes_;
  double settled_speed_ = 1.0;  ///< speed scaling to which the lag has settled
  Clock::time_point now_;
};

/// A calibration moves and turns the joint frames by a little; a nominal description turns them by multiples of 90°.
/// The frame of the first joint has also the mount of the robot, which may be tilted.
bool is_calibrated(const planner::RobotModel& model) {
  constexpr double kTurned = 2e-5;  // [rad]; descriptions round 90° to 1.5708
  for (const planner::Link& link : model.links) {
    if (link.joint < 1) continue;
    const Eigen::Matrix3d R = link.X_PJ.linear();
    for (const double entry : R.reshaped()) {
      if (std::abs(entry) > kTurned && std::abs(std::abs(entry) - 1.0) > kTurned) return true;
    }
  }
  return false;
}

}  // namespace

std::optional<SignalKind> universal_robots_signal(std::string_view port) {
  const auto parsed = parse_port(port);
  return parsed ? std::optional(kind_of(parsed->bank)) : std::nullopt;
}

std::unique_ptr<ArmDevice> make_universal_robots_arm(const DeviceSetup& setup) {
  return std::make_unique<UniversalRobotsArm>(setup, read_options(setup));
}

std::vector<ListeningPort> universal_robots_ports(const DeviceSetup& setup) {
  return {{read_options(setup).reverse_port, "reverse_port"}};
}

std::vector<Claim> universal_robots_claims(const DeviceSetup& setup) {
  return {{"the robot at " + read_options(setup).robot_ip, "robot_ip"}};
}

std::vector<std::string> universal_robots_notes(const DeviceSetup& setup, const planner::RobotModel& model) {
  std::vector<std::string> notes;
  if (!is_calibrated(model)) {
    notes.push_back("arm " + setup.arm +
                    ": its description has the nominal kinematics of its type, without the calibration of this robot; "
                    "the tool may be some millimetres from where the planner expects it");
  }
  if (!read_options(setup).model) {
    notes.push_back("arm " + setup.arm +
                    ": its description does not name a model of Universal Robots, so that a wrong robot is not found; "
                    "the key model of its device names it");
  }
  notes.push_back("arm " + setup.arm + ": its robot connects to port " +
                  std::to_string(read_options(setup).reverse_port) + " of its host; the firewall must allow it");
  return notes;
}

}  // namespace hecaton::device
