#pragma once
/// The connection of a Python program to a cell. The classes of the package `hecaton` share it.

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include <hecaton/client.hpp>
#include <unistd.h>

#include "services/python/event_queue.hpp"
#include "services/python/interruptible.hpp"

namespace hecaton::python {

/// The session is closed.
class Closed : public Error {
 public:
  Closed() : Error("the connection to the cell is closed: connect again") {}
};

/// The session belongs to the parent of this process. A child of fork() has no thread that could serve it.
class Forked : public Error {
 public:
  Forked()
      : Error(
            "the connection to the cell belongs to the parent of this process: connect after os.fork(), or start the "
            "child by multiprocessing with the method 'spawn'") {}
};

/// Owns all handles to a connection, so that close() ends it although Python objects remain. All functions need the
/// interpreter lock, except the destructor's and close()'s work, for which they release it. Callable from any thread.
class Session {
 public:
  /// Throws like Cell::connect.
  [[nodiscard]] static std::shared_ptr<Session> connect(const ConnectOptions& options, Seconds limit);
  ~Session() { close(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Runs `work(cell, wait)`, which may wait. Ends at close() (Closed) and at a signal.
  template <class Work>
  auto call(Seconds limit, Work work) {
    const Call counted(*this);  // to the end of the last wait for the interpreter lock, see close()
    const Unlocked<Cell> cell(this->cell());
    try {
      return run_interruptibly(closing_.get_token(), [&](std::stop_token stop) {
        return work(*cell, Wait{limit, std::move(stop)});
      });
    } catch (const Interrupted&) {
      if (closing_.stop_requested()) throw Closed();
      throw;
    }
  }
  /// The same for work that usually does not wait: tries it without waiting first, in this thread.
  template <class Work>
  auto look(Seconds limit, Work work) {
    {
      const Unlocked<Cell> cell(this->cell());
      const pybind11::gil_scoped_release unlocked;
      try {
        return work(*cell, Wait{Seconds::zero()});
      } catch (const Unreachable&) {
        if (!(limit > Seconds::zero())) throw;
      }
    }
    return call(limit, work);
  }

  /// Names of the arms as far as the connection knows them. Does not wait.
  [[nodiscard]] std::vector<std::string> arms() const;
  /// Returns when the cell has an arm `name`. Does not wait for a name that the connection knows; otherwise it requests
  /// the status, to be sure. Throws UnknownName. When no supervisor answers within the limit, a connection without a
  /// cell file accepts any name.
  void require_arm(const std::string& name, Seconds limit);
  /// Sends a goal with `go(arm)`. Returns its identifier.
  template <class Go>
  std::string send(const std::string& arm, Go go) {
    const Unlocked<Cell> cell(this->cell());
    const pybind11::gil_scoped_release unlocked;
    return keep(go(cell->arm(arm)));
  }
  /// The functions of a sent goal. Throw Closed.
  [[nodiscard]] Outcome wait(const std::string& goal, Seconds limit);
  [[nodiscard]] std::optional<Progress> progress(const std::string& goal) const;
  void cancel(const std::string& goal) const;
  /// Queues the newest progress and each later one.
  void watch(const std::string& goal) const;
  /// Drops the handle to the goal. The arm continues.
  void forget(const std::string& goal);

  /// Queues the present faults and each later one.
  void watch_faults() const;
  [[nodiscard]] std::vector<Fault> faults() const;
  /// Waits for the next event, without the interpreter lock. Empty: the session is closed.
  [[nodiscard]] std::optional<Event> next_event() const;

  /// Ends all waits and the connection; waits until a planner has answered each goal, for at most 2 s. Idempotent.
  void close();
  [[nodiscard]] bool closed() const { return closing_.stop_requested(); }

 private:
  /// A call of a thread, for close().
  class Call {
   public:
    explicit Call(Session& session);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    Session& session_;
  };

  explicit Session(Cell cell) : process_(getpid()), cell_(std::move(cell)) {}
  /// Throws Forked.
  void require_own_process() const;
  void leave_to_parent();
  [[nodiscard]] Cell cell() const;
  [[nodiscard]] Goal goal(const std::string& id) const;
  std::string keep(const Goal& goal);

  const pid_t process_;       ///< that connected
  mutable std::mutex mutex_;  // guards all that follows, but events_ and closing_; no thread waits for Python with it
  std::condition_variable ended_;
  std::optional<Cell> cell_;                     ///< empty: closed
  std::unordered_map<std::string, Goal> goals_;  ///< of living Python objects
  std::map<std::thread::id, int> calls_;         ///< calls that may wait, by thread
  std::shared_ptr<EventQueue> events_ = std::make_shared<EventQueue>();
  std::stop_source closing_;
};

/// A sent goal of a Python object.
class NativeGoal {
 public:
  NativeGoal(std::shared_ptr<Session> session, std::string id) : session_(std::move(session)), id_(std::move(id)) {}
  ~NativeGoal() {
    if (session_) session_->forget(id_);
  }
  NativeGoal(NativeGoal&&) = default;
  NativeGoal& operator=(NativeGoal&&) = delete;
  NativeGoal(const NativeGoal&) = delete;
  NativeGoal& operator=(const NativeGoal&) = delete;

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] Session& session() const { return *session_; }

 private:
  std::shared_ptr<Session> session_;
  std::string id_;
};

}  // namespace hecaton::python
