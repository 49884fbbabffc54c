// Writes the seeds that consist of messages into the folder of the corpora.
//
// usage: fuzz_seeds FOLDER

#include <cstdio>
#include <fstream>
#include <numbers>

#include "services/arm_driver/devices/universal_robots/rtde.hpp"
#include "services/bus/message_file.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/mcap_writer.hpp"
#include "services/recorder/message_schema.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "services/supervisor/replication/checkpoint.hpp"
#include "services/world/world_checkpoint.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/cdr.hpp"
#include "tests/support/rtps_datagram.hpp"

namespace hecaton::fuzz {
namespace {

using Buffer = std::vector<std::uint8_t>;

class Corpus {
 public:
  explicit Corpus(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void write(const std::string& target, const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories(folder_ / target);
    std::ofstream(folder_ / target / name, std::ios::binary) << bytes;
  }
  void write(const std::string& target, const std::string& name, std::uint8_t choice, const Buffer& bytes) const {
    write(target, name, std::string(1, static_cast<char>(choice)) + text_of(bytes));
  }

 private:
  std::filesystem::path folder_;
};

/// A sample that keeps its rules, with one element in each sequence and "a" in each text.
class SampleWriter {
 public:
  explicit SampleWriter(const bus::TopicRule& rule) { write(rule.sample); }
  [[nodiscard]] const Buffer& bytes() const { return bytes_; }

 private:
  template <class T>
  void put(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    const auto* raw = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof(T));
  }
  void text() {
    put(std::uint32_t{2});
    for (const char c : {'a', '\0'}) bytes_.push_back(static_cast<std::uint8_t>(c));
  }
  void write(const bus::StructRule& of) {
    for (const bus::FieldRule& field : of.fields) write(field);
  }
  void write(const bus::FieldRule& field) {
    using bus::FieldKind;
    switch (field.kind) {
      case FieldKind::kBool:
        return put(std::uint8_t{1});
      case FieldKind::kInt32:
        return put(std::int32_t{1});
      case FieldKind::kUint32:
      case FieldKind::kEnum:
        return put(static_cast<std::uint32_t>(field.low));
      case FieldKind::kInt64:
        return put(std::int64_t{1});
      case FieldKind::kUint64:
      case FieldKind::kTerm:
        return put(std::uint64_t{1});
      case FieldKind::kFloat:
        return put(0.5F);
      case FieldKind::kDouble:
        return put(0.5);
      case FieldKind::kName:
      case FieldKind::kText:
        return text();
      case FieldKind::kStruct:
        return write(*field.of);
      case FieldKind::kDoubles:
        put(std::uint32_t{1});
        return put(0.5);
      case FieldKind::kUint32s:
        put(std::uint32_t{1});
        return put(std::uint32_t{1});
      case FieldKind::kNames:
        put(std::uint32_t{1});
        return text();
      case FieldKind::kStructs:
        put(std::uint32_t{1});
        return write(*field.of);
    }
  }

  Buffer bytes_{0, 1, 0, 0};
};

const config::CellFile& cell() {
  static const config::CellFile kCell = config::load_cell_file(source("deploy/cells/three_puma.yaml"));
  return kCell;
}

std::vector<msg::Obstacle> obstacles() {
  std::vector<msg::Obstacle> all;
  for (const world::Obstacle& obstacle : cell().cell.scene.obstacles) all.push_back(messages::to_message(obstacle));
  world::ConvexHull hull;
  hull.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  hull.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  world::Obstacle wedge;
  wedge.name = "wedge";
  wedge.shapes = {{world::Convex{std::make_shared<const world::ConvexHull>(hull)}, world::Pose::Identity()},
                  {world::Capsule{0.1, 0.2}, world::Pose::Identity()},
                  {world::Cylinder{0.1, 0.2}, world::Pose::Identity()}};
  for (const world::Motion& motion :
       {world::Motion{world::StaticMotion{}}, world::Motion{world::CircleMotion{}}, world::Motion{world::SineMotion{}},
        world::Motion{world::ConveyorMotion{}}, world::Motion{world::DynamicMotion{}},
        world::Motion{world::WaypointMotion{{world::Pose::Identity(), world::Pose::Identity()}, 0.5, true}}}) {
    wedge.motion = motion;
    all.push_back(messages::to_message(wedge));
  }
  return all;
}

template <class T>
void write_samples(const Corpus& corpus) {
  std::uint8_t topic = 0;
  while (bus::kTopics[topic].type != bus::Topic<T>::kInfo.type) ++topic;
  const std::string name(bus::Topic<T>::kInfo.type);
  corpus.write("samples", name + "_empty", topic, test::cdr_of(T()));
  corpus.write("samples", name + "_full", topic, SampleWriter(*bus::topic_rule(name)).bytes());
  if constexpr (std::is_same_v<T, msg::DeviceState>) {
    corpus.write("device_state", "empty", text_of(test::cdr_of(T())));
    corpus.write("device_state", "full", text_of(SampleWriter(*bus::topic_rule(name)).bytes()));
  }
  if constexpr (std::is_same_v<T, msg::ObstacleShapes>) {
    int number = 0;
    for (const msg::Obstacle& obstacle : obstacles()) {
      T shapes;
      shapes.name(obstacle.name());
      shapes.obstacle(obstacle);
      corpus.write("samples", name + "_" + std::to_string(number++), topic, test::cdr_of(shapes));
    }
  }
}

void write_datagrams(const Corpus& corpus) {
  const auto stream = [&](const std::string& name, const std::vector<test::RtpsDatagram>& datagrams) {
    std::string bytes;
    for (const test::RtpsDatagram& datagram : datagrams) {
      bytes += static_cast<char>(datagram.bytes().size());
      bytes += static_cast<char>(datagram.bytes().size() >> 8U);
      bytes += text_of(datagram.bytes());
    }
    corpus.write("datagram", name, bytes);
  };
  using D = test::RtpsDatagram;
  stream("data", {D().data(1, {0, 1, 0, 0, 7}), D().data(2), D().data(9000)});
  stream("fragments", {D().fragment(1, 1, 1, 1000, 3000), D().fragment(1, 3, 1, 1000, 3000)});
  stream("control", {D().heartbeat(1, 8).acknowledgement(3, 40), D().gap(2, 5, 33)});
  stream("departure",
         {D().announcement({{0x70, 0x12345678}, {0x71, 3}}), D().announcement({}, 8), D().announcement({})});
  stream("others",
         {D().submessage(0x01, {0, 0}).submessage(0x09, {1, 2, 3, 4, 5, 6, 7, 8}).submessage(0x0C, Buffer(20, 0)),
          D().submessage(0x12, Buffer(28, 1)).submessage(0x13, Buffer(28, 1))});
}

std::string field(unsigned number, unsigned type, const std::string& value) {
  std::string bytes(1, static_cast<char>(number << 3U | type));
  if (type == 2) bytes += static_cast<char>(value.size());
  return bytes + value;
}

void write_egm(const Corpus& corpus) {
  const auto real = [](double value) { return field(1, 1, {reinterpret_cast<const char*>(&value), sizeof value}); };
  std::string joints;
  std::string packed;
  for (const double value : {0.0, -20.0, 30.0, 5.0, 10.0, 90.0}) {
    joints += real(value);
    packed.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  const std::string clock = field(1, 0, "\x05") + field(2, 0, "\x09");
  const std::string states = field(4, 2, field(1, 0, "\x01")) + field(5, 2, field(1, 0, "\x03")) + field(6, 0, "\x01") +
                             field(8, 2, field(1, 0, "\x02"));
  const std::string header = field(1, 2, field(1, 0, "\x07") + field(2, 0, "\x40"));
  corpus.write("abb_egm", "six_axes", header + field(2, 2, field(1, 2, joints)) + states);
  corpus.write(
      "abb_egm", "packed",
      header + field(2, 2, field(1, 2, field(1, 2, packed)) + field(3, 2, real(1200.0)) + field(4, 2, clock)) + states);
}

void write_rtde(const Corpus& corpus) {
  using namespace device::universal_robots;
  const std::string types = "DOUBLE,VECTOR6D,VECTOR6D,INT32,INT32,UINT32,DOUBLE,DOUBLE";
  std::string data(1, '\1');
  for (int i = 0; i < 13; ++i) put_f64(data, 0.25 * i);
  for (const std::uint32_t state : {7U, 1U, 2U}) put_u32(data, state);
  put_f64(data, 1.0);
  put_f64(data, 1.0);
  std::string version;
  for (const std::uint32_t part : {5U, 15U, 0U, 100U}) put_u32(version, part);
  const std::string begin = package(PackageType::kProtocolVersion, std::string(1, '\1')) +
                            package(PackageType::kControllerVersion, version) +
                            package(PackageType::kOutputs, "\1" + types);
  const std::string end = package(PackageType::kStart, std::string(1, '\1')) + package(PackageType::kData, data) +
                          package(PackageType::kText, std::string("\5hello\5robot\2"));
  corpus.write("ur_rtde", "without_slider", std::string(1, '\0') + begin + end);
  corpus.write("ur_rtde", "with_slider",
               std::string(1, '\1') + begin + package(PackageType::kInputs, "\1UINT32,DOUBLE") + end);
  corpus.write("ur_rtde", "not_found",
               std::string(1, '\0') + package(PackageType::kProtocolVersion, std::string(1, '\0')) +
                   package(PackageType::kControllerVersion, version) +
                   package(PackageType::kOutputs, types.substr(0, types.rfind(',')) + ",NOT_FOUND"));
}

void write_primary(const Corpus& corpus) {
  using namespace device::universal_robots;
  const auto sized = [](std::uint8_t type, const std::string& payload) {
    std::string bytes;
    put_u32(bytes, static_cast<std::uint32_t>(5 + payload.size()));
    put_u8(bytes, type);
    return bytes + payload;
  };
  std::string kinematics;
  for (std::uint32_t checksum = 1; checksum <= 6; ++checksum) put_u32(kinematics, checksum);
  for (int i = 0; i < 24; ++i) put_f64(kinematics, 0.25 * i);
  put_u32(kinematics, 1);
  const std::string modes = sized(0, std::string(42, '\1'));
  const std::string message = sized(20, std::string(12, '\3'));
  corpus.write("ur_primary", "kinematics", message + sized(16, modes + sized(5, kinematics)) + sized(16, modes));
  corpus.write("ur_primary", "truncated", sized(16, modes + sized(5, kinematics.substr(0, 200))));
  corpus.write("ur_primary", "modes", sized(16, modes) + sized(16, modes).substr(0, 20));
}

void write_ros2(const Corpus& corpus) {
  using namespace ros2;
  PlanningScene scene;
  scene.is_diff = true;
  CollisionObject box;
  box.header.frame_id = "world";
  box.id = "box";
  box.pose.orientation.w = 1.0;
  box.primitives = {{1, {0.1, 0.2, 0.3}, {}}, {2, {0.1}, {}}, {3, {0.4, 0.1}, {}}};
  CollisionObject mesh = box;
  mesh.id = "wedge";
  mesh.primitives.clear();
  mesh.meshes = {{{{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  AttachedCollisionObject attached;
  attached.link_name = "north_tool0";
  attached.object = box;
  scene.world.collision_objects = {box, mesh};
  scene.robot_state.attached_collision_objects = {attached};
  corpus.write("ros2", "scene", 0, encoded(scene));
  for (std::uint8_t operation = 1; operation < 4; ++operation) {
    scene.world.collision_objects[0].operation = operation;
    scene.robot_state.attached_collision_objects[0].object.operation = operation;
    corpus.write("ros2", "scene_" + std::to_string(operation), 0, encoded(scene));
  }
  const planner::Arm& arm = cell().cell.arms[0].arm;
  const planner::JointVector home = arm.home();
  SendGoalRequest request;
  request.goal.trajectory.joint_names = arm.model->joint_names;
  for (int i = 0; i < 3; ++i) {
    JointTrajectoryPoint point;
    for (const double q : home) point.positions.push_back(q + 0.01 * i);
    point.velocities.assign(point.positions.size(), 0.0);
    point.time_from_start.sec = i;
    request.goal.trajectory.points.push_back(point);
  }
  request.goal.path_tolerance = {{arm.model->joint_names[0], 0.1, 0.0, 0.0}};
  request.goal.goal_tolerance = {{arm.model->joint_names[1], 0.1, 0.0, 0.0}};
  request.goal.goal_time_tolerance.sec = 2;
  corpus.write("ros2", "trajectory", 1, encoded(request));
  PoseStamped pose;
  pose.header.frame_id = "world";
  pose.pose.orientation.w = 1.0;
  corpus.write("ros2", "pose", 2, encoded(pose));
  JointState joints;
  joints.name = arm.model->joint_names;
  joints.position.assign(home.begin(), home.end());
  corpus.write("ros2", "joints", 3, encoded(joints));
  corpus.write("ros2", "trigger", 4, encoded(TriggerRequest{}));
  corpus.write("ros2", "cancel", 5, encoded(CancelGoalRequest{}));
}

msg::ArmState arm_state() {
  msg::ArmState state;
  state.arm("north");
  state.sequence_number(1);
  state.q(std::vector<double>(6, 0.1));
  state.qd(std::vector<double>(6, 0.0));
  return state;
}

void write_ros2_control(const Corpus& corpus) {
  ros2::JointState states;
  states.header = {{1'700'000'000, 250'000'000}, "base_link"};
  states.name = {"finger", "wrist", "base", "elbow"};
  states.position = {9.0, 0.3, 0.1, 0.2};
  corpus.write("ros2_control", "positions", 4, encoded(states));
  states.velocity = {0.0, 0.3, 0.1, 0.2};
  corpus.write("ros2_control", "velocities", 4, encoded(states));
  corpus.write("ros2_control", "second_writer", 5, encoded(states));

  ros2::SendGoalResponse answer;
  answer.accepted = true;
  corpus.write("ros2_control_answers", "accepted", 0, encoded(answer));
  ros2::GetResultResponse result;
  result.status = 6;
  result.result = {-4, "elbow left its path"};
  corpus.write("ros2_control_answers", "aborted", 1, encoded(result));
  ros2::ActionResultResponse<ros2::GripperResult> grasp;
  grasp.status = 4;
  grasp.result.position = 0.02;
  grasp.result.stalled = true;
  corpus.write("ros2_control_answers", "grasped", 2, encoded(grasp));
  corpus.write("ros2_control_answers", "factor", 3, encoded(ros2::SpeedScalingFactor{0.5}));
  corpus.write("ros2_control_answers", "percent", 4, encoded(ros2::Float64{50.0}));
}

void write_recordings(const Corpus& corpus) {
  using namespace services::recorder;
  const auto schema_of = [](const char* type) { return std::string(message_schema(type)).substr(0, 200); };
  msg::Fault fault;
  fault.id("1/1");
  fault.term(1);
  msg::CellMode mode;
  mode.term(1);
  mode.node("supervisor");
  const std::vector<std::pair<std::string, Buffer>> messages{
      {"ArmState", test::cdr_of(arm_state())}, {"Fault", test::cdr_of(fault)}, {"CellMode", test::cdr_of(mode)}};
  const std::string withdrawn = R"({"topic":"hecaton/Fault","key":"1/1","writer":""})";
  const std::string report = R"({"cell":"three_puma","losses":{"hecaton/Fault":{"received":1}}})";
  // A chunk's records.
  Bytes records;
  const auto record = [&](Opcode opcode, const Bytes& body) {
    ByteWriter(records).number(static_cast<std::uint8_t>(opcode)).number(std::uint64_t{body.size()}).bytes(body);
  };
  const auto message = [&](std::uint16_t channel, std::uint64_t time, ByteSpan data) {
    Bytes body;
    ByteWriter(body).number(channel).number(std::uint32_t{1}).number(time).number(time).bytes(data);
    record(Opcode::kMessage, body);
  };
  const auto bytes_of = [](const std::string& text) { return Bytes(text.begin(), text.end()); };
  std::uint16_t number = 0;
  for (const auto& [type, data] : messages) {
    Bytes schema;
    ByteWriter(schema).number(++number).text("hecaton::msg::" + type).text("omgidl").text(schema_of(type.c_str()));
    record(Opcode::kSchema, schema);
    Bytes channel;
    ByteWriter(channel).number(number).number(number).text("hecaton/" + type).text("cdr");
    ByteWriter(channel).map(StringMap{{"writer", std::string(32, '0')}, {"node", "driver/north"}});
    record(Opcode::kChannel, channel);
  }
  for (const auto& [topic, text] : {std::pair{"recorder/withdrawn", withdrawn}, {"recorder/report", report}}) {
    Bytes channel;
    ByteWriter(channel).number(++number).number(std::uint16_t{0}).text(topic).text("json").map(StringMap{});
    record(Opcode::kChannel, channel);
  }
  std::uint64_t time = 1'700'000'000'000'000'000U;
  for (std::uint16_t channel = 1; channel <= messages.size(); ++channel) {
    message(channel, time += 1'000'000'000U, messages[channel - 1U].second);
  }
  message(4, time += 1'000'000'000U, bytes_of(withdrawn));
  message(5, time, bytes_of(report));
  message(1, time + 500'000'000U, messages[0].second);
  corpus.write("recording", "chunk", 1, records);
  // A whole file.
  const std::string path = folder().path("seed.mcap");
  {
    McapWriter file(path, "hecaton");
    const auto schema = file.add_schema("hecaton::msg::ArmState", "omgidl", schema_of("ArmState"));
    const auto channel = file.add_channel(schema, "hecaton/ArmState", "cdr", {{"node", "driver/north"}});
    file.attach("cell.yaml", "application/yaml", 1, "name: three_puma\n");
    file.write({channel, 1, 1'000'000'000U, 1'000'000'000U, messages[0].second});
    file.add_metadata("report", {{"report", report}});
    file.close();
  }
  std::ifstream stream(path, std::ios::binary);
  corpus.write("recording", "file", std::string(1, '\0') + std::string(std::istreambuf_iterator<char>(stream), {}));
}

void write_checkpoints(const Corpus& corpus) {
  msg::WorldCheckpoint world;
  world.cell("three_puma");
  world.time(12.5);
  world.stamp_ns(5);
  world.edition(3);
  corpus.write("world_checkpoint", "empty", bus::file_contents(world));
  world.obstacles(obstacles());
  world.obstacles().resize(4);
  corpus.write("world_checkpoint", "obstacles", bus::file_contents(world));
  services::Checkpoint supervisor;
  supervisor.term = 7;
  corpus.write("supervisor_checkpoint", "empty", services::checkpoint_text(supervisor));
  services::FaultRecord fault;
  fault.opening_term = 1;
  fault.number = 1;
  fault.kind = msg::CauseKind::CAUSE_NODE_SILENT;
  fault.subject = "driver/north";
  fault.description = "driver/north is silent";
  supervisor.faults.open.emplace("node/driver/north", fault);
  fault.cleared_at = std::chrono::seconds(1);
  fault.detection_latency_bound = std::chrono::milliseconds(20);
  supervisor.faults.cleared.push_back(fault);
  supervisor.orders.cell = msg::Mode::MODE_HOLD;
  supervisor.orders.arms["north"] = msg::Mode::MODE_STOP;
  supervisor.unreplicated.arms["north"] = msg::Mode::MODE_STOP;
  corpus.write("supervisor_checkpoint", "orders", services::checkpoint_text(supervisor));
}

}  // namespace
}  // namespace hecaton::fuzz

int main(int argc, char** argv) {
  using namespace hecaton;
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  const fuzz::Corpus corpus(argv[1]);
#define HECATON_SEED(Type, ...) fuzz::write_samples<msg::Type>(corpus);
  HECATON_TOPICS(HECATON_SEED)
#undef HECATON_SEED
  fuzz::write_datagrams(corpus);
  fuzz::write_egm(corpus);
  fuzz::write_rtde(corpus);
  fuzz::write_primary(corpus);
  fuzz::write_ros2(corpus);
  fuzz::write_ros2_control(corpus);
  fuzz::write_recordings(corpus);
  fuzz::write_checkpoints(corpus);
  return 0;
}
