/// Parts of hecaton-ros2 without a running cell: encoding, robot descriptions, markers, names of nodes.

#include <cstring>
#include <filesystem>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/ros2/ros2PubSubTypes.h>

#include "planner/model/kinematics.hpp"
#include "planner/model/urdf_loader.hpp"
#include "services/ros2/cell_publisher.hpp"
#include "services/ros2/goal_reports.hpp"
#include "services/ros2/name_watch.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2/unreadable_log.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/ros2_messages/markers.hpp"
#include "tests/cell/ros2/ros_peer.hpp"
#include "tests/cell/ros2/three_puma.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/gripper_cell.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using planner::JointVector;
using ros2::Bytes;

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

// The fingers slide along y, apart from each other.
TEST(Ros2Fingers, AreWhereTheyAreMeasured) {
  const TemporaryFolder folder;
  const config::CellFile file = config::load_cell_file(write_gripper_cell(folder));
  ros2::CellView view(file.cell);
  bus::Sample<msg::ArmState> sample;
  sample.value.arm("north");
  sample.value.q({0.1, 0.2, 0.7});
  sample.value.qd({0.0, 0.0, 0.0});
  sample.received = bus::Clock::now();
  const auto frame = [&](const std::string& child) -> std::optional<ros2::Vector3> {
    for (const auto& transform : ros2::moving_transforms(view, sample.received).transforms) {
      if (transform.child_frame_id != child) continue;
      EXPECT_EQ(transform.header.frame_id, "north_hand");
      return transform.transform.translation;
    }
    return std::nullopt;
  };
  view.apply(sample);
  EXPECT_EQ(ros2::joint_states(view, sample.received).name.size(), 3U) << "the finger is not known";
  for (const double position : {0.01, 0.04}) {
    sample.value.outside({position});
    view.apply(sample);
    const ros2::JointState joints = ros2::joint_states(view, sample.received);
    EXPECT_EQ(joints.name.back(), "north_grip");
    EXPECT_EQ(joints.position.back(), position);
    EXPECT_EQ(joints.velocity.size(), joints.name.size());
    EXPECT_EQ(ros2::joint_state(view.arm(0)).name.back(), "grip");
    ASSERT_TRUE(frame("north_left") && frame("north_right"));
    EXPECT_NEAR(frame("north_left")->y, position, 1e-9);
    EXPECT_NEAR(frame("north_right")->y, -position, 1e-9) << "it follows the other one";
  }
  for (const auto& fixed : ros2::fixed_transforms(file.cell, {}).transforms) {
    EXPECT_FALSE(fixed.child_frame_id.ends_with("_left") || fixed.child_frame_id.ends_with("_right"));
  }
  const std::string urdf = ros2::arm_urdf(file.cell.arms[0].arm);
  EXPECT_NE(urdf.find("<box size=\"0.02 0.01 0.08\"/>"), std::string::npos) << "the finger itself, not all its places";
}

TEST(Ros2States, AreNotSentOnceTheDriverRepeatsItsLastMeasurement) {
  const config::CellFile file = three_puma();
  ros2::CellView view(file.cell);
  const planner::Arm& arm = file.cell.arms.front().arm;
  bus::Sample<msg::ArmState> sample;
  sample.value.arm(arm.name);
  sample.value.q({arm.home().begin(), arm.home().end()});
  sample.value.stamp_ns(1'000'000'000);
  const auto begin = bus::Clock::now();
  const auto hear = [&](std::chrono::milliseconds later) {
    sample.value.sequence_number(sample.value.sequence_number() + 1);
    sample.received = begin + later;
    view.apply(sample);
    return ros2::joint_states(view, sample.received);
  };
  EXPECT_FALSE(hear(0ms).name.empty());
  const auto stamp = view.time_at(begin);
  const ros2::JointState repeated = hear(20ms);
  EXPECT_FALSE(repeated.name.empty());
  const auto seconds = [](const ros2::Time& time) { return time.sec + 1e-9 * time.nanosec; };
  EXPECT_NEAR(seconds(repeated.header.stamp), seconds(stamp), 5e-3) << "its stamp is of the measurement";
  constexpr auto limit = 1000ms;
  EXPECT_TRUE(hear(limit + 20ms).name.empty());
  // A reader that begins later knows the age by the commands that the driver accepted since then.
  ros2::CellView later(file.cell);
  sample.value.mode(msg::ArmMode::ARM_FAILED);
  sample.value.command_age(-60.0);
  later.apply(sample);
  EXPECT_TRUE(ros2::joint_states(later, sample.received).name.empty());
  // It measures again.
  sample.value.mode(msg::ArmMode::ARM_STOPPED);
  sample.value.stamp_ns(1'000'000'000 + std::chrono::nanoseconds(limit + 40ms).count());
  EXPECT_FALSE(hear(limit + 40ms).name.empty());
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

TEST(Ros2Diagnostics, WarnOfTheNewestRefusal) {
  ros2::OrderReport report{.name = "planning scene", .applied = 3, .refused = 1, .unreadable = 7};
  EXPECT_EQ(ros2::diagnostic(report, "cell").level, ros2::level::kOk);
  report.refusal = "object 'crate': it is a cone";
  const auto entry = ros2::diagnostic(report, "cell");
  EXPECT_EQ(entry.level, ros2::level::kWarn);
  EXPECT_EQ(entry.message, "object 'crate': it is a cone");
  ASSERT_EQ(entry.values.size(), 3U);
  EXPECT_EQ(entry.values[0].value, "3");
  EXPECT_EQ(entry.values[2].key, "unreadable");
  EXPECT_EQ(entry.values[2].value, "7");
}

TEST(Ros2GoalReports, CountGoalsByTheFirstAnswerOfThePlanner) {
  ros2::GoalReports goals;
  const auto now = bus::Clock::now();
  std::optional<Progress> answer;
  const auto report = [&] { return answer; };
  goals.add(report, now);
  goals.update(now);
  EXPECT_EQ(goals.accepted() + goals.refused(), 0U) << "no planner has answered";
  answer.emplace();
  answer->state = GoalState::kRejected;
  answer->cause.text = "joint2 = 9 must be within [-2, 2]";
  goals.update(now);
  EXPECT_EQ(goals.refused(), 1U);
  EXPECT_EQ(goals.refusal(), "the planner rejects the goal: joint2 = 9 must be within [-2, 2]");
  goals.update(now);
  EXPECT_EQ(goals.refused(), 1U) << "once";
  answer->state = GoalState::kActive;
  goals.add(report, now);
  goals.update(now);
  EXPECT_EQ(goals.accepted(), 1U);
  EXPECT_FALSE(goals.refusal());
  goals.add(report, now);
  goals.refuse("goal_pose: frame_id = 'camera' must be world");
  goals.update(now);
  EXPECT_TRUE(goals.refusal()) << "it is newer than the accepted goal";
  goals.add(report, now);
  goals.update(now);
  EXPECT_FALSE(goals.refusal());
  answer.reset();
  goals.add(report, now);
  goals.update(now + 10s);
  EXPECT_FALSE(goals.refusal());
  goals.update(now + 11s);
  ASSERT_TRUE(goals.refusal());
  EXPECT_TRUE(goals.refusal()->starts_with("no planner has answered the goal for 10 s")) << *goals.refusal();
  for (std::size_t i = 0; i < 10 * ros2::GoalReports::kMost; ++i) goals.add(report, now);
  EXPECT_EQ(goals.refused(), 3U + 9 * ros2::GoalReports::kMost) << "a bounded number waits";
}

TEST(Ros2UnreadableLog, TellsOfAnEndpointOnceAMinute) {
  ros2::UnreadableLog log("/planning_scene", "moveit_msgs/msg/PlanningScene");
  const auto now = bus::Clock::now();
  EXPECT_TRUE(log.note(now));
  EXPECT_FALSE(log.note(now + 59s));
  EXPECT_TRUE(log.note(now + 60s));
  EXPECT_FALSE(log.note(now + 119s));
  EXPECT_EQ(log.count(), 4U);
}

/// The topic ros_discovery_info.
bus::ros2::Topic announcement_topic() {
  bus::ros2::Topic topic;
  topic.name = "ros_discovery_info";
  topic.type = "rmw_dds_common/msg/ParticipantEntitiesInfo";
  topic.transient_local = true;
  topic.depth = 1;
  topic.plain = true;
  return topic;
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
  const bus::ros2::Topic topic = announcement_topic();
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

TEST(Ros2NodeGraph, FallsSilentWhenANodeOfAnotherDistributionComesLater) {
  using config::Ros2Distribution;
  const FreeDomain domain;
  bus::Mailbox mailbox;
  bus::Participant participant(domain.number(), "/", bus::ros2::participant_options());
  bus::Participant other(domain.number(), "/", bus::ros2::participant_options());
  bus::Participant third(domain.number(), "/", bus::ros2::participant_options());
  const auto described = ros2::topic_of("/robot_description", ros2::type::kString, ros2::Delivery::kLatched);
  const bus::ros2::Writer own(participant, described);
  const ros2::NodeEndpoints endpoints{{}, {own.id()}};
  ros2::NodeGraph graph(participant, Ros2Distribution::kJazzy, {"/", "hecaton"}, endpoints, mailbox);
  const auto await = [&](const auto& happens) {
    const auto until = bus::Clock::now() + kLong;
    while (!happens() && bus::Clock::now() < until) static_cast<void>(mailbox.wait(100ms));
    return happens();
  };
  const auto take_one = [&](bus::ros2::Reader& reader) {
    std::vector<bus::ros2::Sample> samples;
    EXPECT_TRUE(await([&] {
      for (auto& sample : reader.take()) samples.push_back(std::move(sample));
      return !samples.empty();
    }));
    EXPECT_EQ(samples.size(), 1U);
    return samples.empty() ? Bytes() : samples.front().bytes;
  };
  graph.update(bus::Clock::now() + 10s);
  ASSERT_TRUE(graph.announced());
  bus::ros2::Reader before(third, announcement_topic(), mailbox);
  EXPECT_EQ(take_one(before), ros2::announcement(Ros2Distribution::kJazzy, {"/", "hecaton"}, endpoints));

  const bus::EndpointId foreign{{1, 2, 3}};
  const Bytes humble = ros2::announcement(Ros2Distribution::kHumble, {"/", "camera"}, {{}, {foreign}});
  bus::ros2::Writer writer(other, announcement_topic());
  writer.write(humble);
  EXPECT_TRUE(await([&] {
    graph.update(bus::Clock::now() + 10s);
    return graph.conflicting();
  }));
  EXPECT_FALSE(graph.announced());
  EXPECT_TRUE(await([&] { return before.matched() == 1; })) << "the writer of the announcement is still there";
  EXPECT_EQ(take_one(before), humble);
  // A node that comes later reads the other announcement alone.
  bus::ros2::Reader late(third, announcement_topic(), mailbox);
  EXPECT_EQ(take_one(late), humble);
  EXPECT_EQ(late.matched(), 1);
  graph.update(bus::Clock::now() + 100s);
  EXPECT_FALSE(graph.announced());
}

/// Publishes joint states of the cell until a peer has read many of them, or a time of /clock. True: it has read one.
bool has_clock(const config::CellFile& file) {
  constexpr std::size_t kStates = 200;
  const FreeDomain domain;
  bus::Participant participant(domain.number(), "/", bus::ros2::participant_options());
  ros2::CellPublisher publisher(file, participant);
  ros2::CellView view(file.cell);
  RosPeer peer(domain.number());
  PeerReader<rosgraph_msgs::msg::ClockPubSubType> clock(peer, "rt/clock", {false, false, 1});
  PeerReader<sensor_msgs::msg::JointStatePubSubType> states(peer, "rt/cell/joint_states");
  EXPECT_TRUE(clock.wait_matched() && states.wait_matched());
  bus::Sample<msg::ArmState> state;
  const planner::Arm& arm = file.cell.arms.front().arm;
  state.value.arm(arm.name);
  state.value.q({arm.home().begin(), arm.home().end()});
  std::size_t read = 0;
  bool clocked = false;
  const auto until = bus::Clock::now() + kLong;
  while (!clocked && read < kStates && bus::Clock::now() < until) {
    state.received = bus::Clock::now();
    view.apply(state);
    publisher.publish_states(view, state.received);
    std::this_thread::sleep_for(5ms);
    read += states.take().size();
    clocked = !clock.take().empty();
  }
  EXPECT_TRUE(clocked || read >= kStates) << "only " << read << " joint states were read";
  return clocked;
}

TEST(Ros2Clock, IsSentWhenAllDevicesAreSimulated) {
  config::CellFile file = three_puma();
  file.ros2.emplace().ns = "/cell";
  EXPECT_TRUE(has_clock(file));
}

TEST(Ros2Clock, IsNotSentBesideARobot) {
  config::CellFile file = three_puma();
  file.ros2.emplace().ns = "/cell";
  file.devices.at(1).type = "universal_robots";
  EXPECT_FALSE(has_clock(file));
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
