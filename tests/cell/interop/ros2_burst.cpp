/// The publisher of hecaton-ros2 with random states of a cell instead of a cell, far faster than a cell: for decoders
/// of other vendors.
///
/// usage: ros2_burst CELL
///
/// It publishes all topics, replies of the services and the action, and the announcements of nodes 200 times a second
/// in the domain ros2.domain of the cell file, until it is ended. A cell leaves many fields of its messages empty: the
/// topics /random/… have messages of the same types with random values in each field.

#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "planner/local/random.hpp"
#include "planner/model/convex_hull.hpp"
#include "services/bus/ros2_endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/messages/convert.hpp"
#include "services/ros2/cell_publisher.hpp"
#include "services/ros2/node_graph.hpp"
#include "tests/cell/interop/random_message.hpp"
#include "tests/cell/interop/ros2_json.hpp"

namespace {

using namespace hecaton;

constexpr std::chrono::milliseconds kPeriod{5};

class RandomCell {
 public:
  explicit RandomCell(const std::string& path) : file_(config::load_cell_file(path)), view_(file_.cell) {}

  [[nodiscard]] const config::CellFile& file() const { return file_; }
  [[nodiscard]] ros2::CellView& view() { return view_; }

  /// New states of everything; also other bases of the arms.
  void change() {
    ++number_;
    for (planner::PlannedArm& planned : file_.cell.arms) {
      planned.arm.X_WB = pose();
      view_.apply(received(state(planned.arm)));
      view_.apply(received(goal(planned.arm)));
      view_.apply(received(motion(planned.arm)));
    }
    view_.apply(received(obstacles()));
  }
  [[nodiscard]] std::vector<ros2::OrderedPath> paths() {
    std::vector<ros2::OrderedPath> all;
    for (const planner::PlannedArm& planned : file_.cell.arms) {
      ros2::OrderedPath path{planned.arm.name, {}};
      for (int i = count(20); i >= 0; --i) path.points.push_back(joints(planned.arm));
      all.push_back(path);
    }
    return all;
  }
  [[nodiscard]] CellStatus status() {
    CellStatus status;
    status.cell = file_.cell.name;
    status.mode = count(2) == 0 ? CellMode::kRun : CellMode::kHold;
    status.cause = {CauseKind::kHoldOrdered, text(), text()};
    for (int i = count(12); i > 0; --i) {
      NodeStatus& node = status.nodes.emplace_back();
      node.name = text();
      node.host = text();
      node.state = static_cast<NodeState>(count(3));
      node.alive = count(2) == 0;
      node.cause = {CauseKind::kNone, "", count(2) == 0 ? "" : text()};
      node.age = Seconds(random_.uniform(-1.0, 100.0));
    }
    for (int i = count(6); i > 0; --i) {
      status.faults.push_back(
          {text(), static_cast<Severity>(count(3)), {CauseKind::kHoldOrdered, text(), text()}, count(2) == 0});
    }
    return status;
  }
  [[nodiscard]] ros2::OrderReport orders() {
    ros2::OrderReport report{text(), random_.next() % 1000, random_.next() % 1000, {}};
    if (count(2) == 0) report.refusal = text();
    return report;
  }

 private:
  template <class T>
  static bus::Sample<T> received(T value) {
    bus::Sample<T> sample;
    sample.value = std::move(value);
    sample.received = bus::Clock::now();
    return sample;
  }
  int count(int below) { return test::random_count(random_, below); }  ///< 0 to `below` − 1
  double number() { return test::random_number(random_); }
  std::string text() { return test::random_text(random_); }
  world::Pose pose() {
    world::Pose X;
    X.translation() = Eigen::Vector3d(number(), number(), number());
    X.linear() = Eigen::Quaterniond(random_.normal(), random_.normal(), random_.normal(), random_.normal())
                     .normalized()
                     .toRotationMatrix();
    return X;
  }
  planner::JointVector joints(const planner::Arm& arm) {
    return planner::JointVector::NullaryExpr(arm.model->joints(), [&] { return random_.uniform(-3.0, 3.0); });
  }

  world::Shape hull() {
    std::vector<Eigen::Vector3d> points(static_cast<std::size_t>(4 + count(20)));
    for (auto& point : points) point = Eigen::Vector3d(random_.normal(), random_.normal(), random_.normal());
    return world::Convex{std::make_shared<const world::ConvexHull>(planner::convex_hull(points).value())};
  }

  msg::ArmState state(const planner::Arm& arm) {
    msg::ArmState state;
    state.arm(arm.name);
    state.mode(static_cast<msg::ArmMode>(count(4)));
    state.q(messages::to_message(joints(arm)));
    for (int j = 0; j < arm.model->joints(); ++j) state.qd().push_back(number());
    state.carried(text());
    state.cause().text(text());
    return state;
  }
  msg::GoalStatus goal(const planner::Arm& arm) {
    msg::GoalStatus goal;
    goal.arm(arm.name);
    goal.sequence_number(number_);
    goal.stamp_ns(static_cast<std::int64_t>(number_));
    goal.goal(text());
    goal.state(count(2) == 0 ? msg::GoalState::GOAL_ACTIVE : msg::GoalState::GOAL_BLOCKED);
    goal.cause().kind(static_cast<msg::CauseKind>(count(10)));
    goal.cause().text(text());
    goal.has_binding(count(4) > 0);
    goal.binding_own(arm.name + "/" + arm.model->links.back().name);
    goal.binding_other(count(2) == 0 ? "o0" : text());
    goal.binding_distance(number());
    goal.distance_to_goal(number());
    goal.blocked_duration(number());
    if (count(8) > 0) goal.q_goal(messages::to_message(joints(arm)));
    return goal;
  }
  msg::ObstacleStates obstacles() {
    msg::ObstacleStates states;
    for (int i = count(6); i >= 0; --i) {
      world::Obstacle obstacle;
      obstacle.name = "o" + std::to_string(i);
      for (int k = count(3); k >= 0; --k) {
        world::PlacedShape& placed = obstacle.shapes.emplace_back();
        const auto size = [&] { return random_.uniform(0.01, 2.0); };
        switch (count(5)) {
          case 0:
            placed.shape = world::Sphere{size()};
            break;
          case 1:
            placed.shape = world::Box{{size(), size(), size()}};
            break;
          case 2:
            placed.shape = world::Cylinder{size(), size()};
            break;
          case 3:
            placed.shape = world::Capsule{size(), size()};
            break;
          default:
            placed.shape = hull();
        }
        placed.X_BS = pose();
      }
      obstacle.X_WO = pose();
      view_.set_shapes(obstacle.name, messages::to_message(obstacle));
      msg::ObstacleState& state = states.states().emplace_back();
      state.name(obstacle.name);
      state.X_WO(messages::to_message(obstacle.X_WO));
    }
    return states;
  }
  msg::PlannedMotion motion(const planner::Arm& arm) {
    msg::PlannedMotion motion;
    motion.arm(arm.name);
    for (int i = count(10); i > 0; --i) {
      for (const double q : joints(arm)) motion.way().push_back(q);
    }
    return motion;
  }

  config::CellFile file_;
  ros2::CellView view_;
  planner::Random random_{1};
  std::uint64_t number_ = 0;
};

/// The action and the orders of one arm, messages of the types that show a cell, and announcements of nodes. The
/// replies answer no request.
class RandomAnswers {
 public:
  RandomAnswers(bus::Participant& participant, const std::string& arm)
      : action_(arm + "/follow_joint_trajectory/_action/"),
        send_goal_(participant, ros2::service_of(action_ + "send_goal", ros2::type::kSendTrajectory), mailbox_),
        cancel_goal_(participant, ros2::service_of(action_ + "cancel_goal", ros2::type::kCancelGoal), mailbox_),
        get_result_(participant, ros2::service_of(action_ + "get_result", ros2::type::kTrajectoryResult), mailbox_),
        stop_(participant, ros2::service_of(arm + "/stop", ros2::type::kTrigger), mailbox_),
        feedback_(participant, action_ + "feedback", ros2::type::kTrajectoryFeedback),
        status_(participant, action_ + "status", ros2::type::kGoalStatuses, ros2::Delivery::kLatched),
        joint_states_(participant, "/random/joint_states", ros2::type::kJointState),
        transforms_(participant, "/random/transforms", ros2::type::kTransforms),
        diagnostics_(participant, "/random/diagnostics", ros2::type::kDiagnostics),
        markers_(participant, "/random/markers", ros2::type::kMarkers),
        jazzy_(participant, announcement_topic("msg")),
        humble_(participant, announcement_topic("humble")) {}

  void publish() {
    reply<ros2::SendGoalResponse>(send_goal_);
    reply<ros2::CancelGoalResponse>(cancel_goal_);
    reply<ros2::GetResultResponse>(get_result_);
    reply<ros2::TriggerResponse>(stop_);
    feedback_.publish(draw<ros2::FeedbackMessage>());
    status_.publish(draw<ros2::GoalStatusArray>());
    joint_states_.publish(draw<ros2::JointState>());
    transforms_.publish(draw<ros2::TFMessage>());
    diagnostics_.publish(draw<ros2::DiagnosticArray>());
    markers_.publish(draw<ros2::MarkerArray>());
    // Each part of an announcement shows what it is: a namespace begins with a slash, an identifier has its kind.
    const ros2::NodeGraph::Node node{"/" + test::random_text(random_), "node " + test::random_text(random_)};
    ros2::NodeEndpoints endpoints{{}, {endpoint(kWriter)}};
    for (int i = test::random_count(random_, 20); i > 0; --i) endpoints.readers.push_back(endpoint(kReader));
    for (int i = test::random_count(random_, 20); i > 0; --i) endpoints.writers.push_back(endpoint(kWriter));
    jazzy_.write(ros2::announcement(config::Ros2Distribution::kJazzy, node, endpoints));
    humble_.write(ros2::announcement(config::Ros2Distribution::kHumble, node, endpoints));
  }

 private:
  /// Of the topic ros_discovery_info or, for Humble, of one of another name: a topic has one type.
  static bus::ros2::Topic announcement_topic(const std::string& folder) {
    bus::ros2::Topic topic;
    topic.name = folder == "msg" ? "ros_discovery_info" : "ros_discovery_info_" + folder;
    topic.type = "rmw_dds_common/" + folder + "/ParticipantEntitiesInfo";
    topic.transient_local = true;
    topic.depth = 1;
    topic.plain = true;
    return topic;
  }
  // The last byte of an identifier: RTPS 2.2, section 9.3.1.2.
  static constexpr std::uint8_t kWriter = 0x03;
  static constexpr std::uint8_t kReader = 0x04;
  bus::EndpointId endpoint(std::uint8_t kind) {
    bus::EndpointId id;
    for (auto& byte : id.bytes) byte = static_cast<std::uint8_t>(random_.next());
    id.bytes.back() = kind;
    return id;
  }
  /// Hecaton's decoder must give back each member: ros2_values takes from it what was published.
  template <class Message>
  Message draw() {
    Message message = values_.draw<Message>();
    const auto again = ros2::decoded<Message>(ros2::encoded(message));
    if (!again || nlohmann::json(*again) != nlohmann::json(message)) {
      throw std::runtime_error("a message is decoded to other values: " + nlohmann::json(message).dump());
    }
    return message;
  }
  template <class Response>
  void reply(bus::ros2::Server& server) {
    // A client with a writer's identifier: the reply waits for no reader of the client.
    const bus::ros2::RequestId request{endpoint(kWriter), static_cast<std::int64_t>(random_.next() >> 1U)};
    server.reply(request, ros2::encoded(draw<Response>()));
  }

  planner::Random random_{2};
  test::RandomMessage values_{random_};
  bus::Mailbox mailbox_;
  std::string action_;
  bus::ros2::Server send_goal_;
  bus::ros2::Server cancel_goal_;
  bus::ros2::Server get_result_;
  bus::ros2::Server stop_;
  ros2::Publisher<ros2::FeedbackMessage> feedback_;
  ros2::Publisher<ros2::GoalStatusArray> status_;
  ros2::Publisher<ros2::JointState> joint_states_;
  ros2::Publisher<ros2::TFMessage> transforms_;
  ros2::Publisher<ros2::DiagnosticArray> diagnostics_;
  ros2::Publisher<ros2::MarkerArray> markers_;
  bus::ros2::Writer jazzy_;
  bus::ros2::Writer humble_;
};

void publish(const std::string& path) {
  RandomCell cell(path);
  bus::Participant participant(cell.file().ros2->domain, "/", bus::ros2::participant_options());
  ros2::CellPublisher publisher(cell.file(), participant);
  RandomAnswers answers(participant, cell.file().ros2->ns + "/" + cell.file().cell.arms.front().arm.name);
  for (auto next = bus::Clock::now();; next += kPeriod) {
    cell.change();
    const auto now = bus::Clock::now();
    publisher.publish_descriptions();
    publisher.publish_states(cell.view(), now);
    publisher.publish_arm_status(cell.view(), now);
    publisher.publish_markers(cell.view(), cell.paths());
    const CellStatus status = cell.status();
    publisher.publish_diagnostics(&status, "", {cell.orders()});
    answers.publish();
    std::this_thread::sleep_until(next);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: ros2_burst CELL\n", stderr);
    return 2;
  }
  try {
    publish(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
