#pragma once
/// Names of ROS 2 on the wire, as its DDS middleware (rmw) forms them. Standard library only.

#include <string>
#include <string_view>

namespace hecaton::bus::ros2 {

/// The DDS topic of the ROS topic `name`: "/joint_states" → "rt/joint_states".
[[nodiscard]] inline std::string topic_name(std::string_view name) {
  return "rt" + std::string(name);
}
/// The DDS topics of a service: "/hold" → "rq/holdRequest" and "rr/holdReply".
[[nodiscard]] inline std::string request_name(std::string_view service) {
  return "rq" + std::string(service) + "Request";
}
[[nodiscard]] inline std::string reply_name(std::string_view service) {
  return "rr" + std::string(service) + "Reply";
}

/// The DDS name of a ROS type: "sensor_msgs/msg/JointState" → "sensor_msgs::msg::dds_::JointState_". The request of a
/// service is "std_srvs/srv/Trigger_Request", its reply "std_srvs/srv/Trigger_Response".
[[nodiscard]] inline std::string type_name(std::string_view type) {
  const auto package = type.find('/');
  const auto kind = type.rfind('/');
  return std::string(type.substr(0, package)) + "::" + std::string(type.substr(package + 1, kind - package - 1)) +
         "::dds_::" + std::string(type.substr(kind + 1)) + "_";
}

}  // namespace hecaton::bus::ros2
