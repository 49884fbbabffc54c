#include "services/arm_driver/devices/abb_egm/robot_stream.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace hecaton::device::abb_egm {
namespace {

/// The controller measures in multiples of this.
constexpr double kControllerPeriod = 0.004;  // [s]
/// Over a longer gap there is no velocity.
constexpr double kLongestStep = 0.1;  // [s]
/// No joint moves faster, and a measurement may be wrong by as much [rad/s | m/s], [rad | m].
constexpr double kFastest = 20.0;
constexpr double kTolerance = 0.01;
constexpr double kAtZero = 0.01;  // of an additional axis [° | mm]
/// In one period of the driver: more than wait in a socket.
constexpr int kMostMessages = 512;

// Controllers report an undefined RAPID state after a restart, also while the program runs.
bool guides(const RobotMessage& message) {
  return message.motors == MotorState::kOn && message.rapid != RapidState::kStopped &&
         message.guidance == GuidanceState::kRunning;
}

}  // namespace

RobotStream::RobotStream(Options options, Eigen::Index joints, const std::vector<bool>& prismatic, DeviceLog log)
    : options_(std::move(options)),
      scale_(JointVector::Constant(joints, 180.0 / std::numbers::pi)),
      log_(std::move(log)),
      robot_(options_.robot_ip) {
  for (std::size_t joint = 0; joint < prismatic.size(); ++joint) {
    if (prismatic[joint]) scale_[static_cast<Eigen::Index>(joint)] = 1000.0;  // mm
  }
}

DeviceResult RobotStream::open() {
  last_.reset();
  measured_ = {};
  awaits_answer_ = guided_ = false;
  unreadable_ = 0;
  opened_at_ = answered_at_ = Clock::now();
  const auto failure = channel_.open(options_.port);
  if (!failure) return {};
  return DeviceFailure{"cannot listen on UDP port " + std::to_string(options_.port) + " of this machine: " + *failure +
                       "; does another program use it? Set port in the cell file"};
}

void RobotStream::receive(Clock::time_point now) {
  guided_ = last_ && guides(*last_);
  for (int taken = 0; taken < kMostMessages; ++taken) {
    const auto datagram = channel_.receive(robot_);
    if (!datagram) return;
    const auto message = decode(*datagram);
    if (!message) {
      if (unreadable_++ == 0 && log_) log_("unreadable datagram", channel_.sender());
    } else if (is_next(*message)) {
      take(*message, now);
    }
  }
}

// The number orders messages; after a restart of the program it begins anew, and the controller's clock goes on.
bool RobotStream::is_next(const RobotMessage& message) const {
  if (!last_) return true;
  const auto ahead = static_cast<std::int32_t>(message.sequence_number - last_->sequence_number);
  const auto later = static_cast<std::int32_t>(message.sent_ms - last_->sent_ms);
  return ahead > 0 || later > 0;
}

void RobotStream::take(const RobotMessage& message, Clock::time_point now) {
  JointState measured;
  measured.q = positions(message);
  measured.qd = JointVector::Zero(measured.q.size());
  if (last_ && measured_.q.size() == measured.q.size() && measured.q.size() > 0) {
    const JointVector moved = measured.q - measured_.q;
    const double since = std::chrono::duration<double>(now - received_at_).count();
    const double dt = seconds_since_last(message);
    if (moved.cwiseAbs().maxCoeff() > kFastest * std::max(since, kControllerPeriod) + kTolerance) return;
    if (dt <= kLongestStep) measured.qd = moved / dt;
  }
  if (!std::exchange(was_heard_, true) && log_) log_("robot connected", channel_.sender());
  if (!robot_) robot_ = channel_.sender();
  const bool program_restarted = last_ && message.sequence_number < last_->sequence_number;
  guided_ = guides(message) && (!last_ || (guided_ && !program_restarted));
  channel_.answer_to_sender();
  last_ = message;
  received_at_ = now;
  measured_ = std::move(measured);
  awaits_answer_ = true;
}

JointVector RobotStream::positions(const RobotMessage& message) const {
  const auto joints = message.joints.get();
  const auto external = message.external.get();
  if (joints.size() != kMostJoints || (options_.external_axis && external.empty()) || unknown_axis(message)) return {};
  JointVector q(scale_.size());
  std::size_t next = 0;
  for (Eigen::Index joint = 0; joint < q.size(); ++joint) {
    const double value = joint == options_.external_axis ? external.front() : joints[next++];
    q[joint] = value / scale_[joint];
  }
  return q;
}

std::optional<double> RobotStream::unknown_axis(const RobotMessage& message) const {
  const auto external = message.external.get();
  const auto moved = std::find_if(external.begin() + (options_.external_axis && !external.empty() ? 1 : 0),
                                  external.end(), [](double position) { return std::abs(position) > kAtZero; });
  return moved == external.end() ? std::nullopt : std::optional(*moved);
}

double RobotStream::seconds_since_last(const RobotMessage& message) const {
  double seconds = 1e-3 * static_cast<std::int32_t>(message.sent_ms - last_->sent_ms);
  if (message.clock_us && last_->clock_us) {
    seconds = 1e-6 * static_cast<double>(static_cast<std::int64_t>(*message.clock_us - *last_->clock_us));
  }
  return kControllerPeriod * std::max(1.0, std::round(seconds / kControllerPeriod));
}

// The answer has the number of what it answers: so the numbers go on also when the driver restarts.
void RobotStream::answer(const JointVector& q) {
  if (!std::exchange(awaits_answer_, false)) return;
  answered_at_ = received_at_;
  SensorMessage message;
  message.sequence_number = last_->sequence_number;
  message.sent_ms = static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(received_at_ - opened_at_).count());
  for (Eigen::Index joint = 0; joint < q.size(); ++joint) {
    JointValues& values = joint == options_.external_axis ? message.external : message.joints;
    (void)values.add(q[joint] * scale_[joint]);
  }
  SensorBuffer buffer;
  channel_.answer(encode(message, buffer));
}

std::string RobotStream::what_arrives() const {
  if (unreadable_ > 0) return "; " + std::to_string(unreadable_) + " datagrams could not be read";
  if (!channel_.dropped_sender().empty()) return "; datagrams of " + channel_.dropped_sender() + " are ignored";
  return {};
}

}  // namespace hecaton::device::abb_egm
