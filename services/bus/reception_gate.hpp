#pragma once
/// Lets this process change the endpoints of a participant while Fast DDS handles no datagram for it. Private to
/// services/bus; standard library only.

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Threads that give datagrams to Fast DDS pass it; a thread that changes endpoints closes it. Thread-safe.
class ReceptionGate {
 public:
  /// Inside while it lives. Its constructor waits while the gate is closed.
  class Pass {
   public:
    explicit Pass(ReceptionGate& gate) : gate_(gate) { gate_.enter(); }
    ~Pass() { gate_.leave(); }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;

   private:
    ReceptionGate& gate_;
  };

  /// Closed while it lives. Its constructor waits until no thread is inside, at most for `limit`: a thread inside may
  /// wait for the one that closes. Not in a thread that is inside.
  class Closure {
   public:
    Closure(ReceptionGate& gate, Clock::duration limit) : gate_(gate), quiet_(gate_.close(limit)) {}
    ~Closure() { gate_.open(); }
    Closure(const Closure&) = delete;
    Closure& operator=(const Closure&) = delete;

    [[nodiscard]] bool quiet() const { return quiet_; }  ///< no thread is inside

   private:
    ReceptionGate& gate_;
    const bool quiet_;
  };

 private:
  void enter() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closures_ == 0; });
    ++inside_;
  }
  void leave() {
    const std::scoped_lock lock(mutex_);
    if (--inside_ == 0 && closures_ > 0) changed_.notify_all();
  }
  bool close(Clock::duration limit) {
    std::unique_lock lock(mutex_);
    ++closures_;
    return changed_.wait_for(lock, limit, [this] { return inside_ == 0; });
  }
  void open() {
    const std::scoped_lock lock(mutex_);
    if (--closures_ == 0) changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  int inside_ = 0;
  int closures_ = 0;
};

}  // namespace hecaton::bus
