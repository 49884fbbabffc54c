/// Parts of hecaton-ros2 without a running cell: encoding, trajectories, names of nodes, robot descriptions.

#include <cstring>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <idl/ros2/ros2PubSubTypes.h>

#include "planner/model/kinematics.hpp"
#include "planner/model/urdf_loader.hpp"
#include "services/config/cell_file.hpp"
#include "services/ros2/action_checkpoint.hpp"
#include "services/ros2/name_watch.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2/trajectory.hpp"
#include "services/ros2/trajectory_server.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/ros2_messages/markers.hpp"
#include "tests/cell/ros2/ros_peer.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using planner::JointVector;
using ros2::Bytes;
using ros2::TrajectoryCode;
using ros2::TrajectoryFollower;

const config::CellFile& three_puma() {
  static const config::CellFile kFile = config::load_cell_file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
  return kFile;
}
const planner::Arm& northern_arm() {
  return three_puma().cell.arms[0].arm;
}

/// Encodes with the serialisation that fastddsgen has generated.
template <class PubSub>
Bytes generated_bytes(typename PubSub::type value) {
  PubSub type;
#if HECATON_FAST_DDS == 3
  rtps::SerializedPayload_t payload(type.calculate_serialized_size(&value, dds::XCDR_DATA_REPRESENTATION));
  EXPECT_TRUE(type.serialize(&value, payload, dds::XCDR_DATA_REPRESENTATION));
#else
  rtps::SerializedPayload_t payload(type.getSerializedSizeProvider(&value)());
  EXPECT_TRUE(type.serialize(&value, &payload));
#endif
  return {payload.data, payload.data + payload.length};
}

TEST(Ros2Encoding, AgreesWithTheGeneratedSerialisation) {
  ros2::JointState ours{{{12, 34}, "w"}, {"a", "joint_2"}, {1.5, -2.0}, {0.25}, {}};
  sensor_msgs::msg::JointState theirs;
  theirs.header().stamp().sec(12);
  theirs.header().stamp().nanosec(34);
  theirs.header().frame_id("w");
  theirs.name({"a", "joint_2"});
  theirs.position({1.5, -2.0});
  theirs.velocity({0.25});
  const Bytes bytes = ros2::encoded(ours);
  EXPECT_EQ(bytes, generated_bytes<sensor_msgs::msg::JointStatePubSubType>(theirs));
  const auto back = ros2::decoded<ros2::JointState>(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->name, ours.name);
  EXPECT_EQ(back->position, ours.position);

  ros2::MarkerLayer layer;
  layer.begin({1, 2});
  layer.add_text("north", "text", {1.0, 2.0, 3.0}, {0.1F, 0.2F, 0.3F, 0.4F});
  ros2::MarkerArray markers = layer.end();
  visualization_msgs::msg::MarkerArray array;
  array.markers().resize(2);
  for (auto& marker : array.markers()) {
    marker.header().stamp().sec(1);
    marker.header().stamp().nanosec(2);
    marker.header().frame_id("world");
    marker.pose().orientation().w(1.0);
  }
  array.markers()[0].action(3);
  auto& text = array.markers()[1];
  text.ns("north");
  text.type(9);
  text.pose().position().x(1.0);
  text.pose().position().y(2.0);
  text.pose().position().z(3.0);
  text.scale().z(markers.markers[1].scale.z);
  text.color().r(0.1F);
  text.color().g(0.2F);
  text.color().b(0.3F);
  text.color().a(0.4F);
  text.text("text");
  EXPECT_EQ(ros2::encoded(markers), generated_bytes<visualization_msgs::msg::MarkerArrayPubSubType>(array));
}

TEST(Ros2Encoding, AgreesWithTheGeneratedSerialisationOfPlanningScenes) {
  ros2::PlanningScene ours;
  ours.name = "diff";
  ours.allowed_collision_matrix.entry_values = {{{1, 0}}};
  ours.allowed_collision_matrix.default_entry_values = {1};
  ours.link_padding = {{"link", 0.5}};
  ours.is_diff = true;
  ros2::CollisionObject object;
  object.id = "crate";
  object.primitives = {{1, {0.1, 0.2, 0.3}, {{{1.0F, 2.0F, 3.0F}}}}};
  object.meshes = {{{{{0, 1, 2}}}, {{0.5, 0.25, 0.125}}}};
  object.planes = {{{1.0, 2.0, 3.0, 4.0}}};
  object.subframe_names = {"top"};
  object.operation = 2;
  ours.robot_state.attached_collision_objects = {{"flange", object, {"finger"}, {}, 1.5}};
  ours.world.collision_objects = {object};
  ours.world.octomap.octomap.data = {-1, 2};

  moveit_msgs::msg::PlanningScene theirs;
  theirs.name("diff");
  theirs.allowed_collision_matrix().entry_values().resize(1);
  theirs.allowed_collision_matrix().entry_values()[0].enabled({true, false});
  theirs.allowed_collision_matrix().default_entry_values({true});
  theirs.link_padding().resize(1);
  theirs.link_padding()[0].link_name("link");
  theirs.link_padding()[0].padding(0.5);
  theirs.is_diff(true);
  moveit_msgs::msg::CollisionObject other;
  other.id("crate");
  other.primitives().resize(1);
  other.primitives()[0].type(1);
  other.primitives()[0].dimensions({0.1, 0.2, 0.3});
  other.primitives()[0].polygon().points().resize(1);
  other.primitives()[0].polygon().points()[0].x(1.0F);
  other.primitives()[0].polygon().points()[0].y(2.0F);
  other.primitives()[0].polygon().points()[0].z(3.0F);
  other.meshes().resize(1);
  other.meshes()[0].triangles().resize(1);
  other.meshes()[0].triangles()[0].vertex_indices({0, 1, 2});
  other.meshes()[0].vertices().resize(1);
  other.meshes()[0].vertices()[0].x(0.5);
  other.meshes()[0].vertices()[0].y(0.25);
  other.meshes()[0].vertices()[0].z(0.125);
  other.planes().resize(1);
  other.planes()[0].coef({1.0, 2.0, 3.0, 4.0});
  other.subframe_names({"top"});
  other.operation(2);
  theirs.robot_state().attached_collision_objects().resize(1);
  auto& attached = theirs.robot_state().attached_collision_objects()[0];
  attached.link_name("flange");
  attached.object(other);
  attached.touch_links({"finger"});
  attached.weight(1.5);
  theirs.world().collision_objects({other});
  theirs.world().octomap().octomap().data({-1, 2});

  const Bytes bytes = ros2::encoded(ours);
  EXPECT_EQ(bytes, generated_bytes<moveit_msgs::msg::PlanningScenePubSubType>(theirs));
  const auto back = ros2::decoded<ros2::PlanningScene>(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(ros2::encoded(*back), bytes);
}

/// The 16 bytes that other vendors put between encapsulation and body; `fill`: their value.
Bytes with_foreign_header(Bytes bytes, std::uint8_t fill) {
  bytes.insert(bytes.begin() + 4, 16, fill);
  return bytes;
}

template <class Request>
void expect_foreign_requests_refused(const Request& request) {
  const Bytes bytes = ros2::encoded(request);
  EXPECT_TRUE(ros2::decoded<Request>(bytes));
  for (const int fill : {0, 1, 7, 255}) {
    EXPECT_FALSE(ros2::decoded<Request>(with_foreign_header(bytes, static_cast<std::uint8_t>(fill)))) << fill;
  }
}

TEST(Ros2Encoding, RefusesOtherSizesBeforeTakingMemory) {
  ros2::SendGoalRequest request;
  expect_foreign_requests_refused(request);
  request.goal.trajectory.joint_names = {"joint1"};
  expect_foreign_requests_refused(request);
  expect_foreign_requests_refused(ros2::TriggerRequest{});
  expect_foreign_requests_refused(ros2::CancelGoalRequest{});
  expect_foreign_requests_refused(ros2::GetResultRequest{});

  const Bytes trigger = ros2::encoded(ros2::TriggerRequest{});
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    Bytes noise(random() % 300);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? 255 : random());
    if (noise.size() >= 4) std::copy(trigger.begin(), trigger.begin() + 4, noise.begin());
    const auto message = ros2::decoded<ros2::SendGoalRequest>(noise);
    EXPECT_LE(message ? message->goal.trajectory.points.size() : 0U, noise.size());
  }
}

TEST(Ros2Reader, DropsTheOldestSamplesInExcessOfItsBytes) {
  constexpr std::size_t kSize = 1'000'000;
  constexpr std::uint8_t kSent = 20;
  const FreeDomain domain;
  bus::Mailbox mailbox;
  bus::Participant participant(domain.number(), "/", bus::ros2::participant_options());
  bus::ros2::Topic topic;
  topic.name = "/big";
  topic.type = "std_msgs/msg/String";
  bus::ros2::Reader reader(participant, topic, mailbox);
  RosPeer peer(domain.number());
  RawPeerType::name = "std_msgs::msg::dds_::String_";
  PeerWriter<RawPeerType> writer(peer, "rt/big", {true, false, kSent});
  ASSERT_TRUE(writer.wait_matched());
  for (std::uint8_t i = 1; i <= kSent; ++i) {
    writer.write(bus::RawBytes(kSize, i));
    ASSERT_TRUE(writer.wait_acknowledged());
  }
  const auto samples = reader.take();
  ASSERT_EQ(samples.size(), bus::ros2::Reader::kQueueBytes / kSize);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[samples.size() - 1 - i].bytes.at(0), kSent - i) << "the newest stay";
  }
  writer.write(bus::RawBytes(100, 7));
  ASSERT_TRUE(writer.wait_acknowledged());
  EXPECT_EQ(reader.take().size(), 1U);
}

TEST(Ros2Description, GivesTheKinematicsOfTheModel) {
  const TemporaryFolder folder;
  planner::UrdfOptions options;
  options.tool_link = northern_arm().model->links[static_cast<std::size_t>(northern_arm().model->tool_link)].name;
  options.allow_bare_links = true;
  const auto again = planner::load_urdf(folder.write("arm.urdf", ros2::arm_urdf(northern_arm())), options);
  ASSERT_EQ(again->joint_names, northern_arm().model->joint_names);
  JointVector q = JointVector::Zero(again->joints());
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = 0.1 * static_cast<double>(j + 1);
  planner::Kinematics ours;
  planner::Kinematics theirs;
  planner::forward_kinematics(*northern_arm().model, northern_arm().X_WB, q, ours);
  planner::forward_kinematics(*again, northern_arm().X_WB, q, theirs);
  const auto tool = [](const planner::RobotModel& model, const planner::Kinematics& kinematics) {
    return kinematics.X_WL[static_cast<std::size_t>(model.tool_link)].matrix().eval();
  };
  EXPECT_TRUE(tool(*northern_arm().model, ours).isApprox(tool(*again, theirs), 1e-6));
  const std::string cell = ros2::cell_urdf(three_puma().cell);
  for (const char* arm : {"north", "west", "east"}) {
    EXPECT_NE(cell.find("<joint name=\"" + std::string(arm) + "_joint1\" type=\"revolute\">"), std::string::npos);
  }
}

ros2::TrajectoryGoal ramp(const JointVector& q, double step, double seconds) {
  ros2::TrajectoryGoal goal;
  goal.trajectory.joint_names = northern_arm().model->joint_names;
  for (int i = 0; i <= 4; ++i) {
    ros2::JointTrajectoryPoint point;
    point.positions.assign(q.begin(), q.end());
    point.positions[0] += step * i / 4.0;
    point.velocities.assign(point.positions.size(), 0.0);
    point.time_from_start = ros2::ros_duration(seconds * i / 4.0);
    goal.trajectory.points.push_back(point);
  }
  return goal;
}

TrajectoryCode code_of(const ros2::TrajectoryGoal& goal, double age = 0.0) {
  const auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), age);
  const auto* refusal = std::get_if<ros2::TrajectoryRefusal>(&checked);
  EXPECT_TRUE(refusal == nullptr || !refusal->text.empty());
  return refusal == nullptr ? TrajectoryCode::kSuccessful : refusal->code;
}

TEST(Ros2Trajectory, IsRefusedWithTheCodeOfItsError) {
  const JointVector& home = northern_arm().home();
  const ros2::TrajectoryGoal good = ramp(home, 0.4, 2.0);
  EXPECT_EQ(code_of(good), TrajectoryCode::kSuccessful);
  auto goal = good;
  for (std::string& name : goal.trajectory.joint_names) name = "north_" + name;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kSuccessful);
  goal.trajectory.joint_names[1] = goal.trajectory.joint_names[0];
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidJoints);
  goal = good;
  goal.trajectory.joint_names.pop_back();
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidJoints);
  goal = good;
  goal.trajectory.points[2].time_from_start = goal.trajectory.points[1].time_from_start;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal = good;
  goal.trajectory.points[0].positions[0] += 0.2;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal) << "it begins away from the arm";
  goal = good;
  goal.trajectory.points[3].positions[2] = 99.0;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal = good;
  goal.trajectory.points[3].positions[2] = std::nan("");
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  goal = good;
  goal.trajectory.points.back().velocities[0] = 0.5;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal);
  EXPECT_EQ(code_of(ramp(home, 0.4, 0.2)), TrajectoryCode::kInvalidGoal) << "faster than the arm";
  goal = good;
  goal.trajectory.points.back().time_from_start.sec = 3601;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidGoal) << "longer than an hour";
  goal.trajectory.points.back().time_from_start.sec = 3600;
  EXPECT_EQ(code_of(goal), TrajectoryCode::kSuccessful);
  goal = good;
  goal.path_tolerance.push_back({"no_joint", 0.1, 0.0, 0.0});
  EXPECT_EQ(code_of(goal), TrajectoryCode::kInvalidJoints);
  EXPECT_EQ(code_of(good, 5.0), TrajectoryCode::kOldStamp);
  EXPECT_EQ(code_of(ros2::TrajectoryGoal{}), TrajectoryCode::kInvalidJoints);
}

TrajectoryFollower follower_of(const ros2::TrajectoryGoal& goal) {
  auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  return TrajectoryFollower(std::get<ros2::TrajectoryOrder>(std::move(checked)));
}

/// One that has come to `time` of the trajectory.
TrajectoryFollower::Input under_way(double time, double rate, std::string reason = {}) {
  return {northern_arm().home(), 0.01, TrajectoryFollower::GoalReport::kUnderWay, time, rate, std::move(reason)};
}

TEST(Ros2Trajectory, KeepsVelocitiesAndTolerancesOfItsPoints) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.path_tolerance.push_back({"joint2", 0.05, 0.0, 0.0});
  goal.path_tolerance.push_back({"joint3", -1.0, 0.0, 0.0});
  const auto checked = ros2::check_trajectory(goal, northern_arm(), northern_arm().home(), 0.0);
  const planner::TimedTrajectory& trajectory = std::get<ros2::TrajectoryOrder>(checked).trajectory;
  ASSERT_EQ(trajectory.points.size(), goal.trajectory.points.size());
  EXPECT_EQ(trajectory.duration(), 4.0);
  EXPECT_EQ(trajectory.points[2].qd.size(), northern_arm().home().size());
  EXPECT_EQ(trajectory.path_tolerance[1], 0.05);
  EXPECT_TRUE(std::isinf(trajectory.path_tolerance[2])) << "-1 erases a tolerance";
  EXPECT_TRUE(trajectory.has_path_tolerance());
}

TEST(Ros2Trajectory, HasTheTimeThatThePlannerReports) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
  EXPECT_FALSE(follower.update(under_way(1.0, 1.0)));
  EXPECT_NEAR(follower.time(), 1.0, 1e-9);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(follower.update(under_way(1.0, 1.0)));
  EXPECT_NEAR(follower.time(), 1.1, 1e-9) << "between two reports it is estimated";
  EXPECT_FALSE(follower.update(under_way(1.05, 0.0)));
  EXPECT_NEAR(follower.time(), 1.1, 1e-9) << "it never falls";
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(follower.update(under_way(1.2, 0.5)));
  EXPECT_LT(follower.time(), 1.5) << "without a report the estimate ends";
}

TEST(Ros2Trajectory, SucceedsWhenThePlannerHasReachedItsEnd) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
  TrajectoryFollower::Input input = under_way(4.0, 1.0);
  input.q = follower.order().trajectory.end();
  EXPECT_FALSE(follower.update(input));
  input.report = TrajectoryFollower::GoalReport::kReached;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful);
}

TEST(Ros2Trajectory, EndsWhenNoPlannerAnswersIt) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  TrajectoryFollower::Input input = under_way(0.0, 0.0);
  input.dt = 0.5;
  input.report = TrajectoryFollower::GoalReport::kUnanswered;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(follower.update(input)) << i;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kInvalidGoal);
  EXPECT_NE(end->text.find("no planner of the arm has answered the trajectory for 10 s"), std::string::npos)
      << end->text;

  TrajectoryFollower answered = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  EXPECT_FALSE(answered.update(input));
  input.report = TrajectoryFollower::GoalReport::kUnderWay;
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(answered.update(input)) << i;
}

TEST(Ros2Trajectory, EndsWhenItsPlannerFallsSilent) {
  TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 60.0));
  TrajectoryFollower::Input input = under_way(0.0, 0.0);
  input.dt = 0.5;
  for (int i = 0; i < 100; ++i) {  // a held arm goes on reporting
    input.reported = 0.1 * i;
    EXPECT_FALSE(follower.update(input)) << i;
  }
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(follower.update(input)) << i;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kInvalidGoal);
  EXPECT_NE(end->text.find("no planner of the arm has answered the trajectory for 10 s"), std::string::npos);
}

TEST(Ros2Markers, DeleteWhatANewReaderMayShowOfAnEarlierProcess) {
  ros2::MarkerLayer layer;
  const auto begins_anew = [&] {
    layer.begin({});
    layer.add_text("arm", "north", {0.0, 0.0, 1.0}, {});
    const auto& markers = layer.end().markers;
    return markers.front().action == ros2::marker::kDeleteAll && markers.size() == 2;
  };
  EXPECT_TRUE(begins_anew());
  EXPECT_FALSE(begins_anew());
  layer.welcome();
  EXPECT_TRUE(begins_anew());
  EXPECT_FALSE(begins_anew());
}

TEST(Ros2CancellationWait, EndsWithItsGoalOrAfterASilenceOfThePlanner) {
  ros2::CancellationWait over;
  EXPECT_FALSE(over.update({.dt = 0.5, .reported = 1.0}));
  EXPECT_EQ(over.update({.dt = 0.5, .over = true, .reported = 1.5}), "canceled by its client");

  ros2::CancellationWait silent;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(silent.update({.dt = 0.5, .reported = 0.1 * i})) << i;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(silent.update({.dt = 0.5, .reported = 9.9})) << i;
  const auto end = silent.update({.dt = 0.5, .reported = 9.9});
  ASSERT_TRUE(end);
  EXPECT_NE(end->find("no planner of the arm has confirmed it for 10 s"), std::string::npos) << *end;
}

TEST(Ros2Trajectory, EndsOutsideItsGoalTolerance) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_tolerance.push_back({"joint1", 0.001, 0.0, 0.0});
  TrajectoryFollower follower = follower_of(goal);
  TrajectoryFollower::Input input = under_way(4.0, 1.0);
  input.q = follower.order().trajectory.end();
  input.q[0] += 0.002;
  input.report = TrajectoryFollower::GoalReport::kReached;
  const auto end = follower.update(input);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_EQ(end->text, "joint joint1 ends 0.002 from the goal (tolerance 0.001)");
}

TEST(Ros2Trajectory, EndsWhenItsTimeToleranceIsOver) {
  auto goal = ramp(northern_arm().home(), 0.8, 4.0);
  goal.goal_time_tolerance = {1, 0};
  TrajectoryFollower follower = follower_of(goal);
  double elapsed = 0.0;
  std::optional<ros2::TrajectoryRefusal> end;
  while (!end && elapsed < 60.0) {
    elapsed += 0.01;
    end = follower.update(under_way(2.0, 0.0, "ball is 0.03 m away"));
  }
  EXPECT_NEAR(elapsed, 5.0, 0.1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalTolerance);
  EXPECT_NE(end->text.find("ball is 0.03 m away"), std::string::npos);
}

TEST(Ros2Trajectory, EndsAsItsPlannerSays) {
  using Report = TrajectoryFollower::GoalReport;
  for (const auto& [report, code] : {std::pair(Report::kRejected, TrajectoryCode::kInvalidGoal),
                                     std::pair(Report::kLost, TrajectoryCode::kInvalidGoal),
                                     std::pair(Report::kLeftPath, TrajectoryCode::kPathTolerance)}) {
    TrajectoryFollower follower = follower_of(ramp(northern_arm().home(), 0.8, 4.0));
    TrajectoryFollower::Input input = under_way(1.0, 0.0, "ball is 0.03 m away");
    input.report = report;
    const auto end = follower.update(input);
    ASSERT_TRUE(end);
    EXPECT_EQ(end->code, code);
    EXPECT_NE(end->text.find("ball is 0.03 m away"), std::string::npos);
  }
}

TEST(Ros2ActionGoals, KeepResultsForLateClients) {
  ros2::ActionGoals goals;
  const ros2::ActionGoals::Id id{1, 2, 3};
  const auto now = bus::Clock::now();
  ASSERT_TRUE(goals.add(id, {5, 0}));
  EXPECT_FALSE(goals.add(id, {6, 0}));
  EXPECT_FALSE(goals.result(id)) << "the goal has not ended";
  goals.end(id, ros2::ActionGoals::kSucceeded, {0, "done"}, now);
  goals.forget_old(now + 14min);
  ASSERT_TRUE(goals.result(id));
  EXPECT_EQ(goals.result(id)->result.error_string, "done");
  goals.forget_old(now + 16min);
  EXPECT_EQ(goals.result(id)->status, ros2::ActionGoals::kUnknown);
}

// As rcl_action_process_cancel_request() answers.
TEST(Ros2ActionGoals, NameThoseThatACancellationMeans) {
  ros2::ActionGoals goals;
  const ros2::ActionGoals::Id none{};
  const ros2::ActionGoals::Id ended{1};
  const ros2::ActionGoals::Id running{2};
  const ros2::ActionGoals::Id later{3};
  const auto answer = [&](const ros2::ActionGoals::Id& id, const ros2::Time& stamp) {
    const auto response = goals.cancellable({{id}, stamp});
    std::vector<int> numbers;
    for (const auto& goal : response.goals_canceling) numbers.push_back(goal.goal_id.uuid[0]);
    return std::pair(int{response.return_code}, numbers);
  };
  using Answer = std::pair<int, std::vector<int>>;
  EXPECT_EQ(answer(none, {0, 0}), (Answer{0, {}}));
  EXPECT_EQ(answer(none, {9, 0}), (Answer{0, {}}));
  EXPECT_EQ(answer(running, {9, 0}), (Answer{0, {}}));
  EXPECT_EQ(answer(running, {0, 0}), (Answer{2, {}}));
  constexpr std::int32_t kSeconds = 1'800'000'000;
  ASSERT_TRUE(goals.add(ended, {5, 0}) && goals.add(running, {kSeconds, 7}) && goals.add(later, {kSeconds, 8}));
  goals.end(ended, ros2::ActionGoals::kSucceeded, {}, bus::Clock::now());
  EXPECT_EQ(answer(ended, {0, 0}), (Answer{3, {}}));
  EXPECT_EQ(answer(running, {0, 0}), (Answer{0, {2}}));
  EXPECT_EQ(answer(none, {0, 0}), (Answer{0, {2, 3}}));
  EXPECT_EQ(answer(none, {kSeconds, 6}), (Answer{0, {}}));
  EXPECT_EQ(answer(none, {kSeconds, 7}), (Answer{0, {2}})) << "to the nanosecond";
  EXPECT_EQ(answer(later, {kSeconds, 7}), (Answer{0, {2, 3}})) << "the goal, and all until then";
}

TEST(Ros2UnreadableLog, TellsOfAnEndpointOnceAMinute) {
  ros2::UnreadableLog log("/planning_scene", "moveit_msgs/msg/PlanningScene");
  const auto now = bus::Clock::now();
  EXPECT_TRUE(log.note(now));
  EXPECT_FALSE(log.note(now + 59s));
  EXPECT_TRUE(log.note(now + 60s));
  EXPECT_FALSE(log.note(now + 119s));
}

TEST(Ros2ActionGoals, AreTheSameAfterARestart) {
  const auto now = bus::Clock::now();
  ros2::ActionGoals before;
  const ros2::ActionGoals::Id done{1};
  const ros2::ActionGoals::Id under_way{2};
  ASSERT_TRUE(before.add(done, {5, 0}) && before.add(under_way, {6, 0}));
  before.end(done, ros2::ActionGoals::kAborted, {-4, "pushed"}, now - 10min);
  before.set_status(under_way, ros2::ActionGoals::kCanceling);
  ros2::ActionGoals after;
  after.restore(before.saved());
  EXPECT_EQ(after.info(under_way).stamp.sec, 6);
  EXPECT_EQ(after.status(under_way), ros2::ActionGoals::kCanceling);
  EXPECT_FALSE(after.result(under_way));
  ASSERT_TRUE(after.result(done));
  EXPECT_EQ(after.result(done)->result.error_string, "pushed");
  EXPECT_EQ(after.statuses().status_list.front().goal_info.goal_id.uuid, done);
  after.forget_old(now + 6min);
  EXPECT_FALSE(after.knows(done)) << "its age counts from its end";
}

TEST(Ros2ActionCheckpoint, KeepsWhatWasSavedLast) {
  const TemporaryFolder folder;
  const std::string path = folder.path("ros2-north");
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("north")) << "nothing is saved";
  ros2::SavedAction action{"north", {}, {{{{7}}, {8}, 9}}, {}};
  ros2::SavedTrajectory& active = action.active.emplace_back();
  active.goal = "client/host-1/2";
  active.order.trajectory.joint_names = {"joint1"};
  active.start = {0.5};
  active.begun_ns = 123;
  ros2::ActionCheckpoint checkpoint(path);
  checkpoint.save({"north", {}, {}, {}});
  checkpoint.save(action);
  const auto loaded = ros2::ActionCheckpoint(path).load("north");
  ASSERT_TRUE(loaded);
  EXPECT_EQ(encoded(*loaded), encoded(action));
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("west")) << "of another arm";
  std::filesystem::resize_file(path, 40);
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("north")) << "damaged";
  folder.write("ros2-north", "abc");
  EXPECT_FALSE(ros2::ActionCheckpoint(path).load("north")) << "damaged";
}

TEST(Ros2NodeGraph, IsSilentBesideNodesOfAnotherDistribution) {
  using config::Ros2Distribution;
  const ros2::NodeEndpoints endpoints{{}, {bus::EndpointId{{1, 2, 3}}}};
  const Bytes humble = ros2::announcement(Ros2Distribution::kHumble, {"/", "hecaton"}, endpoints);
  const Bytes jazzy = ros2::announcement(Ros2Distribution::kJazzy, {"/", "hecaton"}, endpoints);
  EXPECT_EQ(humble.size() - jazzy.size(), 16U) << "two identifiers, 8 bytes longer each";
  EXPECT_TRUE(ros2::is_of_other(Ros2Distribution::kHumble, jazzy));
  EXPECT_TRUE(ros2::is_of_other(Ros2Distribution::kJazzy, humble));
  EXPECT_FALSE(ros2::is_of_other(Ros2Distribution::kJazzy, jazzy));

  const FreeDomain domain;
  bus::Mailbox mailbox;
  bus::Participant participant(domain.number(), "/", bus::ros2::participant_options());
  bus::Participant other(domain.number(), "/", bus::ros2::participant_options());
  bus::ros2::Topic topic;
  topic.name = "ros_discovery_info";
  topic.type = "rmw_dds_common/msg/ParticipantEntitiesInfo";
  topic.transient_local = true;
  topic.depth = 1;
  topic.plain = true;
  bus::ros2::Writer writer(other, topic);
  writer.write(humble);
  bus::ros2::Writer own(participant, topic);
  ros2::NodeGraph graph(participant, Ros2Distribution::kJazzy, {"/", "hecaton"}, {{}, {own.id()}}, mailbox);
  const auto until = bus::Clock::now() + kLong;
  while (!graph.conflicting() && bus::Clock::now() < until) {
    static_cast<void>(mailbox.wait(1s));
    graph.update(bus::Clock::now());
  }
  EXPECT_TRUE(graph.conflicting());
  graph.update(bus::Clock::now() + 10s);
  EXPECT_FALSE(graph.announced());
}

TEST(Ros2NameWatch, TellsOnceOfAnotherNodeThatStays) {
  const FreeDomain domain;
  bus::Mailbox mailbox;
  bus::Participant participant(domain.number(), "/", bus::ros2::participant_options());
  bus::Participant other(domain.number(), "/", bus::ros2::participant_options());
  const auto topic = ros2::topic_of("/cell/robot_description", ros2::type::kString, ros2::Delivery::kLatched);
  bus::ros2::Writer own(participant, topic);
  ros2::NameWatch names(participant, "/cell", mailbox);
  const auto begin = bus::Clock::now();
  while (own.matched() < 1 && bus::Clock::now() < begin + kLong) static_cast<void>(mailbox.wait(100ms));
  EXPECT_FALSE(names.update(begin));
  EXPECT_FALSE(names.update(begin + 2 * ros2::NameWatch::kPatience)) << "its own writer";

  bus::ros2::Writer second(other, topic);
  while (second.matched() < 1 && bus::Clock::now() < begin + kLong) static_cast<void>(mailbox.wait(100ms));
  const auto seen = begin + 100s;
  // Discovery tells both sides, in any order.
  bool told = false;
  for (int i = 0; i < 600 && !told; ++i) {
    static_cast<void>(mailbox.wait(100ms));
    EXPECT_FALSE(names.update(seen)) << "it may be a process that was killed";
    told = names.update(seen + ros2::NameWatch::kPatience);
  }
  EXPECT_TRUE(told);
  EXPECT_FALSE(names.update(seen + 2 * ros2::NameWatch::kPatience)) << "once";
}

}  // namespace
}  // namespace hecaton::test
