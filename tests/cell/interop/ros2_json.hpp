#pragma once
/// JSON of the messages of ROS 2 that hecaton-ros2 sends. Each member is written with its own name, which is that of
/// the message texts. The order of fields(), in which the encoder writes the members, has no part in it.

#include <nlohmann/json.hpp>

#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::ros2 {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Time, sec, nanosec)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Duration, sec, nanosec)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(UUID, uuid)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Header, stamp, frame_id)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(String, data)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ColorRGBA, r, g, b, a)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Clock, clock)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Point, x, y, z)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Vector3, x, y, z)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Quaternion, x, y, z, w)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Pose, position, orientation)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Twist, linear, angular)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Transform, translation, rotation)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TransformStamped, header, child_frame_id, transform)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TFMessage, transforms)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(JointState, header, name, position, velocity, effort)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CompressedImage, header, format, data)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(JointTrajectoryPoint, positions, velocities, accelerations, effort, time_from_start)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MultiDOFJointTrajectoryPoint, transforms, velocities, accelerations, time_from_start)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KeyValue, key, value)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DiagnosticStatus, level, name, message, hardware_id, values)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DiagnosticArray, header, status)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(UVCoordinate, u, v)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MeshFile, filename, data)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Marker, header, ns, id, type, action, pose, scale, color, lifetime, frame_locked,
                                   points, colors, texture_resource, texture, uv_coordinates, text, mesh_resource,
                                   mesh_file, mesh_use_embedded_materials)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MarkerArray, markers)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TriggerResponse, success, message)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GoalInfo, goal_id, stamp)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GoalStatus, goal_info, status)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GoalStatusArray, status_list)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CancelGoalResponse, return_code, goals_canceling)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SendGoalResponse, accepted, stamp)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TrajectoryResult, error_code, error_string)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GetResultResponse, status, result)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TrajectoryFeedback, header, joint_names, desired, actual, error,
                                   multi_dof_joint_names, multi_dof_desired, multi_dof_actual, multi_dof_error)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FeedbackMessage, goal_id, feedback)

}  // namespace hecaton::ros2
