// The agent's words to systemd, heard at the other end of a socket.
#include "services/agent/service_manager.hpp"

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

/// Stands for systemd: an abstract socket of this test.
class ServiceManagerTest : public testing::Test {
 protected:
  ServiceManagerTest() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path + 1, name_.data(), name_.size());
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name_.size());
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), size), 0);
    setenv("NOTIFY_SOCKET", ("@" + name_).c_str(), 1);
    setenv("WATCHDOG_USEC", "2000000", 1);
    setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  }
  ~ServiceManagerTest() override {
    close(socket_);
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  }

  /// What was said and not heard yet; empty: nothing.
  std::string heard() const {
    std::array<char, 64> text{};
    const ssize_t size = recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  const std::string name_ = "hecaton-service-manager-test-" + std::to_string(getpid());
  const int socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(ServiceManagerTest, HearsThatTheAgentIsReadyAndEnds) {
  ServiceManager manager;
  EXPECT_EQ(heard(), "");
  manager.ready();
  EXPECT_EQ(heard(), "READY=1");
  manager.stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST_F(ServiceManagerTest, HearsTwiceInTheWatchdogsTimeThatTheLoopTurns) {
  ServiceManager manager;
  const ServiceManager::Clock::time_point begin{100s};
  int said = 0;
  for (auto now = begin; now < begin + 10s; now += 10ms) {
    manager.turns(now);
    while (heard() == "WATCHDOG=1") ++said;
  }
  EXPECT_EQ(said, 10);
}

TEST_F(ServiceManagerTest, LeavesNothingForWhatTheAgentStarts) {
  const ServiceManager manager;
  for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) EXPECT_EQ(getenv(name), nullptr) << name;
}

TEST_F(ServiceManagerTest, KeepsStillWhenAnotherProcessIsWatched) {
  setenv("WATCHDOG_PID", "1", 1);
  ServiceManager manager;
  manager.turns(ServiceManager::Clock::time_point{100s});
  EXPECT_EQ(heard(), "");
}

TEST_F(ServiceManagerTest, IsNotMissedWhereThereIsNone) {
  for (const char* address : {"", "@", "relative/path", "/no/such/socket"}) {
    setenv("NOTIFY_SOCKET", address, 1);
    setenv("WATCHDOG_USEC", "soon", 1);
    ServiceManager manager;
    manager.ready();
    manager.turns(ServiceManager::Clock::time_point{100s});
  }
  EXPECT_EQ(heard(), "");
}

}  // namespace
}  // namespace hecaton::services
