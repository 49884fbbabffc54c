#pragma once
/// The messages, services and actions of ROS 2 that Hecaton exchanges, with the fields of idl/ros2/ros2.idl.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::ros2 {

/// The name of a type and its hash, which other nodes show and compare.
struct TypeInfo {
  std::string_view name;
  std::string_view hash;
  bool short_request = false;  ///< of a service: no field of the request has a variable length
};

// tests/ros2_type_hashes.py --write computes the hashes.
namespace type {
inline constexpr TypeInfo kString{"std_msgs/msg/String",
                                  "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"};
inline constexpr TypeInfo kFloat64{"std_msgs/msg/Float64",
                                   "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a"};
inline constexpr TypeInfo kFloat64MultiArray{"std_msgs/msg/Float64MultiArray",
                                             "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"};
inline constexpr TypeInfo kSpeedScalingFactor{"control_msgs/msg/SpeedScalingFactor",
                                              "0c240f349f2b74e33e8741f83e0f196ddeb6585923663876ed3c1f51f0566037"};
inline constexpr TypeInfo kJointTrajectory{"trajectory_msgs/msg/JointTrajectory",
                                           "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"};
inline constexpr TypeInfo kClock{"rosgraph_msgs/msg/Clock",
                                 "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"};
inline constexpr TypeInfo kJointState{"sensor_msgs/msg/JointState",
                                      "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"};
inline constexpr TypeInfo kTransforms{"tf2_msgs/msg/TFMessage",
                                      "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"};
inline constexpr TypeInfo kPoseStamped{"geometry_msgs/msg/PoseStamped",
                                       "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"};
inline constexpr TypeInfo kMarkers{"visualization_msgs/msg/MarkerArray",
                                   "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"};
inline constexpr TypeInfo kDiagnostics{"diagnostic_msgs/msg/DiagnosticArray",
                                       "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"};
inline constexpr TypeInfo kDiagnosticStatus{"diagnostic_msgs/msg/DiagnosticStatus",
                                            "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4"};
inline constexpr TypeInfo kPlanningScene{"moveit_msgs/msg/PlanningScene",
                                         "0f58540ad5eab4b9ea827d53b763c793d8cabd202b3b301fcee25afa4ce1bd80"};
inline constexpr TypeInfo kTrigger{"std_srvs/srv/Trigger",
                                   "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f", true};
inline constexpr TypeInfo kGoalStatuses{"action_msgs/msg/GoalStatusArray",
                                        "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"};
inline constexpr TypeInfo kCancelGoal{"action_msgs/srv/CancelGoal",
                                      "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a", true};
inline constexpr TypeInfo kSendTrajectory{"control_msgs/action/FollowJointTrajectory_SendGoal",
                                          "b13789dddc325a7a962825c45e28c77d37237ec129dd0c34dc5994562938c57f"};
inline constexpr TypeInfo kTrajectoryResult{"control_msgs/action/FollowJointTrajectory_GetResult",
                                            "e3ceb38e3e1867c8dc0f46014df26e90eb93422f27e9e97f936e07f94be4bc8b", true};
inline constexpr TypeInfo kSendGripperCommand{"control_msgs/action/GripperCommand_SendGoal",
                                              "6bf8cc4ce80cd499e7dd3258c03c50c3fa6672b469ff8355339ef1df77fcd212", true};
inline constexpr TypeInfo kGripperCommandResult{"control_msgs/action/GripperCommand_GetResult",
                                                "7e60a7606063d4a2728d21badac099e68b734a196ac3ab42d1d4c668eb0bb3cd",
                                                true};
inline constexpr TypeInfo kTrajectoryFeedback{"control_msgs/action/FollowJointTrajectory_FeedbackMessage",
                                              "80398fcb9674a79081a9906e2ccf0c804dd7cb15e22e362e606ee87186beab71"};
}  // namespace type

struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void fields(auto& self, auto& visit) { visit(self.sec, self.nanosec); }
};
struct Duration {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void fields(auto& self, auto& visit) { visit(self.sec, self.nanosec); }
};
struct UUID {
  std::array<std::uint8_t, 16> uuid{};
  static void fields(auto& self, auto& visit) { visit(self.uuid); }
};
struct Header {
  Time stamp;
  std::string frame_id;
  static void fields(auto& self, auto& visit) { visit(self.stamp, self.frame_id); }
};
struct String {
  std::string data;
  static void fields(auto& self, auto& visit) { visit(self.data); }
};
struct Float64 {
  double data = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.data); }
};
struct MultiArrayDimension {
  std::string label;
  std::uint32_t size = 0;
  std::uint32_t stride = 0;
  static void fields(auto& self, auto& visit) { visit(self.label, self.size, self.stride); }
};
struct MultiArrayLayout {
  std::vector<MultiArrayDimension> dim;
  std::uint32_t data_offset = 0;
  static void fields(auto& self, auto& visit) { visit(self.dim, self.data_offset); }
};
struct Float64MultiArray {
  MultiArrayLayout layout;
  std::vector<double> data;
  static void fields(auto& self, auto& visit) { visit(self.layout, self.data); }
};
struct ColorRGBA {
  float r = 0.0F;
  float g = 0.0F;
  float b = 0.0F;
  float a = 0.0F;
  static void fields(auto& self, auto& visit) { visit(self.r, self.g, self.b, self.a); }
};
struct Clock {
  Time clock;
  static void fields(auto& self, auto& visit) { visit(self.clock); }
};
struct Point {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.x, self.y, self.z); }
};
struct Vector3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.x, self.y, self.z); }
};
struct Quaternion {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.x, self.y, self.z, self.w); }
};
struct Pose {
  Point position;
  Quaternion orientation;
  static void fields(auto& self, auto& visit) { visit(self.position, self.orientation); }
};
struct PoseStamped {
  Header header;
  Pose pose;
  static void fields(auto& self, auto& visit) { visit(self.header, self.pose); }
};
struct Twist {
  Vector3 linear;
  Vector3 angular;
  static void fields(auto& self, auto& visit) { visit(self.linear, self.angular); }
};
struct Wrench {
  Vector3 force;
  Vector3 torque;
  static void fields(auto& self, auto& visit) { visit(self.force, self.torque); }
};
struct Point32 {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  static void fields(auto& self, auto& visit) { visit(self.x, self.y, self.z); }
};
struct Polygon {
  std::vector<Point32> points;
  static void fields(auto& self, auto& visit) { visit(self.points); }
};
struct Transform {
  Vector3 translation;
  Quaternion rotation;
  static void fields(auto& self, auto& visit) { visit(self.translation, self.rotation); }
};
struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Transform transform;
  static void fields(auto& self, auto& visit) { visit(self.header, self.child_frame_id, self.transform); }
};
struct TFMessage {
  std::vector<TransformStamped> transforms;
  static void fields(auto& self, auto& visit) { visit(self.transforms); }
};
struct JointState {
  Header header;
  std::vector<std::string> name;
  std::vector<double> position;
  std::vector<double> velocity;
  std::vector<double> effort;
  static void fields(auto& self, auto& visit) {
    visit(self.header, self.name, self.position, self.velocity, self.effort);
  }
};
struct MultiDOFJointState {
  Header header;
  std::vector<std::string> joint_names;
  std::vector<Transform> transforms;
  std::vector<Twist> twist;
  std::vector<Wrench> wrench;
  static void fields(auto& self, auto& visit) {
    visit(self.header, self.joint_names, self.transforms, self.twist, self.wrench);
  }
};
struct CompressedImage {
  Header header;
  std::string format;
  std::vector<std::uint8_t> data;
  static void fields(auto& self, auto& visit) { visit(self.header, self.format, self.data); }
};
struct JointTrajectoryPoint {
  std::vector<double> positions;
  std::vector<double> velocities;
  std::vector<double> accelerations;
  std::vector<double> effort;
  Duration time_from_start;
  static void fields(auto& self, auto& visit) {
    visit(self.positions, self.velocities, self.accelerations, self.effort, self.time_from_start);
  }
};
struct JointTrajectory {
  Header header;
  std::vector<std::string> joint_names;
  std::vector<JointTrajectoryPoint> points;
  static void fields(auto& self, auto& visit) { visit(self.header, self.joint_names, self.points); }
};
struct MultiDOFJointTrajectoryPoint {
  std::vector<Transform> transforms;
  std::vector<Twist> velocities;
  std::vector<Twist> accelerations;
  Duration time_from_start;
  static void fields(auto& self, auto& visit) {
    visit(self.transforms, self.velocities, self.accelerations, self.time_from_start);
  }
};
struct MultiDOFJointTrajectory {
  Header header;
  std::vector<std::string> joint_names;
  std::vector<MultiDOFJointTrajectoryPoint> points;
  static void fields(auto& self, auto& visit) { visit(self.header, self.joint_names, self.points); }
};
struct SolidPrimitive {
  std::uint8_t type = 0;
  std::vector<double> dimensions;
  Polygon polygon;
  static void fields(auto& self, auto& visit) { visit(self.type, self.dimensions, self.polygon); }
};
struct MeshTriangle {
  std::array<std::uint32_t, 3> vertex_indices{};
  static void fields(auto& self, auto& visit) { visit(self.vertex_indices); }
};
struct Mesh {
  std::vector<MeshTriangle> triangles;
  std::vector<Point> vertices;
  static void fields(auto& self, auto& visit) { visit(self.triangles, self.vertices); }
};
struct Plane {
  std::array<double, 4> coef{};
  static void fields(auto& self, auto& visit) { visit(self.coef); }
};
struct ObjectType {
  std::string key;
  std::string db;
  static void fields(auto& self, auto& visit) { visit(self.key, self.db); }
};
struct Octomap {
  Header header;
  bool binary = false;
  std::string id;
  double resolution = 0.0;
  std::vector<std::int8_t> data;
  static void fields(auto& self, auto& visit) { visit(self.header, self.binary, self.id, self.resolution, self.data); }
};
struct OctomapWithPose {
  Header header;
  Pose origin;
  Octomap octomap;
  static void fields(auto& self, auto& visit) { visit(self.header, self.origin, self.octomap); }
};
struct CollisionObject {
  Header header;
  Pose pose;
  std::string id;
  ObjectType type;
  std::vector<SolidPrimitive> primitives;
  std::vector<Pose> primitive_poses;
  std::vector<Mesh> meshes;
  std::vector<Pose> mesh_poses;
  std::vector<Plane> planes;
  std::vector<Pose> plane_poses;
  std::vector<std::string> subframe_names;
  std::vector<Pose> subframe_poses;
  std::uint8_t operation = 0;
  static void fields(auto& self, auto& visit) {
    visit(self.header, self.pose, self.id, self.type, self.primitives, self.primitive_poses, self.meshes,
          self.mesh_poses, self.planes, self.plane_poses, self.subframe_names, self.subframe_poses, self.operation);
  }
};
struct AttachedCollisionObject {
  std::string link_name;
  CollisionObject object;
  std::vector<std::string> touch_links;
  JointTrajectory detach_posture;
  double weight = 0.0;
  static void fields(auto& self, auto& visit) {
    visit(self.link_name, self.object, self.touch_links, self.detach_posture, self.weight);
  }
};
struct RobotState {
  JointState joint_state;
  MultiDOFJointState multi_dof_joint_state;
  std::vector<AttachedCollisionObject> attached_collision_objects;
  bool is_diff = false;
  static void fields(auto& self, auto& visit) {
    visit(self.joint_state, self.multi_dof_joint_state, self.attached_collision_objects, self.is_diff);
  }
};
struct AllowedCollisionEntry {
  std::vector<std::uint8_t> enabled;  ///< booleans
  static void fields(auto& self, auto& visit) { visit(self.enabled); }
};
struct AllowedCollisionMatrix {
  std::vector<std::string> entry_names;
  std::vector<AllowedCollisionEntry> entry_values;
  std::vector<std::string> default_entry_names;
  std::vector<std::uint8_t> default_entry_values;  ///< booleans
  static void fields(auto& self, auto& visit) {
    visit(self.entry_names, self.entry_values, self.default_entry_names, self.default_entry_values);
  }
};
struct LinkPadding {
  std::string link_name;
  double padding = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.link_name, self.padding); }
};
struct LinkScale {
  std::string link_name;
  double scale = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.link_name, self.scale); }
};
struct ObjectColor {
  std::string id;
  ColorRGBA color;
  static void fields(auto& self, auto& visit) { visit(self.id, self.color); }
};
struct PlanningSceneWorld {
  std::vector<CollisionObject> collision_objects;
  OctomapWithPose octomap;
  static void fields(auto& self, auto& visit) { visit(self.collision_objects, self.octomap); }
};
struct PlanningScene {
  std::string name;
  RobotState robot_state;
  std::string robot_model_name;
  std::vector<TransformStamped> fixed_frame_transforms;
  AllowedCollisionMatrix allowed_collision_matrix;
  std::vector<LinkPadding> link_padding;
  std::vector<LinkScale> link_scale;
  std::vector<ObjectColor> object_colors;
  PlanningSceneWorld world;
  bool is_diff = false;
  static void fields(auto& self, auto& visit) {
    visit(self.name, self.robot_state, self.robot_model_name, self.fixed_frame_transforms,
          self.allowed_collision_matrix, self.link_padding, self.link_scale, self.object_colors, self.world,
          self.is_diff);
  }
};
struct KeyValue {
  std::string key;
  std::string value;
  static void fields(auto& self, auto& visit) { visit(self.key, self.value); }
};
struct DiagnosticStatus {
  std::uint8_t level = 0;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;
  static void fields(auto& self, auto& visit) {
    visit(self.level, self.name, self.message, self.hardware_id, self.values);
  }
};
struct DiagnosticArray {
  Header header;
  std::vector<DiagnosticStatus> status;
  static void fields(auto& self, auto& visit) { visit(self.header, self.status); }
};
struct UVCoordinate {
  float u = 0.0F;
  float v = 0.0F;
  static void fields(auto& self, auto& visit) { visit(self.u, self.v); }
};
struct MeshFile {
  std::string filename;
  std::vector<std::uint8_t> data;
  static void fields(auto& self, auto& visit) { visit(self.filename, self.data); }
};
struct Marker {
  Header header;
  std::string ns;
  std::int32_t id = 0;
  std::int32_t type = 0;
  std::int32_t action = 0;
  Pose pose;
  Vector3 scale;
  ColorRGBA color;
  Duration lifetime;
  bool frame_locked = false;
  std::vector<Point> points;
  std::vector<ColorRGBA> colors;
  std::string texture_resource;
  CompressedImage texture;
  std::vector<UVCoordinate> uv_coordinates;
  std::string text;
  std::string mesh_resource;
  MeshFile mesh_file;
  bool mesh_use_embedded_materials = false;
  static void fields(auto& self, auto& visit) {
    visit(self.header, self.ns, self.id, self.type, self.action, self.pose, self.scale, self.color, self.lifetime,
          self.frame_locked, self.points, self.colors, self.texture_resource, self.texture, self.uv_coordinates,
          self.text, self.mesh_resource, self.mesh_file, self.mesh_use_embedded_materials);
  }
};
struct MarkerArray {
  std::vector<Marker> markers;
  static void fields(auto& self, auto& visit) { visit(self.markers); }
};
struct TriggerRequest {
  std::uint8_t structure_needs_at_least_one_member = 0;
  static void fields(auto& self, auto& visit) { visit(self.structure_needs_at_least_one_member); }
};
struct TriggerResponse {
  bool success = false;
  std::string message;
  static void fields(auto& self, auto& visit) { visit(self.success, self.message); }
};
struct GoalInfo {
  UUID goal_id;
  Time stamp;
  static void fields(auto& self, auto& visit) { visit(self.goal_id, self.stamp); }
};
struct GoalStatus {
  GoalInfo goal_info;
  std::int8_t status = 0;
  static void fields(auto& self, auto& visit) { visit(self.goal_info, self.status); }
};
struct GoalStatusArray {
  std::vector<GoalStatus> status_list;
  static void fields(auto& self, auto& visit) { visit(self.status_list); }
};
struct CancelGoalRequest {
  GoalInfo goal_info;
  static void fields(auto& self, auto& visit) { visit(self.goal_info); }
};
struct CancelGoalResponse {
  std::int8_t return_code = 0;
  std::vector<GoalInfo> goals_canceling;
  static void fields(auto& self, auto& visit) { visit(self.return_code, self.goals_canceling); }
};
struct SpeedScalingFactor {
  double factor = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.factor); }
};
struct JointTolerance {
  std::string name;
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
  static void fields(auto& self, auto& visit) { visit(self.name, self.position, self.velocity, self.acceleration); }
};
struct JointComponentTolerance {
  std::string joint_name;
  std::uint16_t component = 0;
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
  static void fields(auto& self, auto& visit) {
    visit(self.joint_name, self.component, self.position, self.velocity, self.acceleration);
  }
};
struct TrajectoryGoal {
  JointTrajectory trajectory;
  MultiDOFJointTrajectory multi_dof_trajectory;
  std::vector<JointTolerance> path_tolerance;
  std::vector<JointComponentTolerance> component_path_tolerance;
  std::vector<JointTolerance> goal_tolerance;
  std::vector<JointComponentTolerance> component_goal_tolerance;
  Duration goal_time_tolerance;
  static void fields(auto& self, auto& visit) {
    visit(self.trajectory, self.multi_dof_trajectory, self.path_tolerance, self.component_path_tolerance,
          self.goal_tolerance, self.component_goal_tolerance, self.goal_time_tolerance);
  }
};
struct TrajectoryResult {
  std::int32_t error_code = 0;
  std::string error_string;
  static void fields(auto& self, auto& visit) { visit(self.error_code, self.error_string); }
};
struct TrajectoryFeedback {
  Header header;
  std::vector<std::string> joint_names;
  JointTrajectoryPoint desired;
  JointTrajectoryPoint actual;
  JointTrajectoryPoint error;
  std::vector<std::string> multi_dof_joint_names;
  MultiDOFJointTrajectoryPoint multi_dof_desired;
  MultiDOFJointTrajectoryPoint multi_dof_actual;
  MultiDOFJointTrajectoryPoint multi_dof_error;
  static void fields(auto& self, auto& visit) {
    visit(self.header, self.joint_names, self.desired, self.actual, self.error, self.multi_dof_joint_names,
          self.multi_dof_desired, self.multi_dof_actual, self.multi_dof_error);
  }
};
struct GripperCommand {
  double position = 0.0;    ///< of the joint [rad | m]
  double max_effort = 0.0;  ///< [N m | N]
  static void fields(auto& self, auto& visit) { visit(self.position, self.max_effort); }
};
struct GripperGoal {
  GripperCommand command;
  static void fields(auto& self, auto& visit) { visit(self.command); }
};
struct GripperResult {
  double position = 0.0;  ///< [rad | m]
  double effort = 0.0;    ///< [N m | N]
  bool stalled = false;
  bool reached_goal = false;
  static void fields(auto& self, auto& visit) { visit(self.position, self.effort, self.stalled, self.reached_goal); }
};
/// Of any action with that goal.
template <class Goal>
struct ActionGoalRequest {
  UUID goal_id;
  Goal goal;
  static void fields(auto& self, auto& visit) { visit(self.goal_id, self.goal); }
};
struct SendGoalResponse {
  bool accepted = false;
  Time stamp;
  static void fields(auto& self, auto& visit) { visit(self.accepted, self.stamp); }
};
struct GetResultRequest {
  UUID goal_id;
  static void fields(auto& self, auto& visit) { visit(self.goal_id); }
};
/// Of any action with that result.
template <class Result>
struct ActionResultResponse {
  std::int8_t status = 0;
  Result result;
  static void fields(auto& self, auto& visit) { visit(self.status, self.result); }
};
using SendGoalRequest = ActionGoalRequest<TrajectoryGoal>;
using GetResultResponse = ActionResultResponse<TrajectoryResult>;
struct FeedbackMessage {
  UUID goal_id;
  TrajectoryFeedback feedback;
  static void fields(auto& self, auto& visit) { visit(self.goal_id, self.feedback); }
};

}  // namespace hecaton::ros2
