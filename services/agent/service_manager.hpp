#pragma once
/// What the agent tells systemd, which may have started it: that it is ready, that its loop turns, that it ends
/// (sd_notify(3)'s protocol: datagrams to $NOTIFY_SOCKET). Nothing happens where nobody listens.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace hecaton::services {

class ServiceManager {
 public:
  using Clock = std::chrono::steady_clock;

  /// From the environment, where it is taken from: what the agent starts is not who systemd waits for.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready();
  void stopping();
  /// From every turn of the loop. Tells it twice in the time after which the watchdog would end us ($WATCHDOG_USEC).
  void turns(Clock::time_point now);

 private:
  void tell(std::string_view state) const;

  std::string address_;  ///< empty: nobody listens; begins with '\0': an abstract socket
  int socket_ = -1;
  std::optional<Clock::duration> interval_;
  Clock::time_point due_{};
};

}  // namespace hecaton::services
