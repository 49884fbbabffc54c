// Notifications of systemd, received at the other end of a socket.
#include "services/agent/systemd_notifier.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

/// In place of systemd: an abstract socket of this test.
class SystemdNotifierTest : public testing::Test {
 protected:
  SystemdNotifierTest() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path + 1, name_.data(), name_.size());
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name_.size());
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), size), 0);
    setenv("NOTIFY_SOCKET", ("@" + name_).c_str(), 1);
    setenv("WATCHDOG_USEC", "2000000", 1);
    setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  }
  ~SystemdNotifierTest() override {
    close(socket_);
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  }

  /// The next notification; empty: none.
  std::string heard() const {
    std::array<char, 64> text{};
    const ssize_t size = recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  const std::string name_ = "hecaton-service-notifier-test-" + std::to_string(getpid());
  const int socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(SystemdNotifierTest, NotifiesThatTheAgentIsReadyAndEnds) {
  SystemdNotifier notifier;
  EXPECT_EQ(heard(), "");
  notifier.ready();
  EXPECT_EQ(heard(), "READY=1");
  notifier.stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST_F(SystemdNotifierTest, NotifiesTwiceWithinTheWatchdogTime) {
  SystemdNotifier notifier;
  const SystemdNotifier::Clock::time_point begin{100s};
  int said = 0;
  for (auto now = begin; now < begin + 10s; now += 10ms) {
    notifier.loop_turns(now);
    while (heard() == "WATCHDOG=1") ++said;
  }
  EXPECT_EQ(said, 10);
}

TEST_F(SystemdNotifierTest, RemovesItsVariablesFromTheEnvironment) {
  const SystemdNotifier notifier;
  for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) EXPECT_EQ(getenv(name), nullptr) << name;
}

TEST_F(SystemdNotifierTest, SendsNoWatchdogNotificationForAnotherProcess) {
  setenv("WATCHDOG_PID", "1", 1);
  SystemdNotifier notifier;
  notifier.loop_turns(SystemdNotifier::Clock::time_point{100s});
  EXPECT_EQ(heard(), "");
}

TEST_F(SystemdNotifierTest, DoesNothingWithoutSystemd) {
  for (const char* address : {"", "@", "relative/path", "/no/such/socket"}) {
    setenv("NOTIFY_SOCKET", address, 1);
    setenv("WATCHDOG_USEC", "soon", 1);
    SystemdNotifier notifier;
    notifier.ready();
    notifier.loop_turns(SystemdNotifier::Clock::time_point{100s});
  }
  EXPECT_EQ(heard(), "");
}

}  // namespace
}  // namespace hecaton::services
