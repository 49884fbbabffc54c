#include "services/arm_driver/devices/abb_egm/abb_egm_arm.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>

#include "services/arm_driver/devices/abb_egm/options.hpp"
#include "services/arm_driver/devices/abb_egm/robot_stream.hpp"
#include "services/arm_driver/devices/largest_step.hpp"

namespace hecaton::device {
namespace abb_egm {
namespace {

/// A robot whose program runs reports within this time, and begins to follow within it.
constexpr std::chrono::seconds kStart{2};
/// Each message of the robot has an answer, a period later. A longer pause explains why EGM has ended.
constexpr std::chrono::milliseconds kUnanswered{200};
struct Condition {
  DeviceMode mode = DeviceMode::kReady;
  std::string text;
};

class AbbEgmArm final : public ArmDevice {
 public:
  AbbEgmArm(const DeviceSetup& setup, const Options& options)
      : arm_(setup.arm),
        velocity_(setup.limits.velocity),
        period_(setup.period),
        silence_limit_(setup.command_timeout),
        options_(options),
        stream_(options, setup.limits.lower.size(), setup.prismatic, setup.log) {}

  DeviceResult configure() override {
    now_ = opened_at_ = Clock::now();
    end_following();
    stands_at_.reset();
    ended_since_.reset();
    return stream_.open();
  }

  DeviceResult activate() override {
    follows_ = true;
    set_point_ = stream_.measured().q;
    sent_at_ = now_;
    return {};
  }

  DeviceState read(Clock::time_point now) override {
    now_ = now;
    stream_.receive(now);
    if (!stream_.last()) {
      Condition condition = absent();
      return {{}, {}, 1.0, condition.mode, std::move(condition.text)};
    }
    if (auto why = unusable()) return {{}, {}, 1.0, DeviceMode::kFailed, std::move(*why)};
    update_guidance();
    if (!follows_) hold();
    Condition condition = this->condition();
    return {stream_.measured(), std::max(Clock::duration::zero(), now_ - stream_.received_at()), 1.0, condition.mode,
            std::move(condition.text)};
  }

  // A set-point is a position without a velocity: when set-points cease, the arm ends at the last one.
  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds /*valid_for*/) override {
    if (!follows_ || !stream_.awaits_answer()) return {};
    if (auto why = jump(velocity_, set_point_, set_point.q, now_ - sent_at_ + period_)) {
      return DeviceFailure{std::move(*why)};
    }
    stream_.answer(set_point.q);
    set_point_ = set_point.q;
    sent_at_ = now_;
    return {};
  }

  void stop(std::string_view /*reason*/) override { end_following(); }
  void deactivate() override { end_following(); }

  [[nodiscard]] double tracking_delay() const override { return options_.tracking_delay; }

 private:
  // The arm stays at the last set-point.
  void end_following() {
    if (std::exchange(follows_, false) && stream_.guided()) stands_at_ = set_point_;
  }

  void update_guidance() {
    if (stream_.guided()) {
      ended_since_.reset();
      converged_ = stream_.last()->converged;
      return;
    }
    stands_at_.reset();
    if (ended_since_) return;
    ended_since_ = now_;
    unanswered_ = now_ - stream_.answered_at() > kUnanswered;
  }

  // The controller ends EGM when nothing answers. While the driver does not follow set-points, the answer is the place
  // where the arm stands. It is fixed as long as EGM guides the arm: repeating measurements would let the arm drift.
  void hold() {
    if (stream_.guided() && !stands_at_) stands_at_ = stream_.measured().q;
    stream_.answer(stands_at_.value_or(stream_.measured().q));
  }

  [[nodiscard]] std::string resume() const { return "'hecaton resume " + arm_ + "'"; }
  [[nodiscard]] std::string the_robot() const {
    return stream_.robot() ? "the robot at " + *stream_.robot() : std::string("the robot");
  }

  // A lost robot stays lost until it reports again. One that has never reported may not have been started yet.
  [[nodiscard]] Condition absent() const {
    const std::string port = "UDP port " + std::to_string(options_.port) + " of this machine";
    if (stream_.was_heard() || now_ - opened_at_ < kStart) {
      return {DeviceMode::kStarting, "waits for " + the_robot() + " on " + port};
    }
    return {DeviceMode::kNotReady,
            the_robot() + " sends no EGM messages to " + port +
                ": start its RAPID program, and check its UDPUC device and the firewall of this machine" +
                stream_.what_arrives()};
  }

  // Why nothing can be done with what the robot reports.
  [[nodiscard]] std::optional<std::string> unusable() const {
    const RobotMessage& message = *stream_.last();
    if (const auto position = stream_.unknown_axis(message)) {
      char place[32];
      std::snprintf(place, sizeof place, "%.2f", *position);
      return the_robot() + " reports an additional axis at " + place + " (degrees or mm), which arm " + arm_ +
             " does not have: describe it in the cell file, or move it to 0 and leave it there";
    }
    if (stream_.measured().q.size() == 0) {
      return the_robot() + " reports " + std::to_string(message.joints.count) + " joints and " +
             std::to_string(message.external.count) + " additional axes, but arm " + arm_ + " needs " +
             (options_.external_axis ? "six joints and an additional axis" : "six joints") +
             ": check the mechanical unit in EGMSetupUC";
    }
    if (!message.clock_us) {
      return the_robot() + " runs RobotWare before 6.07, which mixes degrees and radians: update it to 6.07 or later";
    }
    if (now_ - stream_.received_at() < silence_limit_) return std::nullopt;
    char limit[32];
    std::snprintf(limit, sizeof limit, "%.0f ms", std::chrono::duration<double, std::milli>(silence_limit_).count());
    return the_robot() + " has sent nothing for " + limit +
           ": check the cable, and whether its RAPID program runs, then call " + resume() + stream_.what_arrives();
  }

  // Why the arm cannot be moved: motors, then program, then EGM.
  [[nodiscard]] Condition condition() const {
    const RobotMessage& message = *stream_.last();
    if (message.motors != MotorState::kOn) {
      return {
          DeviceMode::kNotReady,
          "the motors are off, by a person, an emergency stop or a safeguard: look at the arm, switch the motors on "
          "and start the RAPID program, then call " +
              resume()};
    }
    if (message.rapid == RapidState::kStopped && message.guidance != GuidanceState::kError) {
      return {DeviceMode::kProgramStopped,
              "the RAPID program has stopped: read the event log of the controller, start the program, then call " +
                  resume()};
    }
    if (message.guidance == GuidanceState::kError) {
      return {DeviceMode::kProtectiveStop,
              "EGM reports an error, such as a set-point outside its limits: read the event log of the controller, "
              "start the RAPID program, then call " +
                  resume()};
    }
    if (stream_.guided()) return {};
    const bool begins = !follows_ && now_ - ended_since_.value_or(now_) < kStart;
    if (begins) return {DeviceMode::kStarting, "waits until the RAPID program runs EGM"};
    return {DeviceMode::kProgramStopped, "EGM has ended, because " + why_ended() + ": look at the arm, then call " +
                                             resume() + " once the RAPID program runs EGM again"};
  }

  [[nodiscard]] std::string why_ended() const {
    if (unanswered_) return "set-points did not arrive for CommTimeout of EGMSetupUC";
    if (converged_) return "the arm was at its set-point for CondTime of EGMRunJoint, or the RAPID program stopped it";
    return "the RAPID program stopped it";
  }

  std::string arm_;
  JointVector velocity_;  ///< limits
  Clock::duration period_;
  Clock::duration silence_limit_;
  Options options_;
  RobotStream stream_;
  bool follows_ = false;   ///< active
  JointVector set_point_;  ///< sent last, or measured when the driver activated the device
  Clock::time_point sent_at_;
  std::optional<JointVector> stands_at_;          ///< what the robot gets while the device does not follow
  std::optional<Clock::time_point> ended_since_;  ///< EGM does not guide the arm
  bool unanswered_ = false;                       ///< when EGM ended
  bool converged_ = false;                        ///< when EGM guided it last
  Clock::time_point now_, opened_at_;
};

}  // namespace
}  // namespace abb_egm

std::unique_ptr<ArmDevice> make_abb_egm_arm(const DeviceSetup& setup) {
  return std::make_unique<abb_egm::AbbEgmArm>(setup, abb_egm::read_options(setup));
}

std::vector<ListeningPort> abb_egm_ports(const DeviceSetup& setup) {
  return {{abb_egm::read_options(setup).port, "port", true}};
}

std::vector<std::string> abb_egm_notes(const DeviceSetup& setup, const planner::RobotModel& /*model*/) {
  const abb_egm::Options options = abb_egm::read_options(setup);
  std::vector<std::string> notes{"arm " + setup.arm + ": its robot sends to UDP port " + std::to_string(options.port) +
                                 " of its host; the UDPUC device of the robot must name it, and the firewall must "
                                 "allow it"};
  if (!options.robot_ip) {
    notes.push_back("arm " + setup.arm +
                    ": the driver believes the first sender to that port; set robot_ip to believe the robot alone");
  }
  return notes;
}

}  // namespace hecaton::device
