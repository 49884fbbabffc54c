// A serialised message of joint states, behind a byte: its writer, and its time after a good message.

#include "services/arm_driver/devices/ros2_control/joint_states.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(ros2_control)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  using device::Clock;
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.byte();
  const Clock::time_point begin(std::chrono::seconds(1000));
  const Clock::time_point later = begin + std::chrono::milliseconds(choice >> 1U);

  ros2::JointState good;
  good.header.stamp = {1'700'000'000, 0};
  good.name = {"base", "elbow", "wrist"};
  good.position = {0.1, 0.2, 0.3};
  device::ros2_control::JointStates states(good.name, std::chrono::milliseconds(50));
  bus::EndpointId writer;
  states.take(ros2::encoded(good), writer, begin);
  writer.bytes[0] = choice & 1U;
  states.take(input.rest(), writer, later);

  const device::JointState measured = states.measured();
  fuzz::require(measured.q.size() == measured.qd.size(), "each position has a velocity");
  fuzz::require(measured.q.allFinite() && measured.qd.allFinite(), "a measured state is finite");
  if (measured.q.size() > 0) fuzz::require(states.received() <= later, "no state comes from the future");
  fuzz::require(!bus::unprintable(states.complaint()), "a complaint is printable");
  const auto twice = states.twice_published(later);
  fuzz::require(!twice || (writer.bytes[0] == 1 && later - begin < std::chrono::milliseconds(50)),
                "a second writer is another one that publishes while the first does");
  return 0;
}
