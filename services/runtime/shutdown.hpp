#pragma once
/// SIGTERM and SIGINT end a service's loop at once; destructors then run as after any other return.

namespace hecaton::bus {
class Mailbox;
}

namespace hecaton::services {

class ShutdownSignal {
 public:
  /// Takes over SIGTERM and SIGINT of the process (and ignores SIGPIPE). One at a time, before any thread is started.
  ShutdownSignal();
  ~ShutdownSignal();
  ShutdownSignal(const ShutdownSignal&) = delete;
  ShutdownSignal& operator=(const ShutdownSignal&) = delete;

  [[nodiscard]] bool requested() const;
  /// Wakes the mailbox when a signal comes. It must outlive this, or be replaced by null.
  void wake(bus::Mailbox* mailbox);
  /// As if a signal had come.
  void request();
};

}  // namespace hecaton::services
