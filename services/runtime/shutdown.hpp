#pragma once
/// SIGTERM and SIGINT end a service's loop at once, and destructors run as after a normal return.

namespace hecaton::bus {
class Mailbox;
}

namespace hecaton::services {

/// Only one may exist at a time. Thread-safe after construction.
class ShutdownSignal {
 public:
  /// Takes over SIGTERM and SIGINT of the process and ignores SIGPIPE. Call it before any thread starts.
  ShutdownSignal();
  ~ShutdownSignal();
  ShutdownSignal(const ShutdownSignal&) = delete;
  ShutdownSignal& operator=(const ShutdownSignal&) = delete;

  [[nodiscard]] bool requested() const;
  /// A signal wakes this mailbox. It must outlive this object or be replaced by null.
  void wake(bus::Mailbox* mailbox);
  /// Acts as if a signal had arrived.
  void request();
};

}  // namespace hecaton::services
