#include "services/arm_driver/devices/program/program_arm.hpp"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <random>
#include <utility>

#include <idl/device.h>

#include "services/arm_driver/devices/duration_text.hpp"
#include "services/arm_driver/devices/largest_step.hpp"
#include "services/bus/endpoint.hpp"
#include "services/bus/participant.hpp"

namespace hecaton::device {
namespace {

using Seconds = std::chrono::duration<double>;

/// Programs on a network find each other within this time.
constexpr std::chrono::seconds kDiscovery{5};
constexpr double kLongestDelay = 1.0;  // [s]

DeviceMode mode_of(msg::DeviceMode mode) {
  switch (mode) {
    case msg::DeviceMode::DEVICE_READY:
      return DeviceMode::kReady;
    case msg::DeviceMode::DEVICE_STARTING:
      return DeviceMode::kStarting;
    case msg::DeviceMode::DEVICE_NOT_READY:
      return DeviceMode::kNotReady;
    case msg::DeviceMode::DEVICE_REMOTE_CONTROL_OFF:
      return DeviceMode::kRemoteControlOff;
    case msg::DeviceMode::DEVICE_PROGRAM_STOPPED:
      return DeviceMode::kProgramStopped;
    case msg::DeviceMode::DEVICE_SAFEGUARD_STOP:
      return DeviceMode::kSafeguardStop;
    case msg::DeviceMode::DEVICE_PROTECTIVE_STOP:
      return DeviceMode::kProtectiveStop;
    case msg::DeviceMode::DEVICE_EMERGENCY_STOP:
      return DeviceMode::kEmergencyStop;
    case msg::DeviceMode::DEVICE_FAILED:
      return DeviceMode::kFailed;
  }
  return DeviceMode::kFailed;
}

/// The topics of one arm. For one thread.
class Link {
 public:
  Link(std::unique_ptr<bus::Participant> participant, const std::string& arm)
      : participant_(std::move(participant)),
        commands_(*participant_, {.key = arm}),
        states_(*participant_, &mailbox_, {.deadline = std::chrono::milliseconds(0), .keys = {arm}}) {}

  void send(const msg::DeviceCommand& command) { (void)commands_.write(command); }
  /// The newest state; null: none has arrived.
  [[nodiscard]] const bus::Sample<msg::DeviceState>* newest(const std::string& arm) { return states_.latest(arm); }

 private:
  bus::Mailbox mailbox_;
  std::unique_ptr<bus::Participant> participant_;
  bus::Writer<msg::DeviceCommand> commands_;
  bus::Reader<msg::DeviceState> states_;
};

class ProgramArm final : public ArmDevice {
 public:
  explicit ProgramArm(const DeviceSetup& setup)
      : limits_(setup.limits), period_(setup.period), silence_limit_(setup.command_timeout), join_(setup.join) {
    command_.arm(setup.arm);
    command_.session(std::random_device{}());
  }

  DeviceResult configure() override {
    now_ = opened_at_ = Clock::now();
    rest(msg::DeviceTask::DEVICE_MEASURE, {});
    try {
      if (!link_) link_.emplace(join_(), arm());
    } catch (const std::exception& error) {
      return DeviceFailure{std::string("cannot join the cell's topics of its program: ") + error.what()};
    }
    return {};
  }

  DeviceResult activate() override {
    command_.session(command_.session() + 1);
    command_.reason({});
    follows_ = true;
    acted_on_ = command_.sequence_number();
    set_point_ = measured_.q;
    set_point_at_ = taken_at_ = now_;
    return {};
  }

  DeviceState read(Clock::time_point now) override {
    now_ = now;
    // A set-point of write() is the command of its period.
    if (!follows_) send();
    const bus::Sample<msg::DeviceState>* sample = link_->newest(arm());
    if (sample == nullptr || sample->received < opened_at_ - silence_limit_) return absent();
    was_heard_ = true;
    const msg::DeviceState& state = sample->value;
    const auto joints = static_cast<std::size_t>(limits_.lower.size());
    if (state.q().size() != joints || state.qd().size() != joints) return incomplete(state);
    const auto vector = [](const std::vector<double>& values) {
      return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    };
    measured_ = {vector(state.q()), vector(state.qd())};
    const Clock::duration age =
        std::max(Clock::duration::zero(), now - sample->received) +
        std::chrono::duration_cast<Clock::duration>(Seconds(std::clamp(state.age(), 0.0, kLongestDelay)));
    if (age >= silence_limit_) return failed("its program is silent for " + milliseconds(silence_limit_) + silent());
    tracking_delay_ = std::clamp(state.tracking_delay(), 0.0, kLongestDelay);
    if (follows_ && state.session() == command_.session() && state.sequence_number() > acted_on_) {
      acted_on_ = state.sequence_number();
      taken_at_ = now;
    }
    if (follows_ && sample->received - taken_at_ >= silence_limit_) {
      return failed("its program reports states, but has acted on no command for " + milliseconds(silence_limit_) +
                    ": end it, start it again, then call " + resume());
    }
    return {measured_, age, state.speed_scaling(), mode_of(state.mode()), reason_of(state)};
  }

  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) override {
    if (!follows_) return {};
    if (auto why = jump(limits_.velocity, set_point_, set_point.q, now_ - set_point_at_ + period_)) {
      return DeviceFailure{std::move(*why)};
    }
    set_point_ = set_point.q;
    set_point_at_ = now_;
    command_.task(msg::DeviceTask::DEVICE_FOLLOW);
    command_.valid_for(Seconds(valid_for).count());
    command_.q().assign(set_point.q.begin(), set_point.q.end());
    command_.qd().assign(set_point.qd.begin(), set_point.qd.end());
    send();
    return {};
  }

  // It is sent again in each period until the device is activated again.
  void stop(std::string_view reason) override {
    rest(msg::DeviceTask::DEVICE_STOP, reason);
    if (link_) send();
  }
  void deactivate() override {
    if (follows_) rest(msg::DeviceTask::DEVICE_STOP, "the driver no longer commands the arm");
  }

  [[nodiscard]] double tracking_delay() const override { return tracking_delay_; }

 private:
  void rest(msg::DeviceTask task, std::string_view reason) {
    follows_ = false;
    command_.task(task);
    command_.valid_for(0.0);
    command_.q().clear();
    command_.qd().clear();
    command_.reason(std::string(reason));
  }

  void send() {
    command_.sequence_number(command_.sequence_number() + 1);
    link_->send(command_);
  }

  [[nodiscard]] const std::string& arm() const { return command_.arm(); }
  [[nodiscard]] std::string resume() const { return "'hecaton resume " + arm() + "'"; }
  [[nodiscard]] std::string silent() const {
    return ": look whether it runs, and at its machine and the network, then call " + resume();
  }
  [[nodiscard]] static DeviceState failed(std::string text) {
    return {{}, {}, 1.0, DeviceMode::kFailed, std::move(text)};
  }

  [[nodiscard]] static std::string reason_of(const msg::DeviceState& state) {
    if (state.mode() == msg::DeviceMode::DEVICE_READY || !state.text().empty()) return state.text();
    return "its program gives no reason";
  }

  [[nodiscard]] DeviceState absent() const {
    // A lost program stays lost until it reports again. One that was never heard may not have been started yet.
    if (was_heard_ || now_ - opened_at_ < kDiscovery) {
      return {{}, {}, 1.0, DeviceMode::kStarting, "waits for its program"};
    }
    return {{},
            {},
            1.0,
            DeviceMode::kNotReady,
            "no program writes hecaton/DeviceState for it: start its program, then call " + resume()};
  }

  [[nodiscard]] DeviceState incomplete(const msg::DeviceState& state) const {
    if (state.q().empty() && state.mode() != msg::DeviceMode::DEVICE_READY) {
      return {{}, {}, 1.0, mode_of(state.mode()), reason_of(state)};
    }
    return failed("its program reports " + std::to_string(state.q().size()) + " positions and " +
                  std::to_string(state.qd().size()) + " velocities; the arm has " +
                  std::to_string(limits_.lower.size()) + " joints");
  }

  JointLimits limits_;
  Clock::duration period_;
  Clock::duration silence_limit_;
  JoinCell join_;
  std::optional<Link> link_;    ///< from the first configure() on
  msg::DeviceCommand command_;  ///< the last one
  bool follows_ = false;        ///< active
  bool was_heard_ = false;      ///< since the object began
  JointState measured_;
  double tracking_delay_ = 0.0;
  JointVector set_point_;  ///< the last one, or measured when the driver activated the device
  Clock::time_point set_point_at_;
  std::uint64_t acted_on_ = 0;  ///< number of the newest command that the program acted on since then
  Clock::time_point taken_at_;  ///< when it reported this one, or when the driver activated the device
  Clock::time_point now_, opened_at_;
};

}  // namespace

std::unique_ptr<ArmDevice> make_program_arm(const DeviceSetup& setup) {
  return std::make_unique<ProgramArm>(setup);
}

std::vector<std::string> program_notes(const DeviceSetup& setup, const planner::RobotModel& /*model*/) {
  return {"arm " + setup.arm + ": its program must brake it when commands cease; 'hecaton device-test CELL " +
          setup.arm + "' tests that"};
}

}  // namespace hecaton::device
