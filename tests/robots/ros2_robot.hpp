#pragma once
/// The simulated robot in ros2_control: joint_state_broadcaster and one controller.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/robots/action_server.hpp"
#include "tests/robots/ros2_gripper.hpp"
#include "tests/robots/ros2_trajectory.hpp"

namespace hecaton::test::ros2 {

using Json = nlohmann::json;
using Steady = std::chrono::steady_clock;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Options {
  int domain = 0;                      // --domain N
  std::string ns;                      // --namespace /NAME
  std::string controller;              // --controller NAME
  std::string address = "127.0.0.13";  // --address A: for orders
  std::string scaling_topic;           // --scaling-topic NAME: publishes the speed scaling in percent
  bool trajectory = true;              // --kind position|velocity|trajectory|action
  bool by_velocity = false;            // --kind velocity: of a forward command controller
  bool keeps_velocity = false;         // --keeps-velocity: also when it is deactivated
  bool action = false;                 // --kind action: trajectories come as goals of FollowJointTrajectory alone
  std::string gripper;                 // --gripper action|position: a controller named gripper_controller
  std::string finger = "finger";       // --finger NAME: its joint, open at 0.05 m
  bool from_desired = false;           // --from-desired: parameter interpolate_from_desired_state
  bool velocity = true;                // --no-velocity: positions alone are measured
  Names joints;                        // --joints NAME,…
  Names others;                        // --others NAME,…: joints of other robots in the same messages
  Values start;                        // --start Q,… [rad]
  double rate = 250.0;                 // --rate HZ: of the controller manager
  double lag = 0.03;                   // --lag S: of the servos
  // --key-hash: endpoints end as those of rmw_fastrtps. Fast DDS does not read how Cyclone DDS announces it.
};

class Robot {
 public:
  explicit Robot(Options options) : options_(std::move(options)) {
    q_ = options_.start;
    q_.resize(options_.joints.size(), 0.0);
    qd_.assign(q_.size(), 0.0);
    command_.assign(q_.size(), 0.0);
    start();
  }

  /// A period of the controller manager: read, update, write.
  void cycle() {
    const double dt = 1.0 / options_.rate;
    if (off_until_ && Steady::now() >= *off_until_) {
      off_until_.reset();
      start();
    }
    if (node_) read_commands();
    if (trajectory_ && active_) follow(dt);
    move(dt);
    gripper_.move(dt);
    if (node_) publish();
  }

  Json order(const std::string& line) {
    std::istringstream words(line);
    std::string name;
    std::string value;
    words >> name >> value;
    if (name == "forget") {
      first_.reset();
      largest_ = fastest_ = 0.0;
      counted_ = refused_ = 0;
    } else if (name == "silence") {  // joint states stop
      silent_ = value == "on";
    } else if (name == "restart") {  // all nodes end, and begin again after some seconds
      stop();
      off_until_ = Steady::now() + std::chrono::duration_cast<Steady::duration>(
                                       std::chrono::duration<double>(value.empty() ? 1.0 : std::stod(value)));
    } else if (name == "deactivate") {  // ros2 control set_controller_state … inactive
      deactivate();
      end_goal(TrajectoryServer::kCanceled, kInvalidGoal, "Current goal cancelled during deactivate transition.");
    } else if (name == "activate") {
      active_ = true;
      if (!options_.by_velocity) drop_command();  // a velocity stays until the first message
    } else if (name == "unload") {                // the controller ends, its manager goes on
      deactivate();
      if (commands_ != 0) dds_delete(commands_);
      commands_ = 0;
      action_.reset();
    } else if (name == "abort") {  // the goal that runs, or the next one, ends with this code and a text
      std::string text;
      std::getline(words >> std::ws, text);
      abort_ = {std::stoi(value), text};
    } else if (name == "deaf") {  // goals are not answered
      action_->deaf = value == "on";
    } else if (name == "object") {  // something stops the finger at this position; none: nothing
      gripper_.object = value == "none" ? std::nullopt : std::optional(std::stod(value));
    } else if (name == "gripper") {  // its controller is active: on or off
      gripper_.active = value == "on";
    } else if (name == "nan") {  // the position of this joint is unknown; none: of no joint
      unknown_ = value;
    } else if (name == "lack") {  // this joint is not in the messages
      lacking_ = value;
    } else if (name == "reverse") {  // the order of joints
      reversed_ = value == "on";
    } else if (name == "split") {  // two messages with half of the joints each
      split_ = value == "on";
    } else if (name == "scaling") {  // of the hardware, in percent
      scaling_ = std::stod(value) / 100.0;
    } else if (name == "slow") {  // another node publishes a factor for the trajectory controller
      slow(std::stod(value));
    } else if (name == "drift") {  // of hardware that takes velocities [rad/s]
      drift_ = std::stod(value);
    } else if (name == "command") {  // sends a wrong command to its own controller: a size or a name
      send_wrong(value);
    } else if (name != "state") {
      return {{"error", "no order '" + name + "'"}};
    }
    return state();
  }

 private:
  void start() {
    node_ = std::make_unique<Node>(options_.domain);
    states_ = node_->writer(options_.ns + "/joint_states", sensor_msgs_msg_dds__JointState__desc);
    const std::string controller = options_.ns + "/" + options_.controller;
    if (options_.action) {
      action_ = std::make_unique<TrajectoryServer>(options_.domain, controller + "/follow_joint_trajectory");
    } else if (options_.trajectory) {
      commands_ = node_->reader(controller + "/joint_trajectory", trajectory_msgs_msg_dds__JointTrajectory__desc);
      controller_state_ =
          node_->writer(controller + "/controller_state", control_msgs_msg_dds__JointTrajectoryControllerState__desc);
      factor_ =
          node_->reader(controller + "/speed_scaling_input", control_msgs_msg_dds__SpeedScalingFactor__desc, true);
    } else {
      commands_ = node_->reader(controller + "/commands", std_msgs_msg_dds__Float64MultiArray__desc);
    }
    if (!options_.scaling_topic.empty()) {
      scaling_state_ = node_->writer(options_.ns + "/" + options_.scaling_topic, std_msgs_msg_dds__Float64__desc);
    }
    gripper_.start(options_.gripper, *node_, options_.domain, options_.ns + "/gripper_controller");
    active_ = true;
    drop_command();
  }
  // forward_command_controller leaves a velocity as it is. That of velocity_controllers, and many drivers of hardware,
  // set it to zero.
  void deactivate() {
    active_ = false;
    if (!options_.keeps_velocity) drop_command();
  }
  void stop() {
    active_ = false;
    drop_command();
    node_.reset();
    action_.reset();
    gripper_.stop();
    commands_ = 0;
  }
  /// The controller holds the arm where it is.
  void drop_command() {
    trajectory_.reset();
    desired_.reset();
    command_ = options_.by_velocity ? Values(q_.size()) : q_;
  }

  void read_commands() {
    gripper_.serve();
    if (action_) return serve_trajectories();
    if (commands_ == 0) return;
    if (options_.trajectory) {
      take_each<trajectory_msgs_msg_dds__JointTrajectory_>(commands_, [&](const auto& message) { take(message); });
      take_each<control_msgs_msg_dds__SpeedScalingFactor_>(
          factor_, [&](const auto& message) { on_controller_ = std::clamp(message.factor, 0.0, 1.0); });
    } else {
      take_each<std_msgs_msg_dds__Float64MultiArray_>(commands_, [&](const auto& message) { take(message); });
    }
  }
  void refuse(const std::string& why) {
    ++refused_;
    refusal_ = why;
  }
  void take(const std_msgs_msg_dds__Float64MultiArray_& message) {
    if (!active_) return refuse("the controller is inactive");
    if (message.data._length != q_.size()) return refuse("wrong number of commands");
    const Values command = copy(message.data);
    if (!std::all_of(command.begin(), command.end(), [](double value) { return std::isfinite(value); })) {
      return refuse("a command is not finite");
    }
    if (options_.by_velocity) {
      Values next = q_;  // after a period
      for (std::size_t j = 0; j < next.size(); ++j) next[j] += command[j] / options_.rate;
      note(next);
    } else {
      note(command);
    }
    command_ = command;
  }
  void take(const trajectory_msgs_msg_dds__JointTrajectory_& message) { (void)begin(received(message)); }
  bool begin(const Received& message) {
    if (!active_) {
      refuse("the controller is inactive");
      return false;
    }
    try {
      Trajectory trajectory;
      trajectory.points = accepted_points(message, options_.joints);
      note(trajectory.points.front().q);
      trajectory_ = std::move(trajectory);
      return true;
    } catch (const std::runtime_error& error) {
      refuse(error.what());
      return false;
    }
  }

  static control_msgs::action::FollowJointTrajectory_Result result(int code, const std::string& text) {
    control_msgs::action::FollowJointTrajectory_Result result;
    result.error_code(code);
    result.error_string(text);
    return result;
  }
  void end_goal(std::int8_t status, int code, const std::string& text) {
    if (action_) action_->end(status, result(code, text));
  }
  void serve_trajectories() {
    action_->serve([&](const auto& request) { return begin(received(request.goal().trajectory())); },
                   result(kInvalidGoal, "Current goal cancelled due to new incoming action."),
                   [&] {
                     drop_command();
                     return result(0, "");
                   });
    if (abort_ && action_->runs()) {
      drop_command();
      end_goal(TrajectoryServer::kAborted, abort_->first, abort_->second);
      abort_.reset();
    }
    if (trajectory_ && trajectory_->at >= trajectory_->points.back().at) {
      end_goal(TrajectoryServer::kSucceeded, 0, "Goal successfully reached!");
    }
  }

  /// The step from the last command, or from where the arm is.
  void note(const Values& target) {
    double step = 0.0;
    const Values& from = counted_ > 0 ? last_ : q_;
    for (std::size_t j = 0; j < q_.size(); ++j) step = std::max(step, std::abs(target[j] - from[j]));
    if (counted_ > 0) {
      largest_ = std::max(largest_, step);
    } else {
      first_ = step;
    }
    last_ = target;
    ++counted_;
  }

  void follow(double dt) {
    if (!trajectory_->before) {
      const Point measured{0.0, q_, options_.velocity ? qd_ : Values()};
      trajectory_->before = options_.from_desired && desired_ ? *desired_ : measured;
      trajectory_->before->at = 0.0;
    }
    trajectory_->at += dt * on_controller_ * scaling_;
    const Point* a = &*trajectory_->before;
    Point now{trajectory_->at, trajectory_->points.back().q, Values(q_.size())};  // at the end it holds
    for (const Point& b : trajectory_->points) {
      if (trajectory_->at < b.at) {
        now = between(*a, b, trajectory_->at);
        break;
      }
      a = &b;
    }
    desired_ = now;
    command_ = now.q;
  }

  void move(double dt) {
    const double share = 1.0 - std::exp(-dt / options_.lag);
    for (std::size_t j = 0; j < q_.size(); ++j) {
      if (options_.by_velocity) {
        qd_[j] += (command_[j] * scaling_ - qd_[j]) * share;
        q_[j] += (qd_[j] + drift_) * dt;
      } else {
        const double step = (command_[j] - q_[j]) * share;
        qd_[j] = step / dt;
        q_[j] += step;
      }
      fastest_ = std::max(fastest_, std::abs(qd_[j]));
    }
  }

  void publish() {
    ++cycles_;
    if (!silent_) {
      Names names = options_.joints;
      Values q = q_;
      Values qd = qd_;
      for (std::size_t j = 0; j < names.size(); ++j) {
        if (names[j] == unknown_) q[j] = qd[j] = kNone;
      }
      for (const std::string& other : options_.others) {
        names.insert(names.begin() + static_cast<std::ptrdiff_t>(names.size() / 2), other);
        q.insert(q.begin() + static_cast<std::ptrdiff_t>(q.size() / 2), 9.0);
        qd.insert(qd.begin() + static_cast<std::ptrdiff_t>(qd.size() / 2), kNone);
      }
      if (!options_.gripper.empty()) {
        names.push_back(options_.finger);
        q.push_back(gripper_.finger());
        qd.push_back(0.0);
      }
      if (const auto lacking = std::find(names.begin(), names.end(), lacking_); lacking != names.end()) {
        const auto place = lacking - names.begin();
        names.erase(lacking);
        q.erase(q.begin() + place);
        qd.erase(qd.begin() + place);
      }
      if (reversed_) {
        std::reverse(names.begin(), names.end());
        std::reverse(q.begin(), q.end());
        std::reverse(qd.begin(), qd.end());
      }
      if (!options_.velocity) qd.clear();
      const auto half = static_cast<std::ptrdiff_t>(names.size() / 2);
      if (split_) {
        publish(states_, {names.begin(), names.begin() + half}, {q.begin(), q.begin() + half},
                qd.empty() ? Values() : Values{qd.begin(), qd.begin() + half});
        publish(states_, {names.begin() + half, names.end()}, {q.begin() + half, q.end()},
                qd.empty() ? Values() : Values{qd.begin() + half, qd.end()});
      } else {
        publish(states_, names, q, qd);
      }
    }
    if (controller_state_ != 0 && active_ && cycles_ % 5 == 0) {
      Names names = options_.joints;
      std::vector<char*> texts = pointers(names);
      char none[] = "";
      Values q = q_;
      control_msgs_msg_dds__JointTrajectoryControllerState_ message{};
      message.header.stamp = time_now();
      message.header.frame_id = none;
      message.joint_names = view(texts);
      message.feedback.positions = view(q);
      message.speed_scaling_factor = on_controller_ * scaling_;
      checked(dds_write(controller_state_, &message), "controller_state");
    }
    if (!options_.scaling_topic.empty()) {
      const std_msgs_msg_dds__Float64_ message{100.0 * scaling_};
      checked(dds_write(scaling_state_, &message), "speed scaling");
    }
  }
  static void publish(dds_entity_t writer, Names names, Values q, Values qd) {
    std::vector<char*> texts = pointers(names);
    char frame[] = "base_link";
    sensor_msgs_msg_dds__JointState_ message{};
    message.header.stamp = time_now();
    message.header.frame_id = frame;
    message.name = view(texts);
    message.position = view(q);
    message.velocity = view(qd);
    checked(dds_write(writer, &message), "joint_states");
  }

  void slow(double factor) {
    if (!other_node_) {
      other_node_ = std::make_unique<Node>(options_.domain);
      factor_of_other_ = other_node_->writer(options_.ns + "/" + options_.controller + "/speed_scaling_input",
                                             control_msgs_msg_dds__SpeedScalingFactor__desc, true);
    }
    control_msgs_msg_dds__SpeedScalingFactor_ message{};
    message.factor = factor;
    checked(dds_write(factor_of_other_, &message), "speed scaling factor");
  }

  /// Commands that a controller must ignore.
  void send_wrong(const std::string& kind) {
    Node other(options_.domain);
    const std::string controller = options_.ns + "/" + options_.controller;
    Values q(q_.size() - 1, 1.0);
    if (options_.trajectory) {
      const auto writer =
          other.writer(controller + "/joint_trajectory", trajectory_msgs_msg_dds__JointTrajectory__desc);
      Names names = options_.joints;
      if (kind == "partial") {
        names.pop_back();
      } else {
        names.back() = "elbow_of_another_robot";
        q.push_back(1.0);
      }
      std::vector<char*> texts = pointers(names);
      char none[] = "";
      trajectory_msgs_msg_dds__JointTrajectoryPoint_ point{};
      point.positions = view(q);
      point.time_from_start.sec = 1;
      trajectory_msgs_msg_dds__JointTrajectory_ message{};
      message.header.frame_id = none;
      message.joint_names = view(texts);
      message.points = {1, 1, &point, false};
      deliver(writer, &message);
    } else {
      const auto writer = other.writer(controller + "/commands", std_msgs_msg_dds__Float64MultiArray__desc);
      std_msgs_msg_dds__Float64MultiArray_ message{};
      message.data = view(q);
      deliver(writer, &message);
    }
  }
  static void deliver(dds_entity_t writer, const void* message) {
    dds_publication_matched_status_t matched{};
    while (matched.current_count == 0) {
      checked(dds_get_publication_matched_status(writer, &matched), "matched");
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    checked(dds_write(writer, message), "wrong command");
    checked(dds_wait_for_acks(writer, DDS_SECS(5)), "acknowledgement");
  }

  [[nodiscard]] Json state() const {
    return {{"q", q_},
            {"qd", qd_},
            {"active", active_},
            {"running", node_ != nullptr},
            {"first", first_ ? Json(*first_) : Json()},
            {"largest", largest_},
            {"fastest", fastest_},
            {"commands", counted_},
            {"command", command_},
            {"refused", refused_},
            {"refusal", refusal_},
            {"cancels", action_ ? action_->cancels : 0},
            {"finger", gripper_.finger()},
            {"finger_target", gripper_.target()},
            {"effort", gripper_.effort()},
            {"gripper_orders", gripper_.orders()},
            {"scaling", on_controller_ * scaling_}};
  }

  static constexpr int kInvalidGoal = -1;

  Options options_;
  std::unique_ptr<Node> node_;
  std::unique_ptr<Node> other_node_;  ///< that slows the controller
  dds_entity_t factor_of_other_ = 0;
  dds_entity_t states_ = 0, commands_ = 0, controller_state_ = 0, factor_ = 0, scaling_state_ = 0;
  std::unique_ptr<TrajectoryServer> action_;
  Gripper gripper_;
  std::optional<std::pair<int, std::string>> abort_;
  std::optional<Steady::time_point> off_until_;
  bool active_ = false;
  bool silent_ = false, reversed_ = false, split_ = false;
  std::string unknown_, lacking_;
  Values q_, qd_, command_;
  std::optional<Trajectory> trajectory_;
  std::optional<Point> desired_;
  double on_controller_ = 1.0, scaling_ = 1.0, drift_ = 0.0;
  std::uint64_t cycles_ = 0;
  // What has been commanded since the order to forget.
  Values last_;
  std::optional<double> first_;
  double largest_ = 0.0, fastest_ = 0.0;
  int counted_ = 0, refused_ = 0;
  std::string refusal_;
};

}  // namespace hecaton::test::ros2
