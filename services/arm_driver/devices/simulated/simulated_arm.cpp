#include "services/arm_driver/devices/simulated/simulated_arm.hpp"

#include <algorithm>
#include <array>

#include "planner/simulation/arm_model.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::device {
namespace {

/// After a longer stall the arm is at rest anyway.
constexpr std::chrono::seconds kLongestStall{2};

using Positions = std::array<double, planner::kMaxJoints>;

class SimulatedArm final : public ArmDevice {
 public:
  explicit SimulatedArm(const DeviceSetup& setup)
      : period_(setup.period),
        checkpoint_(setup.checkpoint, static_cast<std::uint64_t>(setup.start.size()), "the simulated arm's position"),
        joints_(setup.limits, start_of(setup)) {}

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

  void store() {
    Positions q{};
    std::copy(joints_.state().q.begin(), joints_.state().q.end(), q.begin());
    checkpoint_.remember(q);
  }

  std::chrono::nanoseconds period_;
  services::MappedRecord<Positions> checkpoint_;
  planner::ServoedJoints joints_;
  std::optional<Clock::time_point> at_;  ///< the time of its state
  std::optional<SetPoint> set_point_;
};

}  // namespace

std::unique_ptr<ArmDevice> make_simulated_arm(const DeviceSetup& setup) {
  return std::make_unique<SimulatedArm>(setup);
}

}  // namespace hecaton::device
