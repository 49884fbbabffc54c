#pragma once
/// C++ client of a running cell: goals, states, obstacles, faults, hold, resume, stop and speed.
///
/// Units are SI: metres, radians, seconds, kilograms. Poses are in the frame W of the cell unless stated otherwise. The
/// library does not print, does not exit, and installs no signal handler.
///
/// *Waiting.* Every function that waits takes a `Wait`: a time limit and a stop token that interrupts it.
///
/// *Threads.* All objects are handles to one shared connection. They are cheap to copy, and any thread may use them at
/// any time. Callbacks run one after the other in the thread of the connection. A callback must not throw and must not
/// call a function that waits: that function throws std::logic_error. A callback that holds a handle keeps the
/// connection open until another callback replaces it.
///
/// *Failures.* Functions throw exceptions derived from hecaton::Error; what() is one sentence. The outcome of a goal is
/// a value (`Outcome`), never an exception.

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

/// Base class of all exceptions of the library, except std::logic_error.
class HECATON_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// No cell answers, or the supervisor, world service, planner or driver that is needed does not answer.
class HECATON_API Unreachable : public Error {
 public:
  /// Why nothing answers, and what helps.
  struct Reason {
    std::string why;         ///< "no cell answers in DDS domain 42"
    std::string what_to_do;  ///< "start one with 'hecaton up CELL'"; empty: no advice
    std::string looked_for;  ///< "the nodes supervisor and supervisor@beta"
    bool no_cell = false;    ///< no node of the cell was found, and the advice is how to select one
  };
  explicit Unreachable(Reason reason);                            ///< what() is `why` and `what_to_do`
  [[nodiscard]] const Reason& reason() const { return reason_; }  ///< the parts of what()

 private:
  Reason reason_;
};

/// The supervisor rejects an order, or the world service rejects an edit. Nothing has changed.
class HECATON_API Rejected : public Error {
 public:
  explicit Rejected(Cause cause);                              ///< what() is the text of `cause`
  [[nodiscard]] const Cause& cause() const { return cause_; }  ///< for programs

 private:
  Cause cause_;
};

/// The world service is reachable, but has not answered within the time limit. The edit may have been made.
class HECATON_API NoAnswer : public Error {
 public:
  using Error::Error;
};

/// The stop token of a call requested a stop during its wait. The order or edit may have been carried out.
class HECATON_API Interrupted : public Error {
 public:
  using Error::Error;
};

/// An invalid argument: an invalid cell file, a domain out of range or with several cells, an unknown arm, or too many
/// joint positions.
class HECATON_API InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// Time limit and stop token of a call that waits. Converts from any duration: `goal.wait(20s)`.
class Wait {
 public:
  /// Waits for at most `time_limit`, or until `stop_token` requests a stop.
  template <class Rep, class Period>
  Wait(std::chrono::duration<Rep, Period> time_limit, std::stop_token stop_token = {})
      : limit(time_limit), stop(std::move(stop_token)) {}

  Seconds limit;         ///< 0, negative or NaN: the call does not wait
  std::stop_token stop;  ///< a stop request ends the wait at once
};

/// No time limit.
inline constexpr Seconds kForever{std::numeric_limits<double>::infinity()};
/// Default time limit of requests, orders and edits.
inline constexpr Seconds kAnswerLimit{2.0};
/// The same of an order to a gripper, which moves.
inline constexpr Seconds kGripperLimit{15.0};

/// A goal of one arm, as a future of its outcome. The destructor does not cancel the goal: the arm continues.
class HECATON_API Goal {
 public:
  /// Identifier of the goal, unique among the goals of the arm.
  [[nodiscard]] const std::string& id() const;
  [[nodiscard]] const std::string& arm() const;  ///< name of the arm
  /// The newest progress; empty until a planner has answered. Does not wait.
  [[nodiscard]] std::optional<Progress> progress() const;
  /// Calls `callback` with the newest progress, if there is any, and then with each later one. Replaces the earlier
  /// callback; an empty function removes it. A replaced callback may still run once during this call.
  void on_progress(std::function<void(const Progress&)> callback) const;
  /// Waits until the goal has ended, and returns its outcome so far when the wait ends earlier. Throws only
  /// std::logic_error in a callback.
  Outcome wait(const Wait& wait = kForever) const;
  /// Cancels the goal: the arm brakes. Does not wait: the outcome becomes kCancelled when the planner confirms it.
  /// Throws Unreachable when the message cannot be sent.
  void cancel() const;

 private:
  friend class Arm;
  friend class Cell;
  friend class client::Connection;
  Goal(std::shared_ptr<client::Connection> connection, std::shared_ptr<client::GoalRecord> record);
  std::shared_ptr<client::Connection> connection_;
  std::shared_ptr<client::GoalRecord> record_;
};

/// What a goal allows.
struct GoalOptions {
  Seconds time_limit = kForever;  ///< the planner ends the goal (kTimedOut) after this time since its acceptance
  // For a pose of the tool; not used by other goals.
  FreeRotation free_rotation = FreeRotation::kNone;  ///< kAll: a position in any orientation
  double position_tolerance = 1e-3;                  ///< of the reached position, 1e-5 to 1 [m]
  double orientation_tolerance = 8.72665e-3;         ///< of the reached orientation, 1e-4 to 3.2 [rad]; default 0.5°
};

/// A handle to one arm.
class HECATON_API Arm {
 public:
  [[nodiscard]] const std::string& name() const { return name_; }  ///< in the cell file

  /// Sends a goal: a named pose of the cell file, joint positions from base to tip [rad | m], or a pose of the tool
  /// frame in W. It replaces the present goal of the arm, also that of another client. Does not wait. The planner
  /// checks the goal: an invalid goal has the outcome kRejected. kReached means that the measured arm is at the goal.
  /// A pose is position and orientation for every arm, unless `options` leave a rotation free. An arm that cannot take
  /// the orientation rejects the goal with the nearest one (Progress::nearest). Throws Unreachable when the message
  /// cannot be sent, and InvalidArgument for too many joint positions and numbers that are not finite.
  Goal go_to(const std::string& named, const GoalOptions& options = {}) const;
  Goal go_to(const std::vector<double>& q, const GoalOptions& options = {}) const;  ///< joint positions
  /// Joint positions, as a list: `go_to({0, -1.2, 1.8})`.
  Goal go_to(std::initializer_list<double> q, const GoalOptions& options = {}) const {
    return go_to(std::vector<double>(q), options);
  }
  Goal go_to(const Pose& tool, const GoalOptions& options = {}) const;  ///< pose of the tool frame
  /// Sends a goal with a trajectory, as go_to(). The arm follows it from its start, which is at most 0.1 rad or m away;
  /// a first point of a later time begins at the arm. It slows down, waits and returns where something is near. With a
  /// path tolerance the goal ends (kCancelled, CauseKind::kPathTolerance) when the arm leaves the path. Throws
  /// Unreachable, and InvalidArgument for wrong numbers of values and numbers that are not finite.
  Goal follow(const Trajectory& trajectory, const GoalOptions& options = {}) const;

  /// The last measured state, with its age. The first call waits until a state has arrived. Throws Unreachable when no
  /// driver of the arm publishes states, and Interrupted.
  [[nodiscard]] ArmState state(const Wait& wait = kAnswerLimit) const;
  /// Progress of the arm's newest goal, of any client, as far as this connection has received it; Cell::status updates
  /// it. Does not wait.
  [[nodiscard]] std::optional<Progress> goal() const;

  /// Orders for this arm, as in Cell.
  void hold(const Wait& wait = kAnswerLimit) const;
  void resume(const Wait& wait = kAnswerLimit) const;  ///< ends hold and stop of this arm
  void stop(const Wait& wait = kAnswerLimit) const;    ///< as hold, latched until resume
  /// Sets the speed override of this arm, as Cell::set_speed.
  void set_speed(double speed, const Wait& wait = kAnswerLimit) const;

  /// Closes the gripper on what is between its fingers, which becomes part of the arm, or opens it and releases that
  /// where it is. The arm must stand. Returns when the gripper has arrived. Throws Rejected with the reason,
  /// Unreachable when the driver of the arm does not answer within the limit, Interrupted.
  void close_gripper(const GripOptions& options = {}, const Wait& wait = kGripperLimit) const;
  void open_gripper(const GripOptions& options = {}, const Wait& wait = kGripperLimit) const;  ///< the inverse
  /// Sets an output of the arm's device; of a simulated arm also an input. Throws as close_gripper.
  void set_signal(const std::string& name, double value, const Wait& wait = kAnswerLimit) const;
  /// Tells all planners where a joint outside the chain is, such as a finger without a gripper [rad | m]. Throws as
  /// close_gripper.
  void place_joint(const std::string& joint, double position, const Wait& wait = kAnswerLimit) const;
  /// The newest state of gripper and signals. Throws Unreachable when the arm has neither or its driver does not run,
  /// and Interrupted.
  [[nodiscard]] ToolState tool(const Wait& wait = kAnswerLimit) const;
  /// Waits until the signal has a value from `lowest` to `highest`. False: it had none within the limit. Throws
  /// Rejected when the arm has no such signal, and as tool().
  [[nodiscard]] bool wait_for_signal(const std::string& name, double lowest, double highest, const Wait& wait) const;

 private:
  friend class Cell;
  Arm(std::shared_ptr<client::Connection> connection, std::string name);
  std::shared_ptr<client::Connection> connection_;
  std::string name_;
};

/// The result of an order or an edit that was carried out.
struct Receipt {
  std::uint64_t edition = 0;  ///< number of edits of the scene so far; 0 for an order
  Cause warning;  ///< set when the process that carried it out cannot save it, and would lose it by a restart
};

/// What a recorder has saved.
struct SavedRecording {
  std::string host;  ///< of the recorder: its name in the cell file, else that of the machine
  std::string file;  ///< the newest one, on that host
};

/// The obstacles of a cell. The world service makes the edits; no supervisor is needed. An edit returns when it is
/// made. Edits throw Rejected for obstacles that a cell file may not have (name, size, contact with an arm),
/// Unreachable, NoAnswer and Interrupted.
class HECATON_API World {
 public:
  /// Adds an obstacle. `name` must be unique. `pose`: of the obstacle's frame in W. Throws InvalidArgument for a convex
  /// hull without volume.
  Receipt add(const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion = Static{},
              const Wait& wait = kAnswerLimit) const;
  /// The same, in the place of the obstacle with this name, if there is one. Arms avoid the former one until they see
  /// the new one.
  Receipt replace(const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion = Static{},
                  const Wait& wait = kAnswerLimit) const;
  /// Moves an obstacle to `pose` in W and ends its scripted motion.
  Receipt move(const std::string& name, const Pose& pose, const Wait& wait = kAnswerLimit) const;
  /// Removes an obstacle.
  Receipt remove(const std::string& name, const Wait& wait = kAnswerLimit) const;
  /// Attaches an obstacle to the tool of an arm at its present pose, at most 0.1 m from the tool: it becomes part of
  /// the arm.
  Receipt attach(const std::string& arm, const std::string& object, const Wait& wait = kAnswerLimit) const;
  /// Detaches an object at its present pose. Dynamic objects fall.
  Receipt detach(const std::string& arm, const std::string& object, const Wait& wait = kAnswerLimit) const;
  /// All obstacles, with their age. The first call waits until their states have arrived. Throws Unreachable and
  /// Interrupted.
  [[nodiscard]] std::vector<ObstacleState> obstacles(const Wait& wait = kAnswerLimit) const;

 private:
  friend class Cell;
  explicit World(std::shared_ptr<client::Connection> connection);
  std::shared_ptr<client::Connection> connection_;
};

/// Selects a cell.
struct ConnectOptions {
  std::optional<std::string> cell_file;  ///< path, for the name of the cell and its network; empty: any cell
  std::optional<int> domain;             ///< DDS domain; empty: HECATON_DOMAIN, the cell file's domain, or 42
};

/// A connection to a running cell. The destructor of the last handle waits until a planner has answered every goal, for
/// at most 2 s: otherwise a goal could be lost. Goals continue after it. A process can connect at least 3,700 times.
class HECATON_API Cell {
 public:
  /// Connects to the cell of a cell file. Returns when its supervisor or its world service is found. Throws
  /// Unreachable, InvalidArgument (cell file, domain) and Interrupted.
  [[nodiscard]] static Cell connect(const std::string& cell_file, const Wait& wait = kAnswerLimit);
  /// Connects to the cell that `options` select. Without a cell file, later calls throw InvalidArgument when several
  /// cells answer in the domain.
  [[nodiscard]] static Cell connect(const ConnectOptions& options, const Wait& wait = kAnswerLimit);
  /// A handle to an existing connection.
  explicit Cell(std::shared_ptr<client::Connection> connection);

  /// A handle to an arm. Throws InvalidArgument, with the names of all arms, for a name that is not among arms(). Does
  /// not wait, and does not check the name while arms() is empty: then a goal of an unknown arm stays unanswered, an
  /// order is rejected, a state is unreachable.
  [[nodiscard]] Arm arm(const std::string& name) const;
  /// Names of the arms as far as this connection knows them: those of the last status, else of the cell file. Empty:
  /// connected without a cell file, and no status has arrived. Does not wait.
  [[nodiscard]] std::vector<std::string> arms() const;
  [[nodiscard]] World world() const;  ///< handle to the obstacles

  /// Requests the status from the supervisor. Throws Unreachable, Interrupted, and InvalidArgument when several cells
  /// answer.
  [[nodiscard]] CellStatus status(const Wait& wait = kAnswerLimit) const;

  /// Orders for the whole cell. hold() brakes all arms and keeps their goals. stop() does the same and latches until
  /// resume(). Arms that were stopped by name or by their device must be resumed by name; resume() of an arm is
  /// rejected while the fault of its device lasts. All return when the supervisor has carried the order out. All throw
  /// Rejected, Unreachable (the order was not carried out), Interrupted, and InvalidArgument when several cells answer.
  Receipt hold(const Wait& wait = kAnswerLimit) const;
  Receipt resume(const Wait& wait = kAnswerLimit) const;  ///< ends hold and stop
  Receipt stop(const Wait& wait = kAnswerLimit) const;    ///< as hold, latched until resume
  /// The same orders for some arms; an empty list: the whole cell.
  Receipt hold(const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;
  Receipt resume(const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;  ///< ends hold and stop
  Receipt stop(const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;    ///< as hold, latched

  /// Sets the speed override: no joint moves faster than `speed`, 0.01 to 1, times its velocity limit. It takes effect
  /// at once, on a ramp within the acceleration limits; goals under way continue. It lasts until the next order, also
  /// after a failover. The lower of the cell's override and the arm's own is in force. Throws InvalidArgument for other
  /// values, and like hold().
  Receipt set_speed(double speed, const Wait& wait = kAnswerLimit) const;
  /// The same for some arms; an empty list: the override of the whole cell.
  Receipt set_speed(double speed, const std::vector<std::string>& arms, const Wait& wait = kAnswerLimit) const;

  /// Orders all recorders of the cell to save the last part that they keep, and the time after it that their
  /// `after_fault` says. No supervisor is needed. Throws Rejected when one cannot, such as without a disk; Unreachable
  /// when no recorder replies; Interrupted.
  std::vector<SavedRecording> save_recordings(const Wait& wait = kAnswerLimit) const;

  /// Faults that this connection has received. The first call subscribes to faults; status() updates them. Does not
  /// wait.
  [[nodiscard]] std::vector<Fault> faults() const;
  /// Calls `callback` with every present fault, and then with every fault that begins, changes or is cleared. It also
  /// gets recent cleared faults when the connection receives them. Replaces the earlier callback; an empty function
  /// removes it.
  void on_fault(std::function<void(const Fault&)> callback) const;

  /// Waits until all goals have ended. Returns their outcomes in the same order.
  std::vector<Outcome> wait_all(const std::vector<Goal>& goals, const Wait& wait) const;
  /// Evaluates `condition` in this thread, now and after every received message, until it is true. Returns false when
  /// the time limit has passed or the wait was interrupted.
  bool wait_until(const std::function<bool()>& condition, const Wait& wait) const;

 private:
  std::shared_ptr<client::Connection> connection_;
};

}  // namespace hecaton
