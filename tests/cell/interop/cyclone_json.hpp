#pragma once
/// JSON of the messages that idlc has generated for Cyclone DDS, with the names of the IDL files. 64-bit integers are
/// texts, because a number of JSON has 53 bits. The functions are global, like the generated C types.

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

extern "C" {
#include "arm.h"
#include "goal.h"
#include "ros2.h"
}

using Json = nlohmann::json;

/// A sequence.
template <class S>
requires requires(const S& sequence) {
  sequence._buffer[sequence._length];
}
void to_json(Json& json, const S& sequence) {
  json = Json::array();
  for (std::uint32_t i = 0; i < sequence._length; ++i) json.push_back(sequence._buffer[i]);
}

// common.idl, cause.idl
inline void to_json(Json& json, const hecaton_msg_Vec3& m) {
  json = {{"x", m.x}, {"y", m.y}, {"z", m.z}};
}
inline void to_json(Json& json, const hecaton_msg_Pose& m) {
  json = {{"position", m.position}, {"qw", m.qw}, {"qx", m.qx}, {"qy", m.qy}, {"qz", m.qz}};
}
inline void to_json(Json& json, const hecaton_msg_Cause& m) {
  json = {{"kind", static_cast<int>(m.kind)}, {"subject", m.subject}, {"text", m.text}};
}

// arm.idl, goal.idl
inline void to_json(Json& json, const hecaton_msg_ArmState& m) {
  json = {{"schema", m.schema},
          {"arm", m.arm},
          {"term", std::to_string(m.term)},
          {"sequence_number", std::to_string(m.sequence_number)},
          {"stamp_ns", std::to_string(m.stamp_ns)},
          {"mode", static_cast<int>(m.mode)},
          {"q", m.q},
          {"qd", m.qd},
          {"speed_scaling", m.speed_scaling},
          {"tracking_delay", m.tracking_delay},
          {"carried", m.carried},
          {"command_sequence_number", std::to_string(m.command_sequence_number)},
          {"command_age", m.command_age},
          {"newest_term", std::to_string(m.newest_term)},
          {"planner", m.planner},
          {"stale_rejected", std::to_string(m.stale_rejected)},
          {"cause", m.cause},
          {"outside", m.outside},
          {"outside_lower", m.outside_lower},
          {"outside_upper", m.outside_upper}};
}
inline void to_json(Json& json, const hecaton_msg_ToolGoal& m) {
  json = {{"X_WT", m.X_WT},
          {"free_rotation", static_cast<int>(m.free_rotation)},
          {"position_tolerance", m.position_tolerance},
          {"orientation_tolerance", m.orientation_tolerance}};
}
inline void to_json(Json& json, const hecaton_msg_GoalStatus& m) {
  json = {{"schema", m.schema},
          {"arm", m.arm},
          {"goal", m.goal},
          {"term", std::to_string(m.term)},
          {"sequence_number", std::to_string(m.sequence_number)},
          {"stamp_ns", std::to_string(m.stamp_ns)},
          {"node", m.node},
          {"state", static_cast<int>(m.state)},
          {"cause", m.cause},
          {"has_binding", m.has_binding},
          {"binding_own", m.binding_own},
          {"binding_other", m.binding_other},
          {"binding_distance", m.binding_distance},
          {"recovery_action", m.recovery_action},
          {"blocked_duration", m.blocked_duration},
          {"priority", m.priority},
          {"distance_to_goal", m.distance_to_goal},
          {"elapsed", m.elapsed},
          {"note", m.note},
          {"has_tool", m.has_tool},
          {"tool", m.tool},
          {"position_error", m.position_error},
          {"orientation_error", m.orientation_error},
          {"has_nearest", m.has_nearest},
          {"X_WT_nearest", m.X_WT_nearest},
          {"nearest_angle", m.nearest_angle},
          {"q_goal", m.q_goal},
          {"trajectory_time", m.trajectory_time},
          {"trajectory_rate", m.trajectory_rate}};
}

// ROS 2
inline void to_json(Json& json, const builtin_interfaces_msg_Time& m) {
  json = {{"sec", m.sec}, {"nanosec", m.nanosec}};
}
inline void to_json(Json& json, const builtin_interfaces_msg_Duration& m) {
  json = {{"sec", m.sec}, {"nanosec", m.nanosec}};
}
inline void to_json(Json& json, const std_msgs_msg_Header& m) {
  json = {{"stamp", m.stamp}, {"frame_id", m.frame_id}};
}
inline void to_json(Json& json, const std_msgs_msg_String& m) {
  json = {{"data", m.data}};
}
inline void to_json(Json& json, const std_msgs_msg_ColorRGBA& m) {
  json = {{"r", m.r}, {"g", m.g}, {"b", m.b}, {"a", m.a}};
}
inline void to_json(Json& json, const rosgraph_msgs_msg_Clock& m) {
  json = {{"clock", m.clock}};
}
inline void to_json(Json& json, const geometry_msgs_msg_Point& m) {
  json = {{"x", m.x}, {"y", m.y}, {"z", m.z}};
}
inline void to_json(Json& json, const geometry_msgs_msg_Vector3& m) {
  json = {{"x", m.x}, {"y", m.y}, {"z", m.z}};
}
inline void to_json(Json& json, const geometry_msgs_msg_Quaternion& m) {
  json = {{"x", m.x}, {"y", m.y}, {"z", m.z}, {"w", m.w}};
}
inline void to_json(Json& json, const geometry_msgs_msg_Pose& m) {
  json = {{"position", m.position}, {"orientation", m.orientation}};
}
inline void to_json(Json& json, const geometry_msgs_msg_Transform& m) {
  json = {{"translation", m.translation}, {"rotation", m.rotation}};
}
inline void to_json(Json& json, const geometry_msgs_msg_TransformStamped& m) {
  json = {{"header", m.header}, {"child_frame_id", m.child_frame_id}, {"transform", m.transform}};
}
inline void to_json(Json& json, const tf2_msgs_msg_TFMessage& m) {
  json = {{"transforms", m.transforms}};
}
inline void to_json(Json& json, const sensor_msgs_msg_JointState& m) {
  json = {
      {"header", m.header}, {"name", m.name}, {"position", m.position}, {"velocity", m.velocity}, {"effort", m.effort}};
}
inline void to_json(Json& json, const diagnostic_msgs_msg_KeyValue& m) {
  json = {{"key", m.key}, {"value", m.value}};
}
inline void to_json(Json& json, const diagnostic_msgs_msg_DiagnosticStatus& m) {
  json = {{"level", m.level},
          {"name", m.name},
          {"message", m.message},
          {"hardware_id", m.hardware_id},
          {"values", m.values}};
}
inline void to_json(Json& json, const diagnostic_msgs_msg_DiagnosticArray& m) {
  json = {{"header", m.header}, {"status", m.status}};
}
inline void to_json(Json& json, const sensor_msgs_msg_CompressedImage& m) {
  json = {{"header", m.header}, {"format", m.format}, {"data", m.data}};
}
inline void to_json(Json& json, const visualization_msgs_msg_UVCoordinate& m) {
  json = {{"u", m.u}, {"v", m.v}};
}
inline void to_json(Json& json, const visualization_msgs_msg_MeshFile& m) {
  json = {{"filename", m.filename}, {"data", m.data}};
}
inline void to_json(Json& json, const visualization_msgs_msg_Marker& m) {
  json = {{"header", m.header},
          {"ns", m.ns},
          {"id", m.id},
          {"type", m.type},
          {"action", m.action},
          {"pose", m.pose},
          {"scale", m.scale},
          {"color", m.color},
          {"lifetime", m.lifetime},
          {"frame_locked", m.frame_locked},
          {"points", m.points},
          {"colors", m.colors},
          {"texture_resource", m.texture_resource},
          {"texture", m.texture},
          {"uv_coordinates", m.uv_coordinates},
          {"text", m.text},
          {"mesh_resource", m.mesh_resource},
          {"mesh_file", m.mesh_file},
          {"mesh_use_embedded_materials", m.mesh_use_embedded_materials}};
}
inline void to_json(Json& json, const visualization_msgs_msg_MarkerArray& m) {
  json = {{"markers", m.markers}};
}
inline void to_json(Json& json, const geometry_msgs_msg_Twist& m) {
  json = {{"linear", m.linear}, {"angular", m.angular}};
}
inline void to_json(Json& json, const trajectory_msgs_msg_JointTrajectoryPoint& m) {
  json = {{"positions", m.positions},
          {"velocities", m.velocities},
          {"accelerations", m.accelerations},
          {"effort", m.effort},
          {"time_from_start", m.time_from_start}};
}
inline void to_json(Json& json, const trajectory_msgs_msg_MultiDOFJointTrajectoryPoint& m) {
  json = {{"transforms", m.transforms},
          {"velocities", m.velocities},
          {"accelerations", m.accelerations},
          {"time_from_start", m.time_from_start}};
}
inline void to_json(Json& json, const unique_identifier_msgs_msg_UUID& m) {
  json = {{"uuid", m.uuid}};
}
inline void to_json(Json& json, const std_srvs_srv_Trigger_Response& m) {
  json = {{"success", m.success}, {"message", m.message}};
}
inline void to_json(Json& json, const action_msgs_msg_GoalInfo& m) {
  json = {{"goal_id", m.goal_id}, {"stamp", m.stamp}};
}
inline void to_json(Json& json, const action_msgs_msg_GoalStatus& m) {
  json = {{"goal_info", m.goal_info}, {"status", m.status}};
}
inline void to_json(Json& json, const action_msgs_msg_GoalStatusArray& m) {
  json = {{"status_list", m.status_list}};
}
inline void to_json(Json& json, const action_msgs_srv_CancelGoal_Response& m) {
  json = {{"return_code", m.return_code}, {"goals_canceling", m.goals_canceling}};
}
inline void to_json(Json& json, const control_msgs_action_FollowJointTrajectory_Result& m) {
  json = {{"error_code", m.error_code}, {"error_string", m.error_string}};
}
inline void to_json(Json& json, const control_msgs_action_FollowJointTrajectory_SendGoal_Response& m) {
  json = {{"accepted", m.accepted}, {"stamp", m.stamp}};
}
inline void to_json(Json& json, const control_msgs_action_FollowJointTrajectory_GetResult_Response& m) {
  json = {{"status", m.status}, {"result", m.result}};
}
inline void to_json(Json& json, const control_msgs_action_FollowJointTrajectory_Feedback& m) {
  json = {{"header", m.header},
          {"joint_names", m.joint_names},
          {"desired", m.desired},
          {"actual", m.actual},
          {"error", m.error},
          {"multi_dof_joint_names", m.multi_dof_joint_names},
          {"multi_dof_desired", m.multi_dof_desired},
          {"multi_dof_actual", m.multi_dof_actual},
          {"multi_dof_error", m.multi_dof_error}};
}
inline void to_json(Json& json, const control_msgs_action_FollowJointTrajectory_FeedbackMessage& m) {
  json = {{"goal_id", m.goal_id}, {"feedback", m.feedback}};
}

// rmw_dds_common
inline void to_json(Json& json, const rmw_dds_common_msg_Gid& m) {
  json = {{"data", m.data}};
}
inline void to_json(Json& json, const rmw_dds_common_humble_Gid& m) {
  json = {{"data", m.data}};
}
template <class Node>
void node_to_json(Json& json, const Node& m) {
  json = {{"node_namespace", m.node_namespace},
          {"node_name", m.node_name},
          {"reader_gid_seq", m.reader_gid_seq},
          {"writer_gid_seq", m.writer_gid_seq}};
}
inline void to_json(Json& json, const rmw_dds_common_msg_NodeEntitiesInfo& m) {
  node_to_json(json, m);
}
inline void to_json(Json& json, const rmw_dds_common_humble_NodeEntitiesInfo& m) {
  node_to_json(json, m);
}
inline void to_json(Json& json, const rmw_dds_common_msg_ParticipantEntitiesInfo& m) {
  json = {{"gid", m.gid}, {"node_entities_info_seq", m.node_entities_info_seq}};
}
inline void to_json(Json& json, const rmw_dds_common_humble_ParticipantEntitiesInfo& m) {
  json = {{"gid", m.gid}, {"node_entities_info_seq", m.node_entities_info_seq}};
}
