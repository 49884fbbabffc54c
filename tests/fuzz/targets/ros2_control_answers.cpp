// A serialised message of controllers beside the joint states: answers and results of actions, and speed scaling. The
// first byte chooses its type.

#include <array>

#include "services/arm_driver/devices/ros2_control/results.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace hecaton;

void use_answer(const ros2::GetResultResponse& response) {
  const std::string reason = device::ros2_control::reason_of(response.result);
  fuzz::require_sentence(reason);
  fuzz::require(!bus::unprintable(reason), "a reason is printable");
}
template <class Message>
void use_answer(const Message&) {}

template <class Message>
void check_answer(fuzz::View bytes) {
  const auto message = ros2::decoded<Message>(bytes);
  if (!message) return;
  const ros2::Bytes once = ros2::encoded(*message);
  const auto again = ros2::decoded<Message>(once);
  fuzz::require(again && ros2::encoded(*again) == once, "a decoded message survives another way over the wire");
  use_answer(*message);
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(ros2_control_answers)(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  using Check = void (*)(fuzz::View);
  static constexpr std::array<Check, 5> kChecks{check_answer<ros2::SendGoalResponse>,
                                                check_answer<ros2::GetResultResponse>,
                                                check_answer<ros2::ActionResultResponse<ros2::GripperResult>>,
                                                check_answer<ros2::SpeedScalingFactor>, check_answer<ros2::Float64>};
  kChecks[input.byte() % kChecks.size()](input.rest());
  return 0;
}
