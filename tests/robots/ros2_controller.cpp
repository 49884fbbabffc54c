/// Simulates an arm in ros2_control on the network: joint_state_broadcaster, and a forward position controller or a
/// joint trajectory controller, whose trajectories come by topic or by action; also the controller of a gripper. It
/// uses Cyclone DDS (for actions: action_server.hpp), and shares no code with the driver. Its sources are the
/// definitions of the messages and the documentation of the controllers.
///
/// usage: ros2_controller --joints NAME,… [OPTION…]. The options are those of the struct Options.
///
/// Tests give orders on TCP port 30999 of the address, and people on the standard input: a line each, answered by a
/// line of JSON. The orders are those of Robot::order(). The hardware is a servo of first order for each joint.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <dds/dds.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

extern "C" {
#include "ros2_control.h"
}

#include "tests/robots/action_server.hpp"

namespace {

namespace test = hecaton::test;
using Json = nlohmann::json;
using Steady = std::chrono::steady_clock;
using Values = std::vector<double>;
using Names = std::vector<std::string>;

constexpr std::uint16_t kControlPort = 30999;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Options {
  int domain = 0;                      // --domain N
  std::string ns;                      // --namespace /NAME
  std::string controller;              // --controller NAME
  std::string address = "127.0.0.13";  // --address A: for orders
  std::string scaling_topic;           // --scaling-topic NAME: publishes the speed scaling in percent
  bool trajectory = true;              // --kind position|trajectory|action
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

dds_entity_t checked(dds_return_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error(what + ": " + dds_strretcode(result));
  return result;
}

// --- messages

dds_sequence_double view(Values& values) {
  return {static_cast<std::uint32_t>(values.size()), static_cast<std::uint32_t>(values.size()), values.data(), false};
}
Values copy(const dds_sequence_double& values) {
  return {values._buffer, values._buffer + values._length};
}
Names copy(const dds_sequence_string& names) {
  return {names._buffer, names._buffer + names._length};
}
dds_sequence_string view(std::vector<char*>& names) {
  return {static_cast<std::uint32_t>(names.size()), static_cast<std::uint32_t>(names.size()), names.data(), false};
}
std::vector<char*> pointers(Names& names) {
  std::vector<char*> result;
  for (std::string& name : names) result.push_back(name.data());
  return result;
}
builtin_interfaces_msg_dds__Time_ time_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  return {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)};
}
double seconds(const builtin_interfaces_msg_dds__Duration_& time) {
  return time.sec + 1e-9 * time.nanosec;
}

/// SystemDefaultsQoS: reliable, volatile, the last 10 samples.
class Node {
 public:
  explicit Node(int domain)
      : participant_(checked(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr), "domain")) {
  }
  ~Node() { dds_delete(participant_); }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  dds_entity_t writer(const std::string& topic, const dds_topic_descriptor_t& type) {
    return endpoint(topic, type, false, [&](dds_entity_t of, const dds_qos_t* qos) {
      return dds_create_writer(participant_, of, qos, nullptr);
    });
  }
  dds_entity_t reader(const std::string& topic, const dds_topic_descriptor_t& type, bool latched = false) {
    return endpoint(topic, type, latched, [&](dds_entity_t of, const dds_qos_t* qos) {
      return dds_create_reader(participant_, of, qos, nullptr);
    });
  }

 private:
  template <class Create>
  dds_entity_t endpoint(const std::string& topic, const dds_topic_descriptor_t& type, bool latched, Create create) {
    const std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)> qos(dds_create_qos(), dds_delete_qos);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, latched ? 1 : 10);
    const std::string name = "rt" + topic;
    const dds_entity_t of = checked(dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr), name);
    return checked(create(of, qos.get()), name);
  }
  dds_entity_t participant_;
};

template <class T, class Visit>
void take_each(dds_entity_t reader, Visit visit) {
  constexpr std::uint32_t kMost = 20;
  void* samples[kMost] = {};
  dds_sample_info_t infos[kMost];
  const auto count = checked(dds_take(reader, samples, infos, kMost, kMost), "take");
  for (int i = 0; i < count; ++i) {
    if (infos[i].valid_data) visit(*static_cast<const T*>(samples[i]));
  }
  if (count > 0) checked(dds_return_loan(reader, samples, count), "loan");
}

// --- the joint trajectory controller

struct Point {
  double at = 0.0;  // [s]
  Values q;
  Values qd;  // empty: none
};

Point between(const Point& a, const Point& b, double at) {
  const double T = b.at - a.at;
  if (at >= b.at || T <= 0.0) return {at, b.q, b.qd};
  const double t = at - a.at;
  Point result{at, Values(a.q.size()), Values(a.q.size())};
  for (std::size_t j = 0; j < a.q.size(); ++j) {
    const double d = b.q[j] - a.q[j];
    if (a.qd.empty() || b.qd.empty()) {
      result.q[j] = a.q[j] + d * t / T;
      result.qd[j] = d / T;
      continue;
    }
    const double c2 = (3 * d - (2 * a.qd[j] + b.qd[j]) * T) / (T * T);
    const double c3 = (-2 * d + (a.qd[j] + b.qd[j]) * T) / (T * T * T);
    result.q[j] = a.q[j] + t * (a.qd[j] + t * (c2 + t * c3));
    result.qd[j] = a.qd[j] + t * (2 * c2 + 3 * t * c3);
  }
  return result;
}

/// A trajectory as it comes from the network.
struct Received {
  struct Point {
    double at = 0.0;  // [s]
    Values q, qd, qdd, effort;
  };
  Names names;
  std::vector<Point> points;
  bool begins_later = false;  // it has a start time
};

Received received(const trajectory_msgs_msg_dds__JointTrajectory_& message) {
  Received result{copy(message.joint_names), {}, message.header.stamp.sec != 0 || message.header.stamp.nanosec != 0};
  for (std::uint32_t i = 0; i < message.points._length; ++i) {
    const auto& from = message.points._buffer[i];
    result.points.push_back({seconds(from.time_from_start), copy(from.positions), copy(from.velocities),
                             copy(from.accelerations), copy(from.effort)});
  }
  return result;
}

Received received(const trajectory_msgs::msg::JointTrajectory& message) {
  const auto& stamp = message.header().stamp();
  Received result{message.joint_names(), {}, stamp.sec() != 0 || stamp.nanosec() != 0};
  for (const auto& from : message.points()) {
    result.points.push_back({from.time_from_start().sec() + 1e-9 * from.time_from_start().nanosec(), from.positions(),
                             from.velocities(), from.accelerations(), from.effort()});
  }
  return result;
}

/// Throws a sentence for a trajectory that the controller refuses. Its points in the order of `joints`.
std::vector<Point> accepted_points(const Received& message, const Names& joints) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::runtime_error(what);
  };
  const Names& names = message.names;
  require(!names.empty(), "no joint names");
  require(
      std::set(names.begin(), names.end()) == std::set(joints.begin(), joints.end()) && names.size() == joints.size(),
      "other joints, or a part of them (allow_partial_joints_goal is false)");
  require(!message.points.empty(), "an empty trajectory");
  std::vector<Point> points;
  for (const Received::Point& from : message.points) {
    const auto fits = [&](const Values& values) { return values.empty() || values.size() == names.size(); };
    require(from.q.size() == names.size(), "a point without all positions");
    require(fits(from.qd) && fits(from.qdd) && from.effort.empty(), "wrong sizes of a point");
    Point point{from.at, Values(names.size()), {}};
    require(points.empty() || point.at > points.back().at, "times do not increase");
    if (!from.qd.empty()) point.qd.resize(names.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto place = static_cast<std::size_t>(std::find(names.begin(), names.end(), joints[j]) - names.begin());
      point.q[j] = from.q[place];
      if (!point.qd.empty()) point.qd[j] = from.qd[place];
    }
    points.push_back(std::move(point));
  }
  const Values& last = points.back().qd;
  require(std::all_of(last.begin(), last.end(), [](double v) { return std::abs(v) <= 1e-12; }),
          "the last point has a velocity (allow_nonzero_velocity_at_trajectory_end is false)");
  require(!message.begins_later, "a start time: not simulated");
  return points;
}

// --- the robot

class Robot {
 public:
  explicit Robot(Options options) : options_(std::move(options)) {
    q_ = options_.start;
    q_.resize(options_.joints.size(), 0.0);
    qd_.assign(q_.size(), 0.0);
    command_.assign(q_.size(), kNone);
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
    move_finger(dt);
    if (node_) publish();
  }

  Json order(const std::string& line) {
    std::istringstream words(line);
    std::string name;
    std::string value;
    words >> name >> value;
    if (name == "forget") {
      first_ = largest_ = fastest_ = 0.0;
      counted_ = refused_ = 0;
    } else if (name == "silence") {  // joint states stop
      silent_ = value == "on";
    } else if (name == "restart") {  // all nodes end, and begin again after some seconds
      stop();
      off_until_ = Steady::now() + std::chrono::duration_cast<Steady::duration>(
                                       std::chrono::duration<double>(value.empty() ? 1.0 : std::stod(value)));
    } else if (name == "deactivate") {  // ros2 control set_controller_state … inactive
      active_ = false;
      drop_command();
      end_goal(test::TrajectoryServer::kCanceled, kInvalidGoal, "Current goal cancelled during deactivate transition.");
    } else if (name == "activate") {
      active_ = true;
      drop_command();
    } else if (name == "unload") {  // the controller ends, its manager goes on
      active_ = false;
      drop_command();
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
      object_ = value == "none" ? std::nullopt : std::optional(std::stod(value));
    } else if (name == "gripper") {  // its controller is active: on or off
      gripper_active_ = value == "on";
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
      action_ = std::make_unique<test::TrajectoryServer>(options_.domain, controller + "/follow_joint_trajectory");
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
    const std::string gripper = options_.ns + "/gripper_controller";
    if (options_.gripper == "action") {
      gripper_ = std::make_unique<test::GripperServer>(options_.domain, gripper + "/gripper_cmd");
    } else if (options_.gripper == "position") {
      gripper_commands_ = node_->reader(gripper + "/commands", std_msgs_msg_dds__Float64MultiArray__desc);
    }
    active_ = true;
    drop_command();
  }
  void stop() {
    active_ = false;
    drop_command();
    node_.reset();
    action_.reset();
    gripper_.reset();
    commands_ = gripper_commands_ = 0;
  }
  /// The controller holds the arm where it is.
  void drop_command() {
    trajectory_.reset();
    desired_.reset();
    command_ = q_;
  }

  void read_commands() {
    serve_gripper();
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
    note(copy(message.data));
    command_ = copy(message.data);
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
      end_goal(test::TrajectoryServer::kAborted, abort_->first, abort_->second);
      abort_.reset();
    }
    if (trajectory_ && trajectory_->at >= trajectory_->points.back().at) {
      end_goal(test::TrajectoryServer::kSucceeded, 0, "Goal successfully reached!");
    }
  }

  void serve_gripper() {
    if (gripper_) {
      const auto stopped = [&](bool stalled, bool reached) {
        control_msgs::action::GripperCommand_Result result;
        result.position(finger_);
        result.stalled(stalled);
        result.reached_goal(reached);
        return result;
      };
      gripper_->serve(
          [&](const auto& request) {
            if (!gripper_active_) return false;
            order_finger(request.goal().command().position());
            effort_ = request.goal().command().max_effort();
            return true;
          },
          stopped(false, false), [&] { return stopped(false, false); });
      // As the controller without the parameter allow_stalling.
      if (std::abs(finger_ - finger_target_) < 1e-3) {
        gripper_->end(test::GripperServer::kSucceeded, stopped(false, true));
      } else if (finger_stands_ > 0.2) {
        gripper_->end(test::GripperServer::kAborted, stopped(true, false));
      }
    }
    if (gripper_commands_ != 0) {
      take_each<std_msgs_msg_dds__Float64MultiArray_>(gripper_commands_, [&](const auto& message) {
        if (gripper_active_ && message.data._length == 1) order_finger(message.data._buffer[0]);
      });
    }
  }
  void order_finger(double to) {
    finger_target_ = to;
    finger_stands_ = 0.0;
    ++gripper_orders_;
  }
  void move_finger(double dt) {
    constexpr double kSpeed = 0.1;  // [m/s]
    double next = finger_ + std::clamp(finger_target_ - finger_, -kSpeed * dt, kSpeed * dt);
    if (object_ && finger_ != *object_ && (finger_ - *object_) * (next - *object_) <= 0.0) {
      blocked_ = *object_ - finger_;
      next = *object_;
    } else if (object_ && finger_ == *object_ && (next - finger_) * blocked_ > 0.0) {
      next = finger_;  // the object is still there on that side; away from it the finger moves
    }
    finger_stands_ = next == finger_ ? finger_stands_ + dt : 0.0;
    finger_ = next;
  }
  /// The step from the last command, or from where the arm is.
  void note(const Values& target) {
    double step = 0.0;
    const Values& from = counted_ > 0 ? last_ : q_;
    for (std::size_t j = 0; j < q_.size(); ++j) step = std::max(step, std::abs(target[j] - from[j]));
    double& most = counted_ > 0 ? largest_ : first_;
    most = std::max(most, step);
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
    for (std::size_t j = 0; j < q_.size(); ++j) {
      const double step = (command_[j] - q_[j]) * (1.0 - std::exp(-dt / options_.lag));
      qd_[j] = step / dt;
      q_[j] += step;
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
        q.push_back(finger_);
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
            {"first", first_},
            {"largest", largest_},
            {"fastest", fastest_},
            {"commands", counted_},
            {"refused", refused_},
            {"refusal", refusal_},
            {"cancels", action_ ? action_->cancels : 0},
            {"finger", finger_},
            {"finger_target", finger_target_},
            {"effort", effort_},
            {"gripper_orders", gripper_orders_},
            {"scaling", on_controller_ * scaling_}};
  }

  static constexpr int kInvalidGoal = -1;

  struct Trajectory {
    std::vector<Point> points;
    std::optional<Point> before;
    double at = 0.0;
  };

  Options options_;
  std::unique_ptr<Node> node_;
  dds_entity_t states_ = 0, commands_ = 0, controller_state_ = 0, factor_ = 0, scaling_state_ = 0;
  std::unique_ptr<test::TrajectoryServer> action_;
  std::unique_ptr<test::GripperServer> gripper_;
  dds_entity_t gripper_commands_ = 0;
  std::optional<std::pair<int, std::string>> abort_;
  bool gripper_active_ = true;
  double finger_ = 0.05, finger_target_ = 0.05, finger_stands_ = 0.0, effort_ = -1.0;  // [m], [m], [s], [N]
  std::optional<double> object_;                                                       // [m]
  double blocked_ = 0.0;  // its sign: the direction in which the object stops the finger
  int gripper_orders_ = 0;
  std::optional<Steady::time_point> off_until_;
  bool active_ = false;
  bool silent_ = false, reversed_ = false, split_ = false;
  std::string unknown_, lacking_;
  Values q_, qd_, command_;
  std::optional<Trajectory> trajectory_;
  std::optional<Point> desired_;
  double on_controller_ = 1.0, scaling_ = 1.0;
  std::uint64_t cycles_ = 0;
  // What has been commanded since the order to forget.
  Values last_;
  double first_ = 0.0, largest_ = 0.0, fastest_ = 0.0;
  int counted_ = 0, refused_ = 0;
  std::string refusal_;
};

// --- orders

/// Lines from the standard input and from TCP.
class Orders {
 public:
  explicit Orders(const std::string& address) : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const int on = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_port = htons(kControlPort);
    ::inet_pton(AF_INET, address.c_str(), &own.sin_addr);
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 || ::listen(listener_, 5) != 0) {
      throw std::runtime_error("cannot listen on " + address + ": " + std::strerror(errno));
    }
    lines_[STDIN_FILENO];
  }

  /// Takes orders until then.
  void serve(Robot& robot, Steady::time_point until) {
    while (true) {
      std::vector<pollfd> files{{listener_, POLLIN, 0}};
      for (const auto& [file, text] : lines_) files.push_back({file, POLLIN, 0});
      const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Steady::now()).count();
      const timespec timeout{0, std::max<std::int64_t>(0, left)};
      if (::ppoll(files.data(), files.size(), &timeout, nullptr) <= 0) return;
      if (files.front().revents != 0) lines_[::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)];
      for (std::size_t i = 1; i < files.size(); ++i) {
        if (files[i].revents != 0) read(robot, files[i].fd);
      }
    }
  }

 private:
  void read(Robot& robot, int file) {
    char bytes[512];
    const ssize_t count = ::read(file, bytes, sizeof bytes);
    if (count <= 0) {
      if (file != STDIN_FILENO) ::close(file);
      lines_.erase(file);
      return;
    }
    std::string& text = lines_[file].append(bytes, static_cast<std::size_t>(count));
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1)) {
      std::string answer;
      try {
        answer = robot.order(text.substr(0, end)).dump() + "\n";
      } catch (const std::exception& error) {
        answer = Json{{"error", error.what()}}.dump() + "\n";
      }
      [[maybe_unused]] const auto written =
          ::write(file == STDIN_FILENO ? STDOUT_FILENO : file, answer.data(), answer.size());
    }
  }

  int listener_;
  std::map<int, std::string> lines_;
};

Names split(const std::string& text) {
  Names parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

Options read(const Names& words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= words.size()) throw std::runtime_error(word + " needs a value");
      return words[++i];
    };
    if (word == "--domain") {
      options.domain = std::stoi(value());
    } else if (word == "--namespace") {
      options.ns = value();
    } else if (word == "--controller") {
      options.controller = value();
    } else if (word == "--kind") {
      options.action = value() == "action";
      options.trajectory = options.action || words[i] == "trajectory";
    } else if (word == "--gripper") {
      options.gripper = value();
    } else if (word == "--finger") {
      options.finger = value();
    } else if (word == "--joints") {
      options.joints = split(value());
    } else if (word == "--others") {
      options.others = split(value());
    } else if (word == "--start") {
      for (const std::string& q : split(value())) options.start.push_back(std::stod(q));
    } else if (word == "--rate") {
      options.rate = std::stod(value());
    } else if (word == "--lag") {
      options.lag = std::stod(value());
    } else if (word == "--from-desired") {
      options.from_desired = true;
    } else if (word == "--no-velocity") {
      options.velocity = false;
    } else if (word == "--scaling-topic") {
      options.scaling_topic = value();
    } else if (word == "--key-hash") {
      ::setenv("CYCLONEDDS_URI", "<Internal><GenerateKeyhash>true</GenerateKeyhash></Internal>", 1);
    } else if (word == "--address") {
      options.address = value();
    } else {
      throw std::runtime_error("no option " + word);
    }
  }
  if (options.joints.empty()) throw std::runtime_error("--joints NAME,… is needed");
  if (options.controller.empty()) {
    options.controller = options.trajectory ? "joint_trajectory_controller" : "forward_position_controller";
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = read({argv + 1, argv + argc});
    Robot robot(options);
    Orders orders(options.address);
    std::printf("controller %s in domain %d, orders on %s\n", options.controller.c_str(), options.domain,
                options.address.c_str());
    std::fflush(stdout);
    const auto period = std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(1.0 / options.rate));
    for (auto due = Steady::now();;) {
      robot.cycle();
      due = std::max(due + period, Steady::now() - 10 * period);
      orders.serve(robot, due);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_controller: %s\n", error.what());
    return 1;
  }
}
