#pragma once
/// Definitions of messages in the notation of ROS 2 (.msg files), from idl/ros2/ros2.idl.

#include <string>
#include <string_view>

namespace hecaton::ros2 {

/// The text of idl/ros2/ros2.idl.
[[nodiscard]] std::string_view idl_text();

/// The definition of a message, "sensor_msgs/msg/JointState", followed by those of the messages in its fields: the
/// encoding `ros2msg` of MCAP and of the Foxglove protocol. A message without fields has an empty definition. Throws
/// std::invalid_argument when the IDL has no such type.
[[nodiscard]] std::string message_definition(std::string_view type);

}  // namespace hecaton::ros2
