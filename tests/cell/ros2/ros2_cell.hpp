#pragma once
/// A cell of three arms with hecaton-ros2 beside it, and a client of its actions that speaks ROS 2 on the wire.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hecaton/client.hpp>
#include <idl/ros2/ros2PubSubTypes.h>

#include "planner/model/kinematics.hpp"
#include "services/config/cell_file.hpp"
#include "tests/cell/cli/process.hpp"
#include "tests/cell/ros2/ros_peer.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {

using JointStates = PeerReader<sensor_msgs::msg::JointStatePubSubType>;
using SendGoal = PeerClient<control_msgs::action::FollowJointTrajectory_SendGoal_RequestPubSubType,
                            control_msgs::action::FollowJointTrajectory_SendGoal_ResponsePubSubType>;
using GetResult = PeerClient<control_msgs::action::FollowJointTrajectory_GetResult_RequestPubSubType,
                             control_msgs::action::FollowJointTrajectory_GetResult_ResponsePubSubType>;
using CancelGoal =
    PeerClient<action_msgs::srv::CancelGoal_RequestPubSubType, action_msgs::srv::CancelGoal_ResponsePubSubType>;
using Feedback = PeerReader<control_msgs::action::FollowJointTrajectory_FeedbackMessagePubSubType>;
using Statuses = PeerReader<action_msgs::msg::GoalStatusArrayPubSubType>;
using Result = control_msgs::action::FollowJointTrajectory_GetResult_Response;

inline constexpr int kSucceeded = 4;
inline constexpr int kCanceled = 5;
inline constexpr int kAborted = 6;

/// A client of the action FollowJointTrajectory of one arm.
class ActionClient {
 public:
  using Id = std::array<std::uint8_t, 16>;

  ActionClient(RosPeer& peer, const std::string& arm)
      : arm_(arm),
        base_("/cell/" + arm + "/follow_joint_trajectory/_action/"),
        send_(peer, base_ + "send_goal"),
        cancel_(peer, base_ + "cancel_goal"),
        result_(peer, base_ + "get_result"),
        feedback(peer, "rt" + base_ + "feedback"),
        statuses(peer, "rt" + base_ + "status", {true, true, 1}) {}

  bool wait_available() {
    return send_.wait_available() && cancel_.wait_available() && result_.wait_available() && feedback.wait_matched() &&
           statuses.wait_matched();
  }

  /// A trajectory in equal steps that ends with all joints of `q` moved by `delta`.
  control_msgs::action::FollowJointTrajectory_Goal ramp(const std::vector<double>& q, const std::vector<double>& delta,
                                                        double seconds) const {
    constexpr int kPoints = 10;
    control_msgs::action::FollowJointTrajectory_Goal goal;
    for (std::size_t j = 0; j < q.size(); ++j) {
      goal.trajectory().joint_names().push_back(arm_ + "_joint" + std::to_string(j + 1));
    }
    for (int i = 0; i <= kPoints; ++i) {
      trajectory_msgs::msg::JointTrajectoryPoint point;
      for (std::size_t j = 0; j < q.size(); ++j) point.positions().push_back(q[j] + delta[j] * i / kPoints);
      const double time = seconds * i / kPoints;
      point.time_from_start().sec(static_cast<std::int32_t>(time));
      point.time_from_start().nanosec(static_cast<std::uint32_t>(std::fmod(time, 1.0) * 1e9));
      goal.trajectory().points().push_back(point);
    }
    return goal;
  }

  /// As MoveIt sends it: positions and velocities each 0.1 s, at rest at both ends.
  control_msgs::action::FollowJointTrajectory_Goal smooth(const std::vector<double>& q, const std::vector<double>& to,
                                                          double seconds) const {
    const int points = static_cast<int>(std::ceil(10.0 * seconds));
    auto goal = ramp(q, std::vector<double>(q.size(), 0.0), seconds);
    goal.trajectory().points().clear();
    for (int i = 0; i <= points; ++i) {
      const double time = seconds * i / points;
      const double phase = M_PI * i / points;
      trajectory_msgs::msg::JointTrajectoryPoint point;
      for (std::size_t j = 0; j < q.size(); ++j) {
        const double half = 0.5 * (to[j] - q[j]);
        point.positions().push_back(q[j] + half * (1.0 - std::cos(phase)));
        point.velocities().push_back(half * M_PI / seconds * std::sin(phase));
      }
      point.time_from_start().sec(static_cast<std::int32_t>(time));
      point.time_from_start().nanosec(static_cast<std::uint32_t>(std::fmod(time, 1.0) * 1e9));
      goal.trajectory().points().push_back(point);
    }
    return goal;
  }

  /// A goal whose answer is awaited.
  struct Sent {
    Id id{};
    rtps::SampleIdentity request;
  };
  Sent begin_send(const control_msgs::action::FollowJointTrajectory_Goal& goal) {
    static std::atomic<std::uint32_t> count = 0;
    Sent sent;
    const std::uint32_t number = ++count;
    std::copy_n(reinterpret_cast<const std::uint8_t*>(&number), 4, sent.id.begin());
    sent.id[15] = static_cast<std::uint8_t>(arm_[0]);
    control_msgs::action::FollowJointTrajectory_SendGoal_Request request;
    request.goal_id().uuid(sent.id);
    request.goal(goal);
    sent.request = send_.send(request);
    return sent;
  }
  bool end_send(const Sent& sent) {
    const auto response = send_.receive(sent.request);
    return response && response->accepted();
  }
  std::optional<Id> send(const control_msgs::action::FollowJointTrajectory_Goal& goal) {
    const Sent sent = begin_send(goal);
    return end_send(sent) ? std::optional(sent.id) : std::nullopt;
  }
  /// Whether a goal of that identifier is accepted.
  bool send_again(const Id& id) {
    control_msgs::action::FollowJointTrajectory_SendGoal_Request request;
    request.goal_id().uuid(id);
    const auto response = send_.call(request);
    return response && response->accepted();
  }
  rtps::SampleIdentity ask_result(const Id& id) {
    control_msgs::action::FollowJointTrajectory_GetResult_Request request;
    request.goal_id().uuid(id);
    return result_.send(request);
  }
  std::optional<Result> await_result(const Id& id) { return result_.receive(ask_result(id)); }
  std::optional<Result> await_result(const rtps::SampleIdentity& asked, std::chrono::seconds limit = kLong) {
    return result_.receive(asked, limit);
  }
  /// `seconds`: of the stamp.
  rtps::SampleIdentity begin_cancel(const Id& id, std::int32_t seconds) {
    action_msgs::srv::CancelGoal_Request request;
    request.goal_info().goal_id().uuid(id);
    request.goal_info().stamp().sec(seconds);
    return cancel_.send(request);
  }
  std::optional<action_msgs::srv::CancelGoal_Response> end_cancel(const rtps::SampleIdentity& request) {
    return cancel_.receive(request);
  }
  std::optional<action_msgs::srv::CancelGoal_Response> ask_cancel(const Id& id, std::int32_t seconds) {
    return end_cancel(begin_cancel(id, seconds));
  }
  /// The server has the goals and cancellations that were sent.
  bool wait_received() { return send_.wait_received() && cancel_.wait_received(); }
  int cancel(const Id& id) {
    const auto response = ask_cancel(id, 0);
    return response ? response->return_code() : -1;
  }

 private:
  std::string arm_;
  std::string base_;
  SendGoal send_;
  CancelGoal cancel_;
  GetResult result_;

 public:
  Feedback feedback;
  Statuses statuses;
};

/// One cell for all tests. Every test leaves it in mode run.
class Ros2Cell : public testing::Test {
 protected:
  static void SetUpTestSuite() { start_cell(three_puma()); }
  static std::string three_puma() {
    std::ifstream file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Starts the cell of a file's text.
  static void start_cell(const std::string& text) {
    const TemporaryFolder& folder = *(folder_ = std::make_unique<TemporaryFolder>());
    std::filesystem::create_directory_symlink(std::string(HECATON_LIVE_CELLS) + "/urdf", folder.path() / "urdf");
    const std::string plain = folder.write("plain.yaml", text);
    cell_domain_ = std::make_unique<FreeDomain>();
    ros_domain_ = std::make_unique<FreeDomain>();
    const std::string domain = std::to_string(cell_domain_->number());
    cell_file_ = folder.write("cell.yaml", text + "\nros2: {domain: " + std::to_string(ros_domain_->number()) +
                                               ", namespace: /cell, control: true, distribution: jazzy}\n");
    const std::string programs = std::string(HECATON_BIN_DIR) + "/";
    up_ = std::make_unique<Process>(std::vector<std::string>{programs + "hecaton", "up", plain, "--headless",
                                                             "--domain", domain, "--start-timeout", "100s"});
    ASSERT_TRUE(up_->wait_for_message("the cell is up")) << up_->err();
    start_ros2();
    peer_ = std::make_unique<RosPeer>(ros_domain_->number());
    // Trajectories and attached objects of an arm are refused before its first state.
    for (const char* arm : {"north", "west", "east"}) {
      JointStates states(*peer_, std::string("rt/cell/") + arm + "/joint_states");
      ASSERT_TRUE(states.next([](const auto& message) { return !message.position().empty(); })) << arm;
    }
  }
  static void TearDownTestSuite() {
    peer_.reset();
    for (auto* process : {&ros2_, &up_}) {
      if (!*process) continue;
      (*process)->signal(SIGINT);
      EXPECT_EQ((*process)->wait(), 0) << (*process)->err();
      process->reset();
    }
    ros_domain_.reset();
    cell_domain_.reset();
    folder_.reset();
  }
  void TearDown() override {
    if (!HasFailure()) return;
    std::ifstream log(folder_->path("ros2.log"));
    std::cerr << std::string{std::istreambuf_iterator<char>(log), {}};
  }

  /// As the agent would start it.
  static void start_ros2() {
    ros2_ = std::make_unique<Process>(std::vector<std::string>{
        std::string(HECATON_BIN_DIR) + "/hecaton-ros2", cell_file_, "--domain", std::to_string(cell_domain_->number()),
        "--checkpoint", folder_->path("ros2"), "--log-file", folder_->path("ros2.log")});
  }
  /// The process of the planner of an arm.
  static pid_t planner_of(const std::string& arm) {
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      std::ifstream file(entry.path() / "cmdline");
      const std::string line{std::istreambuf_iterator<char>(file), {}};
      const auto has = [&](const std::string& words) { return line.find(words) != std::string::npos; };
      const std::string end(1, '\0');
      if (has("hecaton-planner") && has("--arm" + end + arm + end) &&
          has("--domain" + end + std::to_string(cell_domain_->number()) + end)) {
        return std::stoi(entry.path().filename().string());
      }
    }
    throw std::runtime_error("no planner of " + arm + " runs");
  }
  [[nodiscard]] static Cell connect() {
    ConnectOptions options;
    options.domain = cell_domain_->number();
    return Cell::connect(options, kLong);
  }
  [[nodiscard]] static std::vector<double> home(const Cell& cell, const std::string& arm) {
    EXPECT_TRUE(cell.arm(arm).go_to("home").wait(kLong));
    return cell.arm(arm).state(kLong).q;
  }

  /// Where the tool of an arm is at q.
  [[nodiscard]] static Pose tool_at(const std::string& arm, const std::vector<double>& q) {
    const config::CellFile file = config::load_cell_file(cell_file_);
    const auto found = std::find_if(file.cell.arms.begin(), file.cell.arms.end(),
                                    [&](const planner::PlannedArm& planned) { return planned.arm.name == arm; });
    planner::Kinematics kinematics;
    const planner::JointVector joints = Eigen::Map<const Eigen::VectorXd>(q.data(), std::ssize(q));
    planner::forward_kinematics(*found->arm.model, found->arm.X_WB, joints, kinematics);
    const Eigen::Vector3d p = kinematics.X_WT.translation();
    const Eigen::Quaterniond rotation(kinematics.X_WT.linear());
    return {{p.x(), p.y(), p.z()}, {rotation.w(), rotation.x(), rotation.y(), rotation.z()}};
  }
  /// `q` of `north` with joint 1 0.9 rad on, where an obstacle is now: small, so that it is clear of all arms.
  static std::vector<double> obstructed(const Cell& cell, std::vector<double> q) {
    q[0] += 0.9;
    cell.world().add("obstruction", Box{0.06, 0.06, 0.06}, tool_at("north", q), Static{}, kLong);
    return q;
  }

  /// Adds a ball that comes from above to where the tool of an arm is at q, and 50 mm deeper. It moves in time with the
  /// shuttle of the cell, which tells when the ball begins far above the arm.
  static void drop_stone(const Cell& cell, const std::string& name, const std::string& arm,
                         const std::vector<double>& q) {
    constexpr double kMiddle = 0.9;  // of the shuttle [m]
    constexpr Seconds kPeriod{10.0};
    const auto is_above = [&](Seconds limit) {
      const std::vector<ObstacleState> obstacles = cell.world().obstacles(limit);
      return std::any_of(obstacles.begin(), obstacles.end(), [&](const ObstacleState& obstacle) {
        return obstacle.name == "shuttle" && obstacle.pose.position.z < kMiddle;
      });
    };
    static_cast<void>(is_above(kLong));
    EXPECT_TRUE(cell.wait_until([&] { return is_above(Seconds::zero()); }, kLong));
    Pose above = tool_at(arm, q);
    above.position.z += 0.5;
    EXPECT_NO_THROW(cell.world().add(name, Sphere{0.05}, above, Sine{{0.0, 0.0, -0.55}, kPeriod}, kLong));
  }

  inline static std::unique_ptr<TemporaryFolder> folder_;
  inline static std::string cell_file_;
  inline static std::unique_ptr<FreeDomain> cell_domain_;
  inline static std::unique_ptr<FreeDomain> ros_domain_;
  inline static std::unique_ptr<Process> up_;
  inline static std::unique_ptr<Process> ros2_;
  inline static std::unique_ptr<RosPeer> peer_;
};

}  // namespace hecaton::test
