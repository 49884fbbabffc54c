// What connects to the port for set-points of a Universal Robots arm, and what it sends there: the device drops it.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/arm_driver/devices/universal_robots/program.hpp"
#include "services/arm_driver/devices/universal_robots/tcp.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace hecaton;

/// A robot that connects from 127.0.0.1, or another machine from 127.0.0.9.
int connected(int port, bool is_other) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const linger at_once{1, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  ::inet_pton(AF_INET, is_other ? "127.0.0.9" : "127.0.0.1", &own.sin_addr);
  fuzz::require(::bind(socket, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0, "an address of this machine");
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
  fuzz::require(::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0, "the device listens");
  return socket;
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(ur_reverse)(const std::uint8_t* data, std::size_t size) {
  using namespace device::universal_robots;
  static TcpListener listener;
  static const int port = [] {
    int free = 40'000 + ::getpid() % 20'000;
    while (listener.listen(free)) ++free;
    return free;
  }();
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.byte();
  const bool is_other = (choice & 1U) != 0;
  const int robot = connected(port, is_other);
  auto accepted = listener.accept("127.0.0.1");
  fuzz::require(accepted.has_value() != is_other, "the robot alone is connected");
  if (accepted) {
    TcpConnection reverse;
    reverse.adopt(std::move(*accepted));
    const device::JointState set_point{device::JointVector::Zero(6), device::JointVector::Zero(6)};
    const auto timeout = std::chrono::milliseconds(20);
    while (reverse.is_open() && !input.empty()) {
      const std::string bytes = fuzz::text_of(input.take(1U + choice));
      (void)!::send(robot, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      reverse.send(set_point_packet(set_point, timeout, timeout));
      reverse.update();
      reverse.received().clear();
    }
    if ((choice & 2U) != 0) {
      ::shutdown(robot, SHUT_WR);
      reverse.update();
      fuzz::require(!reverse.is_open() && !reverse.error().empty(), "a closed connection has a reason");
    }
  }
  ::close(robot);
  return 0;
}
