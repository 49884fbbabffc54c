#pragma once
/// Values of the client library: poses, shapes, states, causes. Lengths in metres, angles in radians, times in seconds,
/// masses in kilograms; W is the cell's frame. Values own what they hold and may be copied to any thread.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <hecaton/enums.hpp>

#define HECATON_API __attribute__((visibility("default")))

namespace hecaton {

using Seconds = std::chrono::duration<double>;

/// Why something is as it is. Programs decide on `kind` and `subject`; `text` is for people and may change at any time.
struct Cause {
  CauseKind kind = CauseKind::kNone;
  std::string subject;  ///< node, host, arm, obstacle, joint or link; empty: nothing in particular
  std::string text;     ///< one sentence; empty only when there is nothing to explain

  /// There is something to explain.
  explicit operator bool() const { return kind != CauseKind::kNone; }
};

struct Vector3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

/// A position and a rotation, of a body's frame in W unless a field says otherwise.
struct HECATON_API Pose {
  Vector3 position;                                    ///< [m]
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};  ///< unit quaternion w, x, y, z

  /// Without rotation.
  [[nodiscard]] static Pose xyz(double x, double y, double z) { return {{x, y, z}}; }
  /// Roll, pitch and yaw are about the fixed axes x, y and z, in this order, as in URDF [rad].
  [[nodiscard]] static Pose xyz_rpy(double x, double y, double z, double roll, double pitch, double yaw);
};

// Shapes, centred on the obstacle's frame; axes along z.
struct Box {
  double x, y, z;  ///< full sizes [m]
};
struct Sphere {
  double radius;  ///< [m]
};
struct Cylinder {
  double radius, height;  ///< [m]
};
struct Capsule {
  double radius, length;  ///< between the centres of the caps [m]
};
using Shape = std::variant<Box, Sphere, Cylinder, Capsule>;

// Motions of obstacles, from the pose at which an obstacle is added.
struct Static {};
/// Along a straight line; starts again after `length`.
struct Conveyor {
  Vector3 velocity;  ///< in W [m/s]
  double length;     ///< [m]
};
/// Back and forth along a line.
struct Sine {
  Vector3 amplitude;  ///< in W [m]
  Seconds period;
};
/// About an axis along z of W.
struct Circle {
  Vector3 centre;        ///< in W [m]
  double angular_speed;  ///< [rad/s]
};
/// Falls and is pushed.
struct Dynamic {
  double mass;  ///< [kg]
};
using Motion = std::variant<Static, Conveyor, Sine, Circle, Dynamic>;

/// An obstacle as the world knows it now.
struct ObstacleState {
  std::string name;
  Pose pose;                               ///< in W
  Vector3 velocity;                        ///< of the frame's origin, in W [m/s]
  std::optional<std::string> attached_to;  ///< the arm that carries it
  Seconds age{};                           ///< since the state arrived, on this machine's clock
};

/// An arm as its driver measured it.
struct ArmState {
  ArmMode mode = ArmMode::kStarting;
  Cause cause;                       ///< why it brakes or stands
  std::vector<double> q;             ///< joint positions, base to tip [rad | m]
  std::vector<double> qd;            ///< joint velocities [rad/s | m/s]
  std::vector<std::string> carried;  ///< objects attached to the tool
  Seconds age{};                     ///< since the state arrived; in a CellStatus: at the supervisor
};

/// The two bodies whose distance limits the motion.
struct Binding {
  std::string own;        ///< "north/forearm"
  std::string other;      ///< "west/wrist" or "pallet"
  double distance = 0.0;  ///< [m]
};

/// How far a goal is.
struct Progress {
  std::string arm;
  std::string goal;  ///< unique for the arm
  GoalState state = GoalState::kAccepted;
  Cause cause;                     ///< why it is blocked, rejected or ended otherwise
  std::optional<Binding> binding;  ///< what limits the motion now
  std::string recovery_action;     ///< what the planner does about it, for people
  Seconds blocked_duration{};      ///< since the arm could last move on freely; 0: it moves freely
  double distance = 0.0;           ///< ‖q_goal − q‖ [rad | m]
  Seconds elapsed{};               ///< since the planner accepted it
  std::vector<double> q_goal;      ///< where the arm goes, once known [rad | m]
  std::string planner;             ///< node that reports it
};

/// Nothing more comes of a goal in this state.
[[nodiscard]] constexpr bool is_final(GoalState state) {
  return state != GoalState::kAccepted && state != GoalState::kActive && state != GoalState::kBlocked;
}

enum class OutcomeKind {
  kReached,
  kRejected,     ///< the planner refuses the goal
  kCancelled,    ///< a client cancelled it
  kReplaced,     ///< a later goal for the same arm came
  kTimedOut,     ///< its own time limit passed: the planner gave it up
  kBlocked,      ///< the wait ended; the arm has no way for now, and its planner goes on trying
  kActive,       ///< the wait ended; the arm still moves towards the goal
  kUnanswered,   ///< the wait ended; no planner has answered the goal
  kInterrupted,  ///< the wait was interrupted
};

/// What became of a goal, as far as a wait went. Only the first five kinds are final.
struct HECATON_API Outcome {
  OutcomeKind kind = OutcomeKind::kUnanswered;
  std::optional<Progress> progress;  ///< the newest; nothing: no planner has answered

  /// The goal was reached.
  explicit operator bool() const { return kind == OutcomeKind::kReached; }
  /// The cause that the planner gives; none when it has given none.
  [[nodiscard]] Cause cause() const { return progress ? progress->cause : Cause{}; }
  /// One sentence for people: "blocked: west/forearm is 18 mm from north/wrist".
  [[nodiscard]] std::string text() const;
};

struct Fault {
  std::string id;  ///< unique for one occurrence
  Severity severity = Severity::kError;
  Cause cause;
  bool cleared = false;
};

/// Contacts and separations that the world has measured since the cell came up.
struct ContactReport {
  std::uint64_t contacts = 0;
  std::optional<Binding> smallest;  ///< the smallest separation; nothing: nothing was judged
};

struct ArmStatus {
  std::string name;
  CellMode mode = CellMode::kRun;  ///< the stricter of the cell's and its own
  bool driver_alive = false;
  bool planner_alive = false;
  std::optional<ArmState> state;  ///< nothing: the supervisor has never heard it
  std::optional<Progress> goal;   ///< the newest
  Cause waiting_for;              ///< why it stands still; none while it moves
};

struct NodeStatus {
  std::string name;
  NodeKind kind = NodeKind::kOther;
  NodeState state = NodeState::kStarting;
  std::string host;
  bool alive = false;
  Cause cause;    ///< why it is degraded or failed
  Seconds age{};  ///< since its last heartbeat, at the supervisor; negative: never heard
};

/// The cell as its supervisor sees it.
struct CellStatus {
  std::string cell;
  CellMode mode = CellMode::kRun;
  Cause cause;  ///< why the cell does not run
  std::vector<std::string> held_arms;
  std::vector<std::string> stopped_arms;
  std::string supervisor;              ///< node that answers
  std::optional<std::string> standby;  ///< node that is ready to take over
  std::vector<ArmStatus> arms;
  std::vector<NodeStatus> nodes;
  std::vector<Fault> faults;              ///< those that last, then the latest that were cleared
  std::optional<ContactReport> contacts;  ///< nothing: the supervisor has heard none
};

}  // namespace hecaton
