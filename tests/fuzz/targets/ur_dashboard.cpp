// What a controller of Universal Robots answers on its dashboard.

#include "services/arm_driver/devices/universal_robots/dashboard.hpp"
#include "tests/fuzz/loopback_server.hpp"

extern "C" int HECATON_FUZZ_TARGET(ur_dashboard)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  static fuzz::LoopbackServer robot(29999);
  fuzz::Input input(data, size);
  device::universal_robots::Dashboard dashboard;
  device::Clock::time_point now = device::Clock::now();
  dashboard.open(robot.address(), now);
  robot.accept();
  std::size_t asked = 0;
  std::size_t answered = 0;
  while (!input.empty()) {
    robot.send(fuzz::text_of(input.take(256)));
    dashboard.update(now += std::chrono::milliseconds(2));
    if (dashboard.is_open() && asked < 8) {
      dashboard.send("robotmode", now);
      ++asked;
    }
    while (const auto answer = dashboard.take()) {
      ++answered;
      fuzz::require(answer->command == "robotmode" && answer->text.find('\n') == std::string::npos,
                    "an answer is a line to a command");
    }
  }
  fuzz::require(answered <= asked, "no answer without a command");
  dashboard.close();
  robot.close();
  return 0;
}
