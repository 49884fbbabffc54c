#pragma once
/// SIGTERM and SIGINT end a service's loop at once, and destructors run as after a normal return.

namespace hecaton::bus {
class Mailbox;
}

namespace hecaton::services {

/// Only one may exist at a time. Thread-safe after construction.
class ShutdownSignal {
 public:
  enum class Second {
    kIgnored,
    kEndsProcess,  ///< a second signal, more than 200 ms after the first, exits at once with 128 + signal
  };
  /// Takes over SIGTERM and SIGINT of the process and ignores SIGPIPE. Call it before any thread starts.
  explicit ShutdownSignal(Second second = Second::kIgnored);
  ~ShutdownSignal();
  ShutdownSignal(const ShutdownSignal&) = delete;
  ShutdownSignal& operator=(const ShutdownSignal&) = delete;

  [[nodiscard]] bool requested() const;
  /// The first signal; 0 before it and after request().
  [[nodiscard]] int signal() const;
  /// A signal wakes this mailbox. It must outlive this object or be replaced by null.
  void wake(bus::Mailbox* mailbox);
  /// Acts as if a signal had arrived.
  void request();
};

}  // namespace hecaton::services
