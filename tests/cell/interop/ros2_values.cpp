/// The values of samples as Hecaton means them, for comparison with the decoders of other vendors.
///
/// usage: ros2_values SAMPLES OUT
///
/// SAMPLES has the lines of `cyclone_peer watch`. Writes them into OUT, those of messages of ROS 2 with one more entry
/// `own`: the value with the name of each member. The encoder writes the members in the order of fields(), and
/// Hecaton's decoder reads them in the same order: each member has the value again that the publisher gave to it. The
/// other decoders read in the order of the texts of ROS 2. So an order that differs from the texts is a difference of
/// values, even between members of one type.

#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include "tests/cell/interop/ros2_json.hpp"

namespace {

using namespace hecaton;
using nlohmann::json;

ros2::Bytes bytes_of(const std::string& hex) {
  ros2::Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

template <class Message>
json own(const ros2::Bytes& bytes) {
  const auto message = ros2::decoded<Message>(bytes);
  if (!message) throw std::runtime_error("Hecaton cannot decode a message that it has sent");
  return *message;
}

const std::string kAction = "control_msgs::action::FollowJointTrajectory_";
const std::map<std::string, json (*)(const ros2::Bytes&)> kTypes{
    {"std_msgs::msg::String", own<ros2::String>},
    {"rosgraph_msgs::msg::Clock", own<ros2::Clock>},
    {"tf2_msgs::msg::TFMessage", own<ros2::TFMessage>},
    {"sensor_msgs::msg::JointState", own<ros2::JointState>},
    {"diagnostic_msgs::msg::DiagnosticArray", own<ros2::DiagnosticArray>},
    {"diagnostic_msgs::msg::DiagnosticStatus", own<ros2::DiagnosticStatus>},
    {"visualization_msgs::msg::MarkerArray", own<ros2::MarkerArray>},
    {"std_srvs::srv::Trigger_Response", own<ros2::TriggerResponse>},
    {"action_msgs::msg::GoalStatusArray", own<ros2::GoalStatusArray>},
    {"action_msgs::srv::CancelGoal_Response", own<ros2::CancelGoalResponse>},
    {kAction + "SendGoal_Response", own<ros2::SendGoalResponse>},
    {kAction + "GetResult_Response", own<ros2::GetResultResponse>},
    {kAction + "FeedbackMessage", own<ros2::FeedbackMessage>}};

void add_values(const char* samples, const char* out) {
  std::ifstream from(samples);
  std::ofstream to(out);
  constexpr std::size_t kTold = 10000;
  std::size_t lines = 0;
  for (std::string line; std::getline(from, line);) {
    json sample = json::parse(line);
    const auto type = kTypes.find(sample.at("type"));
    if (type != kTypes.end()) sample["own"] = type->second(bytes_of(sample.at("cdr")));
    to << sample << '\n';
    if (++lines % kTold == 0) std::fprintf(stderr, "%zu samples\n", lines);  // a test waits for a sign
  }
  if (!from.eof() || !to.flush()) throw std::runtime_error(std::string(samples) + " cannot be copied to " + out);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: ros2_values SAMPLES OUT\n", stderr);
    return 2;
  }
  try {
    add_values(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_values: %s\n", error.what());
    return 1;
  }
}
