#pragma once
/// A person orders a recorder by the signal SIGUSR1 to save what it keeps.

#include <atomic>
#include <csignal>

namespace hecaton::services::recorder {

/// Why a recording is saved, for people.
inline constexpr const char* kOrdered = "a person ordered it";

/// Only one may exist at a time. Create it before any thread starts: before, the signal ends the process.
class SaveSignal {
 public:
  SaveSignal() {
    ordered_.store(false);
    handle([](int) { ordered_.store(true); });
  }
  ~SaveSignal() { handle(SIG_IGN); }
  SaveSignal(const SaveSignal&) = delete;
  SaveSignal& operator=(const SaveSignal&) = delete;

  /// The signal has arrived since the last call.
  [[nodiscard]] static bool take() { return ordered_.exchange(false); }

 private:
  static void handle(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(SIGUSR1, &action, nullptr);
  }

  static inline std::atomic<bool> ordered_{false};
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may use lock-free atomics only");
};

}  // namespace hecaton::services::recorder
