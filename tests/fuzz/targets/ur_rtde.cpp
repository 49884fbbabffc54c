// What a controller of Universal Robots sends on RTDE. The first byte chooses the set-up and how often it is cut.

#include "services/arm_driver/devices/universal_robots/robot_state.hpp"
#include "services/arm_driver/devices/universal_robots/rtde_client.hpp"
#include "services/bus/wire_rules.hpp"
#include "tests/fuzz/loopback_server.hpp"

extern "C" int HECATON_FUZZ_TARGET(ur_rtde)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  using namespace hecaton::device::universal_robots;
  static fuzz::LoopbackServer robot(30004);
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.byte();
  RtdeSetup setup;
  setup.address = robot.address();
  if ((choice & 1U) != 0) setup.speed_slider = 0.5;
  RtdeClient client(setup, [](const auto&, const auto&) {});
  device::Clock::time_point now = device::Clock::now();
  client.open(now);
  robot.accept();
  while (!client.failed() && !input.empty()) {
    robot.send(fuzz::text_of(input.take((choice & 2U) != 0 ? 64 : 65536)));
    client.update(now += std::chrono::milliseconds(2));
  }
  client.update(now += std::chrono::milliseconds(2));
  if (client.failed()) {
    fuzz::require_sentence(client.error());
    fuzz::require(!bus::unprintable(client.error()), "a sentence for a message of the driver is printable");
  }
  if (client.data()) {
    for (const double q : client.data()->q) fuzz::require(std::isfinite(q), "measured positions are finite");
    static_cast<void>(condition_of(*client.data(), "arm"));
  }
  client.close();
  robot.close();
  return 0;
}
