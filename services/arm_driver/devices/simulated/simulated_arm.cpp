#include "services/arm_driver/devices/simulated/simulated_arm.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "planner/simulation/arm_model.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::device {
namespace {

/// After a longer stall the arm is at rest anyway.
constexpr std::chrono::seconds kLongestStall{2};

using Positions = std::array<double, planner::kMaxJoints>;

constexpr std::size_t kMostSignals = 64;

/// What stays when the driver's process ends, like the arm itself.
struct Tool {
  Positions outside{};  ///< [rad | m]
  std::array<double, kMostSignals> signals{};
};

constexpr std::array<std::pair<std::string_view, SignalKind>, 4> kPorts{{
    {"digital_input", SignalKind::kDigitalInput},
    {"digital_output", SignalKind::kDigitalOutput},
    {"analog_input", SignalKind::kAnalogInput},
    {"analog_output", SignalKind::kAnalogOutput},
}};

class SimulatedArm final : public ArmDevice {
 public:
  explicit SimulatedArm(const DeviceSetup& setup)
      : period_(setup.period),
        checkpoint_(setup.checkpoint, static_cast<std::uint64_t>(setup.start.size()), "the simulated arm's position"),
        tool_checkpoint_(setup.checkpoint.empty() ? setup.checkpoint : setup.checkpoint + ".tool", setup.outside.size(),
                         "the simulated arm's tool"),
        joints_(setup.limits, start_of(setup)),
        outside_count_(setup.outside.size()),
        outside_speed_(setup.outside_speed) {
    std::copy(setup.outside.begin(), setup.outside.end(), tool_.outside.begin());
    if (const auto kept = tool_checkpoint_.recall()) tool_ = *kept;
    target_.assign(tool_.outside.begin(), tool_.outside.begin() + static_cast<std::ptrdiff_t>(outside_count_));
  }

  DeviceResult configure() override { return {}; }
  DeviceResult activate() override { return {}; }

  DeviceState read(Clock::time_point now) override {
    if (!at_) at_ = now;
    at_ = std::max(*at_, now - kLongestStall);
    while (*at_ < now) advance(std::min(now, *at_ + period_));
    store();
    return {joints_.state(), {}, 1.0, DeviceMode::kReady, {}};
  }

  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) override {
    set_point_ = SetPoint{set_point, *at_ + period_, *at_ + valid_for};
    return {};
  }

  void stop(std::string_view /*reason*/) override { set_point_.reset(); }
  void deactivate() override { set_point_.reset(); }
  [[nodiscard]] bool continues_after_restart() const override { return true; }

  // A person plays the sensors of a simulated arm, therefore inputs can be set, too.
  [[nodiscard]] std::optional<double> signal(std::size_t index) const override { return tool_.signals[index]; }
  DeviceResult set_signal(std::size_t index, double value) override {
    tool_.signals[index] = value;
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

  // Between set-points the arm moves on with the velocity of the last one as long as that is valid.
  void advance(Clock::time_point to) {
    const double dt = std::chrono::duration<double>(to - *at_).count();
    move_fingers(dt);
    const auto before = joints_;
    if (set_point_ && to <= set_point_->valid_until) {
      const double beyond = std::chrono::duration<double>(to - set_point_->due).count();
      joints_.follow({set_point_->target.q + set_point_->target.qd * beyond, set_point_->target.qd}, dt);
    } else {
      joints_.brake(dt);
    }
    if (!joints_.state().q.allFinite() || !joints_.state().qd.allFinite()) {
      joints_ = before;
      set_point_.reset();
    }
    at_ = to;
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
    std::copy(joints_.state().q.begin(), joints_.state().q.end(), q.begin());
    checkpoint_.remember(q);
  }

  std::chrono::nanoseconds period_;
  services::MappedRecord<Positions> checkpoint_;
  services::MappedRecord<Tool> tool_checkpoint_;
  planner::ServoedJoints joints_;
  std::size_t outside_count_;
  double outside_speed_;  ///< [rad/s | m/s]
  Tool tool_;
  std::vector<double> target_;           ///< of the joints outside the chain; after a restart they stay where they are
  std::optional<Clock::time_point> at_;  ///< the time of its state
  std::optional<SetPoint> set_point_;
};

}  // namespace

std::optional<SignalKind> simulated_signal(std::string_view port) {
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
