#include "services/arm_driver/devices/simulated/simulated_arm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <utility>

#include "planner/simulation/arm_model.hpp"
#include "services/arm_driver/devices/simulated/options.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::device {
namespace {

/// A drive filters what it measures: a force counts after about this time [s].
constexpr double kForceFilter = 0.02;

/// After a longer stall the arm is at rest anyway.
constexpr std::chrono::seconds kLongestStall{2};
/// An arm that was slower than its set-points is as fast again once it is this near to them [rad | m].
constexpr double kAtSetPoint = 1e-6;

using Positions = std::array<double, planner::kMaxJoints>;

constexpr std::size_t kMostSignals = 64;

/// What stays when the driver's process ends, like the arm itself.
struct Tool {
  Positions outside{};  ///< [rad | m]
  std::array<double, kMostSignals> signals{};
  bool protective = false;  ///< a protective stop lasts until a person unlocks it
};

constexpr std::array<std::pair<std::string_view, SignalKind>, 4> kPorts{{
    {"digital_input", SignalKind::kDigitalInput},
    {"digital_output", SignalKind::kDigitalOutput},
    {"analog_input", SignalKind::kAnalogInput},
    {"analog_output", SignalKind::kAnalogOutput},
}};

/// Outputs with which a person causes what happens to real arms.
constexpr std::string_view kProtectiveStop = "protective_stop";
constexpr std::string_view kEmergencyStop = "emergency_stop";
constexpr std::string_view kConnectionLost = "connection_lost";
constexpr std::string_view kSpeedScaling = "speed_scaling";
constexpr std::array<std::string_view, 3> kEvents{kProtectiveStop, kEmergencyStop, kConnectionLost};

class SimulatedArm final : public ArmDevice {
 public:
  explicit SimulatedArm(const DeviceSetup& setup)
      : options_(read_simulated_options(setup)),
        arm_(setup.arm),
        period_(setup.period),
        checkpoint_(setup.checkpoint, static_cast<std::uint64_t>(setup.start.size()), "the simulated arm's position"),
        tool_checkpoint_(setup.checkpoint.empty() ? setup.checkpoint : setup.checkpoint + ".tool", setup.outside.size(),
                         "the simulated arm's tool"),
        limits_(setup.limits),
        joints_(setup.limits, start_of(setup)),
        ports_(setup.signals),
        joint_names_(setup.joint_names),
        prismatic_(setup.prismatic),
        forces_(setup.forces),
        outside_count_(setup.outside.size()),
        outside_speed_(setup.outside_speed) {
    std::copy(setup.outside.begin(), setup.outside.end(), tool_.outside.begin());
    for (std::size_t i = 0; i < ports_.size(); ++i) {
      if (ports_[i] == kSpeedScaling) tool_.signals[i] = 1.0;
    }
    if (const auto kept = tool_checkpoint_.recall()) tool_ = *kept;
    tool_.protective = tool_.protective || event(kProtectiveStop);
    share_ = scaling();
    if (!options_.servo.perfect()) {
      const auto seed = static_cast<std::uint64_t>(setup.index);
      servo_.emplace(setup.limits, options_.servo, joints_.state().q, seed);
    }
    paced_ = moving();
    target_.assign(tool_.outside.begin(), tool_.outside.begin() + static_cast<std::ptrdiff_t>(outside_count_));
  }

  DeviceResult configure() override {
    if (event(kConnectionLost)) return DeviceFailure{lost_text()};
    return {};
  }
  DeviceResult activate() override { return {}; }

  DeviceState read(Clock::time_point now) override {
    if (!at_) at_ = now;
    at_ = std::max(*at_, now - kLongestStall);
    while (*at_ < now) advance(std::min(now, *at_ + period_));
    store();
    if (!event(kConnectionLost)) {
      seen_ = measured();
      seen_at_ = now;
    }
    const auto [mode, text] = condition();
    return {seen_, now - seen_at_, scaling(), mode, text};
  }

  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) override {
    set_point_ = SetPoint{set_point, *at_ + period_, *at_ + valid_for};
    return {};
  }

  void stop(std::string_view /*reason*/) override { set_point_.reset(); }
  void deactivate() override { set_point_.reset(); }
  [[nodiscard]] bool continues_after_restart() const override { return !tool_.protective; }
  [[nodiscard]] double tracking_delay() const override { return options_.servo.delay(); }

  DeviceResult begin(DeviceOrder order) override {
    if (order != DeviceOrder::kUnlock) return DeviceFailure{"a simulated arm is always on"};
    set_protective(false, {});
    ended_ = OrderEnd{};
    return {};
  }
  std::optional<OrderEnd> order_end() override { return std::exchange(ended_, std::nullopt); }

  // A person plays the sensors of a simulated arm, therefore inputs can be set, too.
  [[nodiscard]] std::optional<double> signal(std::size_t index) const override { return tool_.signals[index]; }
  DeviceResult set_signal(std::size_t index, double value) override {
    if (ports_[index] == kSpeedScaling && !(value >= 0.0 && value <= 1.0)) {
      return DeviceFailure{"its speed_scaling must be 0 to 1"};
    }
    tool_.signals[index] = value;
    if (ports_[index] == kProtectiveStop) set_protective(value != 0.0, {});
    tool_checkpoint_.remember(tool_);
    return {};
  }
  [[nodiscard]] std::vector<double> outside() const override {
    return {tool_.outside.begin(), tool_.outside.begin() + static_cast<std::ptrdiff_t>(outside_count_)};
  }
  DeviceResult move_outside(const std::vector<double>& positions, double /*force*/) override {
    target_ = positions;
    return {};
  }

 private:
  struct SetPoint {
    JointState target;
    Clock::time_point due;
    Clock::time_point valid_until;
  };

  [[nodiscard]] JointVector start_of(const DeviceSetup& setup) const {
    const auto kept = checkpoint_.recall();
    if (!kept) return setup.start;
    const JointVector q = Eigen::Map<const Eigen::VectorXd>(kept->data(), setup.start.size());
    return q.allFinite() ? q : setup.start;
  }

  /// A person has switched this event on.
  [[nodiscard]] bool event(std::string_view port) const {
    for (std::size_t i = 0; i < ports_.size(); ++i) {
      if (ports_[i] == port && tool_.signals[i] != 0.0) return true;
    }
    return false;
  }
  /// `cause`: a clause for a person; empty: a person caused it.
  void set_protective(bool on, std::string cause) {
    tool_.protective = on;
    force_.resize(0);  // what drives measured before the stop is over
    cause_ = std::move(cause);
    for (std::size_t i = 0; i < ports_.size(); ++i) {
      if (ports_[i] == kProtectiveStop) tool_.signals[i] = on ? 1.0 : 0.0;
    }
    tool_checkpoint_.remember(tool_);
  }
  [[nodiscard]] double scaling() const {
    for (std::size_t i = 0; i < ports_.size(); ++i) {
      if (ports_[i] == kSpeedScaling) return tool_.signals[i];
    }
    return 1.0;
  }
  [[nodiscard]] static std::string lost_text() {
    return "its connection is lost: set its signal connection_lost to 0, then resume the arm";
  }
  [[nodiscard]] std::pair<DeviceMode, std::string> condition() const {
    if (event(kConnectionLost)) return {DeviceMode::kFailed, lost_text()};
    if (event(kEmergencyStop)) {
      return {DeviceMode::kEmergencyStop, "emergency stop: set its signal emergency_stop to 0, then resume the arm"};
    }
    if (tool_.protective) {
      return {DeviceMode::kProtectiveStop, "protective stop" + (cause_.empty() ? "" : ", because " + cause_) +
                                               ": call 'hecaton device " + arm_ + " unlock', then resume the arm"};
    }
    return {DeviceMode::kReady, {}};
  }

  /// Where the joints are, without noise.
  [[nodiscard]] const JointState& moving() const { return servo_ ? servo_->state() : joints_.state(); }
  [[nodiscard]] const JointState& measured() const { return servo_ ? servo_->measured() : joints_.state(); }
  void follow(const JointState& set_point, double dt) {
    scale(set_point, dt);
    servo_ ? servo_->follow(paced_, dt) : joints_.follow(paced_, dt);
  }
  void brake(double dt) {
    servo_ ? servo_->brake(dt) : joints_.brake(dt);
    paced_ = moving();
  }
  /// With a lower speed scaling, the arm runs after its set-points at that share of its velocity limits.
  void scale(const JointState& set_point, double dt) {
    if (share_ >= 1.0 && !behind_) {
      paced_ = set_point;
      return;
    }
    JointLimits slower = limits_;
    slower.velocity *= share_;
    planner::follow_within_limits(slower, set_point, dt, paced_);
    behind_ = (paced_.q - set_point.q).cwiseAbs().maxCoeff() > kAtSetPoint;
  }
  /// The share changes only as fast as the joints can brake and speed up.
  void approach_scaling(double dt) {
    const double step = dt * (limits_.acceleration.array() / limits_.velocity.array()).minCoeff();
    share_ += std::clamp(scaling() - share_, -step, step);
  }

  // Between set-points the arm moves on with the velocity of the last one as long as that is valid.
  void advance(Clock::time_point to) {
    const double dt = std::chrono::duration<double>(to - *at_).count();
    move_fingers(dt);
    approach_scaling(dt);
    const auto before = std::tuple(joints_, servo_, paced_);
    const JointVector velocity_before = moving().qd;
    const bool stopped = tool_.protective || event(kEmergencyStop);
    if (!stopped && set_point_ && to <= set_point_->valid_until) {
      const double beyond = std::chrono::duration<double>(to - set_point_->due).count();
      follow({set_point_->target.q + set_point_->target.qd * beyond, set_point_->target.qd}, dt);
    } else {
      brake(dt);
    }
    if (!measured().q.allFinite() || !measured().qd.allFinite()) {
      std::tie(joints_, servo_, paced_) = before;
      set_point_.reset();
    }
    if (!tool_.protective) guard(velocity_before, dt);
    at_ = to;
  }

  /// What stops real controllers: a joint that is too fast, and a drive that has to push too much.
  void guard(const JointVector& velocity_before, double dt) {
    const JointState& state = moving();
    Eigen::Index joint = 0;
    if (options_.protective_speed > 0.0 && state.qd.cwiseAbs().maxCoeff(&joint) > options_.protective_speed) {
      return set_protective(true, exceeds(joint, "moved at", state.qd[joint], options_.protective_speed,
                                          slides(joint) ? "m/s" : "rad/s"));
    }
    if (options_.protective_effort <= 0.0) return;
    const JointVector now = forces_.of_motion(state.q, state.qd, (state.qd - velocity_before) / dt);
    if (force_.size() == 0)
      force_ = forces_.of_motion(state.q, JointVector::Zero(now.size()), JointVector::Zero(now.size()));
    force_ += (1.0 - std::exp(-dt / kForceFilter)) * (now - force_);
    const JointVector limits = options_.protective_effort * forces_.limits;
    if ((force_.cwiseAbs().array() <= limits.array()).all()) return;
    (force_.cwiseAbs() - limits).maxCoeff(&joint);
    set_protective(true, exceeds(joint, "needed", force_[joint], limits[joint], slides(joint) ? "N" : "N m"));
  }

  /// "joint elbow moved at 1.62 rad/s, its limit is 1.5 rad/s"
  [[nodiscard]] std::string exceeds(Eigen::Index joint, const char* what, double value, double limit,
                                    const char* unit) const {
    const auto place = static_cast<std::size_t>(joint);
    const std::string name = place < joint_names_.size() ? joint_names_[place] : std::to_string(place + 1);
    char numbers[96];
    std::snprintf(numbers, sizeof numbers, " %.3g %s, its limit is %.3g %s", std::abs(value), unit, limit, unit);
    return "joint " + name + " " + what + numbers;
  }
  [[nodiscard]] bool slides(Eigen::Index joint) const {
    const auto place = static_cast<std::size_t>(joint);
    return place < prismatic_.size() && prismatic_[place];
  }

  void move_fingers(double dt) {
    if (std::equal(target_.begin(), target_.end(), tool_.outside.begin())) return;
    const double step = outside_speed_ * dt;
    for (std::size_t i = 0; i < target_.size(); ++i) {
      tool_.outside[i] += std::clamp(target_[i] - tool_.outside[i], -step, step);
    }
    tool_checkpoint_.remember(tool_);
  }

  void store() {
    Positions q{};
    const JointVector& at = moving().q;
    std::copy(at.begin(), at.end(), q.begin());
    checkpoint_.remember(q);
  }

  SimulatedOptions options_;
  std::string arm_;  ///< its name
  std::chrono::nanoseconds period_;
  services::MappedRecord<Positions> checkpoint_;
  services::MappedRecord<Tool> tool_checkpoint_;
  JointLimits limits_;
  planner::ServoedJoints joints_;
  std::optional<planner::Servo> servo_;  ///< nothing: a perfect controller, and `joints_` are the arm
  JointState paced_;                     ///< the set-point at the speed that the scaling leaves
  double share_ = 1.0;                   ///< of the velocity limits that the arm uses, 0 to 1
  bool behind_ = false;                  ///< `paced_` is not at the set-point yet
  std::vector<std::string> ports_;       ///< of the signals
  std::vector<std::string> joint_names_;
  std::vector<bool> prismatic_;  ///< each joint; empty: none
  DriveForces forces_;
  JointVector force_;  ///< filtered [N m | N]; empty until the first step
  std::string cause_;  ///< of the protective stop; empty: a person, or the process before did not say
  JointState seen_;    ///< the last state before the connection was lost
  Clock::time_point seen_at_;
  std::optional<OrderEnd> ended_;
  std::size_t outside_count_;
  double outside_speed_;  ///< [rad/s | m/s]
  Tool tool_;
  std::vector<double> target_;           ///< of the joints outside the chain; after a restart they stay where they are
  std::optional<Clock::time_point> at_;  ///< the time of its state
  std::optional<SetPoint> set_point_;
};

}  // namespace

std::optional<SignalKind> simulated_signal(std::string_view port) {
  if (std::find(kEvents.begin(), kEvents.end(), port) != kEvents.end()) return SignalKind::kDigitalOutput;
  if (port == kSpeedScaling) return SignalKind::kAnalogOutput;
  for (const auto& [name, kind] : kPorts) {
    const std::string_view rest = port.starts_with(name) ? port.substr(name.size()) : "-";
    const bool numbered = rest.size() > 1 && rest.size() <= 3 && rest.front() == ' ' &&
                          rest.find_first_not_of("0123456789", 1) == std::string_view::npos;
    if (rest.empty() || numbered) return kind;
  }
  return std::nullopt;
}

std::unique_ptr<ArmDevice> make_simulated_arm(const DeviceSetup& setup) {
  return std::make_unique<SimulatedArm>(setup);
}

}  // namespace hecaton::device
