#include "services/agent/systemd_notifier.hpp"

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

std::string take_from_environment(const char* name) {
  const char* value = std::getenv(name);
  std::string text = value == nullptr ? "" : value;
  unsetenv(name);
  return text;
}

std::optional<std::int64_t> parsed(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

SystemdNotifier::SystemdNotifier() : address_(take_from_environment("NOTIFY_SOCKET")) {
  const auto watchdog = parsed(take_from_environment("WATCHDOG_USEC"));
  const std::string watched = take_from_environment("WATCHDOG_PID");
  const bool fits = address_.size() > 1 && address_.size() <= sizeof(sockaddr_un::sun_path);
  if (!fits || (address_.front() != '/' && address_.front() != '@')) return;
  if (address_.front() == '@') address_.front() = '\0';
  // A full queue must not block the loop: a lost notification is sent again.
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const bool ours = watched.empty() || parsed(watched) == getpid();
  if (watchdog && *watchdog > 0 && ours) interval_ = std::chrono::microseconds(*watchdog) / 2;
}

SystemdNotifier::~SystemdNotifier() {
  if (socket_ >= 0) close(socket_);
}

void SystemdNotifier::ready() {
  send("READY=1");
}

void SystemdNotifier::stopping() {
  send("STOPPING=1");
}

void SystemdNotifier::loop_turns(Clock::time_point now) {
  if (!interval_ || now < due_) return;
  due_ = now + *interval_;
  send("WATCHDOG=1");
}

void SystemdNotifier::send(std::string_view state) const {
  if (socket_ < 0) return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, address_.data(), address_.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  static_cast<void>(
      sendto(socket_, state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), size));
}

}  // namespace hecaton::services
