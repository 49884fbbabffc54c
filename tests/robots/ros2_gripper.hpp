#pragma once
/// A gripper of ros2_control with one finger: its controller takes GripperCommand as an action, or positions by topic.

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "tests/robots/action_server.hpp"
#include "tests/robots/ros2_messages.hpp"

namespace hecaton::test::ros2 {

class Gripper {
 public:
  /// `kind`: action or position; another one: there is no gripper.
  void start(const std::string& kind, Node& node, int domain, const std::string& controller) {
    if (kind == "action") {
      server_ = std::make_unique<GripperServer>(domain, controller + "/gripper_cmd");
    } else if (kind == "position") {
      commands_ = node.reader(controller + "/commands", std_msgs_msg_dds__Float64MultiArray__desc);
    }
  }
  void stop() {
    server_.reset();
    commands_ = 0;
  }

  /// Takes orders.
  void serve() {
    if (server_) serve_actions();
    if (commands_ != 0) {
      take_each<std_msgs_msg_dds__Float64MultiArray_>(commands_, [&](const auto& message) {
        if (active && message.data._length == 1) order(message.data._buffer[0]);
      });
    }
  }
  void move(double dt) {
    constexpr double kSpeed = 0.1;  // [m/s]
    double next = finger_ + std::clamp(target_ - finger_, -kSpeed * dt, kSpeed * dt);
    if (object && finger_ != *object && (finger_ - *object) * (next - *object) <= 0.0) {
      blocked_ = *object - finger_;
      next = *object;
    } else if (object && finger_ == *object && (next - finger_) * blocked_ > 0.0) {
      next = finger_;  // the object is still there on that side; away from it the finger moves
    }
    stands_ = next == finger_ ? stands_ + dt : 0.0;
    finger_ = next;
  }

  [[nodiscard]] double finger() const { return finger_; }
  [[nodiscard]] double target() const { return target_; }
  /// Of the last action [N]; negative: none.
  [[nodiscard]] double effort() const { return effort_; }
  [[nodiscard]] int orders() const { return orders_; }

  bool active = true;            // the controller
  std::optional<double> object;  // between the fingers [m]

 private:
  void serve_actions() {
    const auto stopped = [&](bool stalled, bool reached) {
      control_msgs::action::GripperCommand_Result result;
      result.position(finger_);
      result.stalled(stalled);
      result.reached_goal(reached);
      return result;
    };
    server_->serve(
        [&](const auto& request) {
          if (!active) return false;
          order(request.goal().command().position());
          effort_ = request.goal().command().max_effort();
          return true;
        },
        stopped(false, false), [&] { return stopped(false, false); });
    // As the controller without the parameter allow_stalling.
    if (std::abs(finger_ - target_) < 1e-3) {
      server_->end(GripperServer::kSucceeded, stopped(false, true));
    } else if (stands_ > 0.2) {
      server_->end(GripperServer::kAborted, stopped(true, false));
    }
  }
  void order(double to) {
    target_ = to;
    stands_ = 0.0;
    ++orders_;
  }

  std::unique_ptr<GripperServer> server_;
  dds_entity_t commands_ = 0;
  double finger_ = 0.05, target_ = 0.05, stands_ = 0.0, effort_ = -1.0;  // [m], [m], [s], [N]
  double blocked_ = 0.0;  // its sign: the direction in which the object stops the finger
  int orders_ = 0;
};

}  // namespace hecaton::test::ros2
