#pragma once
/// C++ client of a running cell: goals, states, obstacles, faults, hold, resume and stop.
///
/// Nothing here prints, exits or installs a signal handler. Every call that waits takes a time limit and can be
/// interrupted. A program that ends leaves its goals running and nothing else behind.
///
/// Threads: every object may be used from any thread at the same time, and copies are cheap handles to one connection.
/// Callbacks run one after the other in the connection's own thread; they must not throw, and may not call anything
/// that waits (it throws std::logic_error). A callback that holds a handle keeps the connection alive until another
/// callback replaces it.
///
/// Failures: calls throw what is derived from hecaton::Error, with one sentence in what(). What becomes of a goal is a
/// value (Outcome), never an exception.

#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <hecaton/types.hpp>

namespace hecaton {

namespace client {
class Connection;
struct GoalRecord;
}  // namespace client

class HECATON_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// No cell, or not the part of it that is needed, answers.
class HECATON_API Unreachable : public Error {
 public:
  struct Reason {
    std::string why;         ///< "no cell answers in DDS domain 42"
    std::string what_to_do;  ///< "start one with 'hecaton up CELL'"; empty: nothing that helps is known
    std::string looked_for;  ///< "the nodes supervisor and supervisor@beta"
  };
  explicit Unreachable(Reason reason);
  [[nodiscard]] const Reason& reason() const { return reason_; }

 private:
  Reason reason_;
};

/// The supervisor or the world refuses an order or an edit; nothing has changed.
class HECATON_API Rejected : public Error {
 public:
  explicit Rejected(Cause cause);
  [[nodiscard]] const Cause& cause() const { return cause_; }

 private:
  Cause cause_;
};

/// A part of the cell is there, but has not answered within the time limit; what was asked may have been done.
class HECATON_API NoAnswer : public Error {
 public:
  using Error::Error;
};

/// The stop token of a waiting call asked for its end; what was asked may have been done.
class HECATON_API Interrupted : public Error {
 public:
  using Error::Error;
};

/// An argument that cannot be: an arm that the cell does not have, a domain out of range, two cells where one is meant.
class HECATON_API InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// How long a call may wait, and what interrupts it. Converts from any duration: `goal.wait(20s)`.
class Wait {
 public:
  template <class Rep, class Period>
  Wait(std::chrono::duration<Rep, Period> time_limit, std::stop_token stop_token = {})
      : limit(time_limit), stop(std::move(stop_token)) {}

  Seconds limit;         ///< not above 0: does not wait
  std::stop_token stop;  ///< a request on it ends the wait at once
};

inline constexpr Seconds kForever{std::numeric_limits<double>::infinity()};
/// Of questions, orders and edits.
inline constexpr Seconds kAnswerLimit{2.0};

/// One goal of one arm, as a future. Its end cancels nothing: the arm goes on.
class HECATON_API Goal {
 public:
  /// Name of the goal, unique for the arm.
  [[nodiscard]] const std::string& id() const;
  [[nodiscard]] const std::string& arm() const;
  /// The newest; nothing while no planner has answered. Does not wait.
  [[nodiscard]] std::optional<Progress> progress() const;
  /// `callback` gets the newest progress now, if there is any, and then each one that arrives; replaces an earlier
  /// callback, an empty one ends them. It may still run once while this call replaces it from another thread.
  void on_progress(std::function<void(const Progress&)> callback) const;
  /// Waits for the end of the goal. Never throws for what becomes of the goal or of the cell.
  Outcome wait(const Wait& wait = kForever) const;
  /// Withdraws the goal; the arm brakes. Does not wait: the outcome becomes kCancelled when the planner confirms it.
  void cancel() const;

 private:
  friend class Arm;
  friend class Cell;
  Goal(std::shared_ptr<client::Connection> connection, std::shared_ptr<client::GoalRecord> record);
  std::shared_ptr<client::Connection> connection_;
  std::shared_ptr<client::GoalRecord> record_;
};

struct GoalOptions {
  Seconds time_limit = kForever;  ///< after which the planner gives the goal up
};

class HECATON_API Arm {
 public:
  [[nodiscard]] const std::string& name() const { return name_; }

  /// A goal: a pose that the cell file names, joint positions from base to tip [rad | m], or a pose of the tool frame.
  /// Replaces an earlier goal of the arm, of any client. Returns at once. The planner judges the goal: a bad one
  /// has the outcome kRejected.
  Goal go_to(const std::string& named, const GoalOptions& options = {}) const;
  Goal go_to(const std::vector<double>& q, const GoalOptions& options = {}) const;
  Goal go_to(std::initializer_list<double> q, const GoalOptions& options = {}) const {
    return go_to(std::vector<double>(q), options);
  }
  Goal go_to(const Pose& tool, const GoalOptions& options = {}) const;

  /// As last measured, with its age; the first call waits until a state has arrived. Throws Unreachable: no driver of
  /// such an arm is heard.
  [[nodiscard]] ArmState state(const Wait& wait = kAnswerLimit) const;
  /// The newest goal of the arm that is known here, of any client; Cell::status brings it up to date. Does not wait.
  [[nodiscard]] std::optional<Progress> goal() const;

  /// As in Cell, for this arm alone.
  void hold(const Wait& wait = kAnswerLimit) const;
  void resume(const Wait& wait = kAnswerLimit) const;
  void stop(const Wait& wait = kAnswerLimit) const;

 private:
  friend class Cell;
  Arm(std::shared_ptr<client::Connection> connection, std::string name);
  std::shared_ptr<client::Connection> connection_;
  std::string name_;
};

/// What was done.
struct Receipt {
  std::uint64_t edition = 0;  ///< of the scene afterwards; grows with every edit
  Cause warning;              ///< done, but it would be lost with the process that did it
};

/// The obstacles of a cell. Edits go to the world service itself and need no supervisor. All throw Rejected (the rules
/// of the cell file: names, sizes, nothing on top of an arm), Unreachable, NoAnswer and Interrupted.
class HECATON_API World {
 public:
  Receipt add(const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion = Static{},
              const Wait& wait = kAnswerLimit) const;
  /// Ends a scripted motion.
  Receipt move(const std::string& name, const Pose& pose, const Wait& wait = kAnswerLimit) const;
  Receipt remove(const std::string& name, const Wait& wait = kAnswerLimit) const;
  /// Fixes an object, at most 0.1 m from the tool, where it is now: it becomes part of the arm.
  Receipt attach(const std::string& arm, const std::string& object, const Wait& wait = kAnswerLimit) const;
  /// Lets the object go where it is now.
  Receipt detach(const std::string& arm, const std::string& object, const Wait& wait = kAnswerLimit) const;
  /// All of them, with their age; the first call waits until the world's states have arrived.
  [[nodiscard]] std::vector<ObstacleState> obstacles(const Wait& wait = kAnswerLimit) const;

 private:
  friend class Cell;
  explicit World(std::shared_ptr<client::Connection> connection);
  std::shared_ptr<client::Connection> connection_;
};

/// Where a cell is to be found.
struct ConnectOptions {
  std::optional<std::string> cell_file;  ///< its network settings and name; otherwise any cell of the domain
  std::optional<int> domain;             ///< DDS domain; otherwise HECATON_DOMAIN, the cell file's, or 42
};

/// A connection to a running cell. The last handle's end waits for at most 2 s until a planner has answered each goal
/// that was given through it, so that none is lost. A process may connect again, at least 3,700 times.
class HECATON_API Cell {
 public:
  /// Joins the cell of a cell file. Returns as soon as its supervisor or its world is found. Throws Unreachable,
  /// InvalidArgument (the file, the domain), Interrupted.
  [[nodiscard]] static Cell connect(const std::string& cell_file, const Wait& wait = kAnswerLimit);
  /// The same; without a cell file any cell, and InvalidArgument when several answer.
  [[nodiscard]] static Cell connect(const ConnectOptions& options, const Wait& wait = kAnswerLimit);
  /// A handle to a connection that exists.
  explicit Cell(std::shared_ptr<client::Connection> connection);

  /// Does not check the name: the first goal, order or state of an unknown arm says so.
  [[nodiscard]] Arm arm(const std::string& name) const;
  [[nodiscard]] World world() const;

  /// Asks the supervisor. Throws Unreachable, Interrupted.
  [[nodiscard]] CellStatus status(const Wait& wait = kAnswerLimit) const;

  /// Orders for the whole cell. hold brakes and keeps goals; stop does so until it is resumed; resume leaves alone arms
  /// that were stopped by name. Return when the supervisor has carried the order out; the warning of the receipt
  /// says when it would be lost with the supervisor's process. Throw Rejected, Unreachable (nothing was obeyed),
  /// Interrupted.
  Receipt hold(const Wait& wait = kAnswerLimit) const;
  Receipt resume(const Wait& wait = kAnswerLimit) const;
  Receipt stop(const Wait& wait = kAnswerLimit) const;
  /// The same for some arms; none: the whole cell.
  Receipt hold(const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;
  Receipt resume(const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;
  Receipt stop(const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;

  /// Faults as told so far; the first call begins to listen, status() brings them up to date. Does not wait.
  [[nodiscard]] std::vector<Fault> faults() const;
  /// `callback` gets every fault that lasts now, that begins and that is cleared, and those of the recent past as they
  /// become known; replaces an earlier callback, an empty one ends them.
  void on_fault(std::function<void(const Fault&)> callback) const;

  /// Until all of them have ended; outcomes in the same order.
  std::vector<Outcome> wait_all(const std::vector<Goal>& goals, const Wait& wait) const;
  /// Evaluates `condition` in this thread now and after everything that arrives, until it is true. False: the time
  /// limit passed, or the wait was interrupted.
  bool wait_until(const std::function<bool()>& condition, const Wait& wait) const;

 private:
  std::shared_ptr<client::Connection> connection_;
};

}  // namespace hecaton
