#include "services/arm_driver/devices/ros2_control/joint_states.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/ros2_messages/cdr.hpp"

namespace hecaton::device::ros2_control {
namespace {

/// In a sentence.
constexpr std::size_t kMostNames = 8;
constexpr std::size_t kMostLetters = 40;
/// Other publishers of joint states are slow: joint_state_publisher has a period of 0.1 s.
constexpr std::chrono::seconds kConflictMemory{2};
/// Shorter steps amplify the rounding of positions [s].
constexpr double kShortestStep = 1e-4;

double seconds_of(const ros2::Time& stamp) {
  return static_cast<double>(stamp.sec) + 1e-9 * static_cast<double>(stamp.nanosec);
}

/// Names of the network, for people.
std::string shown(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
    text += text.empty() ? "" : ", ";
    for (const char c : names[i].substr(0, kMostLetters)) text += c > ' ' && c <= '~' ? c : '?';
  }
  return names.size() > kMostNames ? text + ", …" : text;
}

bool has_all_different(std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  return std::adjacent_find(names.begin(), names.end()) == names.end();
}

}  // namespace

JointStates::JointStates(std::vector<std::string> joints, Clock::duration silence_limit)
    : names_(std::move(joints)), silence_limit_(silence_limit), joints_(names_.size()) {}

void JointStates::forget() {
  joints_.assign(names_.size(), {});
  heard_ = malformed_ = false;
  last_names_.clear();
  conflict_.reset();
}

void JointStates::take(std::span<const std::uint8_t> bytes, const bus::EndpointId& writer, Clock::time_point received) {
  heard_ = true;
  const auto content = ros2::decoded<ros2::JointState>(bytes);
  malformed_ = !content || content->position.size() != content->name.size() || !has_all_different(content->name);
  if (malformed_) return;
  if (last_names_ != content->name) last_names_ = content->name;
  const Message message{*content, writer, received};
  for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
    const auto found = std::find(content->name.begin(), content->name.end(), names_[joint]);
    if (found == content->name.end()) continue;
    const Joint& before = joints_[joint];
    if (before.received && before.writer != writer && received - *before.received < silence_limit_) {
      conflict_ = {joint, received};
      continue;
    }
    take(joints_[joint], message, static_cast<std::size_t>(found - content->name.begin()));
  }
}

void JointStates::take(Joint& joint, const Message& message, std::size_t place) {
  const double q = message.content.position[place];
  joint.is_number = std::isfinite(q);
  if (!joint.is_number) return;
  joint.qd = velocity(joint, message, place);
  joint.q = q;
  joint.writer = message.writer;
  joint.received = message.received;
  joint.stamp = seconds_of(message.content.header.stamp);
}

// The sender's clock has no jitter of the network. Empty: unknown.
std::optional<double> JointStates::velocity(const Joint& joint, const Message& message, std::size_t place) const {
  const auto& given = message.content.velocity;
  if (given.size() == message.content.name.size() && std::isfinite(given[place])) return given[place];
  if (!joint.received) return std::nullopt;
  const double limit = std::chrono::duration<double>(silence_limit_).count();
  const double by_arrival = std::chrono::duration<double>(message.received - *joint.received).count();
  const double by_stamp = seconds_of(message.content.header.stamp) - joint.stamp;
  if (by_arrival > limit) return std::nullopt;
  const double dt = by_stamp >= kShortestStep && by_stamp <= limit ? by_stamp : by_arrival;
  if (dt < kShortestStep) return joint.qd;
  const double velocity = (message.content.position[place] - joint.q) / dt;
  return std::isfinite(velocity) ? std::optional(velocity) : std::nullopt;
}

JointState JointStates::measured() const {
  const auto known = [](const Joint& joint) { return joint.received && joint.qd; };
  if (!std::all_of(joints_.begin(), joints_.end(), known)) return {};
  JointState state{JointVector(joints_.size()), JointVector(joints_.size())};
  for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
    state.q[static_cast<Eigen::Index>(joint)] = joints_[joint].q;
    state.qd[static_cast<Eigen::Index>(joint)] = *joints_[joint].qd;
  }
  return state;
}

Clock::time_point JointStates::received() const {
  return *std::min_element(joints_.begin(), joints_.end(), [](const Joint& a, const Joint& b) {
            return a.received < b.received;
          })->received;
}

std::string JointStates::complaint() const {
  if (malformed_)
    return "a message there is no valid JointState: names and positions differ in number, or a name repeats";
  std::vector<std::string> missing;
  std::vector<std::string> unknown;
  for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
    if (!joints_[joint].is_number) unknown.push_back(names_[joint]);
    const bool named = std::find(last_names_.begin(), last_names_.end(), names_[joint]) != last_names_.end();
    if (!joints_[joint].received && !named) missing.push_back(names_[joint]);
  }
  if (!unknown.empty()) return "the messages there have no number as the position of " + shown(unknown);
  if (missing.empty()) return {};
  return "the messages there lack " + shown(missing) + ", and have " + shown(last_names_);
}

std::optional<std::string> JointStates::twice_published(Clock::time_point now) const {
  if (!conflict_ || now - conflict_->at >= kConflictMemory) return std::nullopt;
  return names_[conflict_->joint];
}

}  // namespace hecaton::device::ros2_control
