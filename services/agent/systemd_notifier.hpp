#pragma once
/// Notifies systemd, if it has started the agent, that the agent is ready, that its loop turns, and that it ends
/// (protocol of sd_notify(3): datagrams to $NOTIFY_SOCKET). Without systemd all calls do nothing.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace hecaton::services {

class SystemdNotifier {
 public:
  using Clock = std::chrono::steady_clock;

  /// Takes the variables out of the environment, so that services of the agent do not notify systemd.
  SystemdNotifier();
  ~SystemdNotifier();
  SystemdNotifier(const SystemdNotifier&) = delete;
  SystemdNotifier& operator=(const SystemdNotifier&) = delete;

  void ready();
  void stopping();
  /// Call it in every turn of the loop. Notifies twice within the time of systemd's watchdog ($WATCHDOG_USEC).
  void loop_turns(Clock::time_point now);

 private:
  void send(std::string_view state) const;

  std::string address_;  ///< of the socket; empty: none; begins with '\0': abstract
  int socket_ = -1;
  std::optional<Clock::duration> interval_;
  Clock::time_point due_{};
};

}  // namespace hecaton::services
