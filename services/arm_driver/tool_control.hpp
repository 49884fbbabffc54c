#pragma once
/// The gripper and the signals of an arm: carries out a person's orders, and tells where joints outside the chain are.
/// No network, no clock.
///
/// Close:  find what is between the fingers ─► the world attaches it ─► announce the way of the fingers ─► move ─► done
/// Open:   announce the way ─► move ─► the world detaches what was held ─► done
///
/// Announced positions are in each ArmState for at least the longest `state_age_limit` before a finger moves. A planner
/// that has not received them by then has no fresh state, and its arm stands.

#include <array>
#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <idl/arm.h>

#include "planner/model/followers.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/arm_driver/devices/arm_device.hpp"
#include "services/runtime/atomic_file.hpp"
#include "world/model/scene.hpp"

namespace hecaton::services {

/// What the driver knows in a period.
struct ToolInputs {
  device::Clock::time_point now{};
  const planner::JointVector& q;  ///< measured; empty: not known
  bool moves = false;             ///< the arm is not at rest
  bool stopped = false;           ///< a person ordered stop
  /// Each obstacle that the world has described: whether it is attached to the arm.
  const std::map<std::string, bool, std::less<>>& attached;
  /// All obstacles that no arm carries, where they are now; called when fingers close.
  std::function<std::vector<world::Obstacle>()> obstacles;
};

/// For one thread.
class ToolControl {
 public:
  /// `kinds`: of the signals. `checkpoint`: a file that survives the process; empty: none. The device must outlive it.
  ToolControl(const config::CellFile& file, int arm, std::vector<device::SignalKind> kinds,
              const std::string& checkpoint, device::ArmDevice& device);

  /// True: begin() takes this order.
  [[nodiscard]] static bool takes(msg::DeviceOrder order);
  /// Begins an order. Returns why not; empty: it runs, and end() reports its end.
  [[nodiscard]] std::optional<msg::Cause> begin(const msg::DeviceRequest& request, const ToolInputs& inputs);
  /// Once in each period, after ArmDevice::read(). At the first call the tool is as the device reports it; nothing
  /// moves without an order.
  void update(const ToolInputs& inputs);
  /// The end of the order, once: CAUSE_NONE if it was carried out, else why not. Empty while it runs.
  [[nodiscard]] std::optional<msg::Cause> end();

  /// The arm has a gripper, signals, or joints outside the chain with a range.
  [[nodiscard]] bool present() const;
  void write(msg::ArmState& state) const;
  void write(msg::ToolState& state) const;
  /// The obstacle that its order closes on, holds or releases.
  [[nodiscard]] const std::string& holding() const { return holding_; }

 private:
  enum class Phase { kIdle, kStanding, kAttaching, kAnnouncing, kMoving, kReleasing };
  /// Of the obstacle that is held, and of joints that a person has placed.
  struct Memory {
    std::array<char, 256> holding{};
    std::array<double, 16> placed{};
    std::array<bool, 16> is_placed{};
  };

  [[nodiscard]] msg::Cause refused(msg::CauseKind kind, const std::string& subject, const std::string& text) const;
  [[nodiscard]] std::optional<msg::Cause> begin_gripper(const msg::DeviceRequest& request, const ToolInputs& inputs);
  [[nodiscard]] std::optional<msg::Cause> set_signal(const msg::DeviceRequest& request);
  [[nodiscard]] std::optional<msg::Cause> place_joint(const msg::DeviceRequest& request);
  /// `begun`: becomes true when the first of several signals is set, whatever the result is.
  [[nodiscard]] device::DeviceResult start_moving(bool& begun);
  void read_device();
  void read_signals();
  void prepare(const ToolInputs& inputs);
  /// The fingers may be at target_, too.
  void include_target();
  void announce(device::Clock::time_point now);
  void finish(msg::Cause cause);
  void settle();
  void remember();
  [[nodiscard]] bool moves_by_signals() const { return gripper_ && !gripper_->close.empty(); }
  /// The device reports the end of a motion: something between the fingers stops them.
  [[nodiscard]] bool yields() const { return !moves_by_signals() && device_.fingers_yield(); }
  [[nodiscard]] bool arrived(device::Clock::time_point now) const;
  [[nodiscard]] std::optional<double> finger() const;
  void follow_fingers();
  void end_motion(const ToolInputs& inputs);
  /// Ends an order whose fingers have not moved: what the world has attached for it is not held.
  void give_up(const ToolInputs& inputs, msg::Cause why);
  void release(const ToolInputs& inputs, msg::Cause end);
  [[nodiscard]] std::vector<double> with_gripper_at(double position) const;
  [[nodiscard]] std::optional<double> width() const;
  [[nodiscard]] bool is_finger(std::size_t joint) const;

  planner::Arm arm_;
  config::ToolOptions options_;
  const std::optional<config::Gripper>& gripper_;
  std::vector<device::SignalKind> kinds_;
  device::ArmDevice& device_;
  std::chrono::nanoseconds announced_for_{0};
  MappedRecord<Memory> checkpoint_;
  Memory memory_;

  std::vector<planner::MotionRange> between_;     ///< of each joint outside the chain, as published
  std::vector<std::optional<double>> positions_;  ///< last known
  std::vector<std::optional<double>> signals_;    ///< last known
  std::string grasping_, holding_, releasing_;
  bool begun_ = false;

  Phase phase_ = Phase::kIdle;
  bool closing_ = false;
  double position_ = 0.0;              ///< that the order wants of the fingers [rad | m]
  double force_ = -1.0;                ///< that the order wants; negative: not given [N]
  std::optional<double> contact_;      ///< position of the fingers where they touch what they grasp [rad | m]
  msg::Cause after_release_;           ///< the end of the order when the obstacle is detached
  std::vector<double> target_;         ///< of the order
  device::Clock::time_point since_{};  ///< of the phase
  std::optional<msg::Cause> end_;
};

}  // namespace hecaton::services
