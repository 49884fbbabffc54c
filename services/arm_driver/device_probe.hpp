#pragma once
/// Observes a device for its conformance test: what it reports, and how long its calls take.

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::services {

/// Passes each call on to a device, and records it. For one thread.
class DeviceProbe final : public device::ArmDevice {
 public:
  using Clock = device::Clock;
  using Now = std::function<Clock::time_point()>;

  /// `device` must outlive it. `joints`: of the arm. `period`: of read() and write().
  DeviceProbe(device::ArmDevice& device, Eigen::Index joints, std::chrono::nanoseconds period, Now now);

  [[nodiscard]] device::DeviceResult configure() override;
  [[nodiscard]] device::DeviceResult activate() override;
  [[nodiscard]] device::DeviceState read(Clock::time_point now) override;
  [[nodiscard]] device::DeviceResult write(const device::JointState& set_point,
                                           std::chrono::nanoseconds valid_for) override;
  void stop(std::string_view reason) override;
  void deactivate() override;
  [[nodiscard]] double tracking_delay() const override { return device_.tracking_delay(); }

  /// activate() was called, and the device has not been stopped or deactivated since.
  [[nodiscard]] bool active() const { return active_; }
  /// The last state measures all joints, and the device was ready.
  [[nodiscard]] bool ready() const;
  [[nodiscard]] const device::DeviceState& state() const { return state_; }
  /// The joints as they were measured last; empty before the first time.
  [[nodiscard]] const device::JointState& measured() const { return measured_; }
  [[nodiscard]] Clock::time_point measured_at() const { return measured_at_; }
  /// Where the set-points since activate() want the joints at the instant of the measurement, between two of them on a
  /// line. None while no set-point is valid: the machine has stalled, and a device may have stopped by itself.
  [[nodiscard]] std::optional<device::JointVector> wanted() const;
  /// The oldest state that was reported as ready.
  [[nodiscard]] std::chrono::nanoseconds oldest() const { return oldest_; }
  /// The largest distance of a joint from its position before activate(), measured or as a set-point, before
  /// release() [rad | m].
  [[nodiscard]] double jump() const { return jump_; }
  /// The arm may move until the next activate().
  void release() { before_activation_.reset(); }
  /// Durations of read() and write() together, of each period in which both were called.
  [[nodiscard]] const std::vector<std::chrono::nanoseconds>& durations() const { return durations_; }
  [[nodiscard]] int activations() const { return activations_; }
  /// The first state or failure that breaks the contract, as a phrase; empty: none.
  [[nodiscard]] const std::string& violation() const { return violation_; }

 private:
  void check(const device::DeviceState& state);
  [[nodiscard]] device::DeviceResult checked(device::DeviceResult result, std::string_view call);
  void note_jump(const device::JointVector& q);

  struct SetPoint {
    Clock::time_point written;
    Clock::time_point due;
    Clock::time_point valid_until;
    device::JointVector q;
  };

  device::ArmDevice& device_;
  Eigen::Index joints_;
  std::chrono::nanoseconds period_;
  Now now_;
  Clock::time_point read_at_;
  std::deque<SetPoint> set_points_;  ///< of the last time, oldest first
  device::DeviceState state_;
  device::JointState measured_;
  Clock::time_point measured_at_;
  bool active_ = false;
  int activations_ = 0;
  std::chrono::nanoseconds oldest_{0};
  std::optional<device::JointVector> before_activation_;
  double jump_ = 0.0;
  std::optional<std::chrono::nanoseconds> read_took_;
  std::vector<std::chrono::nanoseconds> durations_;
  std::string violation_;
};

}  // namespace hecaton::services
