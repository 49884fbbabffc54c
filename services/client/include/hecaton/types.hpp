#pragma once
/// Values of the client library: poses, shapes, states, causes. Units are metres, radians, seconds and kilograms; W is
/// the frame of the cell. Values hold no references and may be copied to any thread.

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

/// A duration, or an age [s].
using Seconds = std::chrono::duration<double>;

/// The reason of a state, a fault or a rejection. Programs evaluate `kind` and `subject`; `text` is for people and may
/// change with any version.
struct Cause {
  CauseKind kind = CauseKind::kNone;  ///< for programs
  std::string subject;                ///< name of a node, host, arm, obstacle, joint or link; empty: none
  std::string text;                   ///< one sentence; empty for kNone

  /// There is a reason.
  explicit operator bool() const { return kind != CauseKind::kNone; }
};

/// Three numbers; the place of use says what they are.
struct Vector3 {
  double x = 0.0;  ///< along x
  double y = 0.0;  ///< along y
  double z = 0.0;  ///< along z
};

/// Pose of a frame in W unless stated otherwise.
struct HECATON_API Pose {
  Vector3 position;                                    ///< [m]
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};  ///< unit quaternion w, x, y, z

  /// A pose without rotation [m].
  [[nodiscard]] static Pose xyz(double x, double y, double z) { return {{x, y, z}}; }
  /// Roll, pitch and yaw [rad] are rotations about the fixed axes x, y and z, in this order, as in URDF.
  [[nodiscard]] static Pose xyz_rpy(double x, double y, double z, double roll, double pitch, double yaw);
};

// Shapes, centred at the origin of the obstacle's frame unless they are a hull or points; axes of rotation along z.
/// A cuboid.
struct Box {
  double x;  ///< full size along x [m]
  double y;  ///< full size along y [m]
  double z;  ///< full size along z [m]
};
/// A ball.
struct Sphere {
  double radius;  ///< [m]
};
/// A cylinder about z.
struct Cylinder {
  double radius;  ///< [m]
  double height;  ///< [m]
};
/// A cylinder about z with a half ball at each end.
struct Capsule {
  double radius;  ///< [m]
  double length;  ///< between the centres of the caps [m]
};
/// The convex hull of points, such as the vertices of a mesh. A hull of more than 64 vertices becomes a polyhedron of
/// 64 that encloses it. An edit with points in one plane, or without a volume, throws InvalidArgument.
struct ConvexHull {
  std::vector<Vector3> points;  ///< in the obstacle's frame [m]
};
/// Balls of one radius about points, such as a depth camera sees. No arm can carry them, and they cannot fall. An edit
/// without points, with more than 100,000, or with a coordinate that is not finite throws InvalidArgument. Coordinates
/// are kept in single precision.
struct Points {
  std::vector<Vector3> points;  ///< in the obstacle's frame [m]
  double radius;                ///< of each ball [m]
};
/// Shape of an obstacle.
using Shape = std::variant<Box, Sphere, Cylinder, Capsule, ConvexHull, Points>;

// Motions of obstacles. They begin at the pose at which the obstacle is added.
/// Stays where it is.
struct Static {};
/// Along a straight line; repeats from the beginning after `length`.
struct Conveyor {
  Vector3 velocity;  ///< in W [m/s]
  double length;     ///< [m]
};
/// Sinusoidal motion along a line.
struct Sine {
  Vector3 amplitude;  ///< in W [m]
  Seconds period;     ///< of one oscillation
};
/// On a circle about an axis along z of W.
struct Circle {
  Vector3 centre;        ///< in W [m]
  double angular_speed;  ///< [rad/s]
};
/// A rigid body that falls and is pushed.
struct Dynamic {
  double mass;  ///< [kg]
};
/// Motion of an obstacle.
using Motion = std::variant<Static, Conveyor, Sine, Circle, Dynamic>;

/// The state of an obstacle as the world service publishes it.
struct ObstacleState {
  std::string name;                        ///< unique in the cell
  Pose pose;                               ///< in W
  Vector3 velocity;                        ///< of the frame's origin, in W [m/s]
  std::optional<std::string> attached_to;  ///< arm that carries it
  Seconds age{};                           ///< since the state was received
};

/// A signal of an arm's device.
struct Signal {
  std::string name;                             ///< in the cell file
  SignalKind kind = SignalKind::kDigitalInput;  ///< of the port
  std::optional<double> value;                  ///< as the device reports it; empty: it has not reported any
};

/// Gripper and signals of an arm.
struct ToolState {
  bool has_gripper = false;     ///< false: the next three mean nothing
  bool moving = false;          ///< the gripper opens or closes
  std::optional<double> width;  ///< of its opening [m]; empty: not known
  std::string holding;          ///< obstacle that it holds; empty: none
  std::vector<Signal> signals;  ///< in the order of their names
  Seconds age{};                ///< since this state arrived
};

/// How a gripper shall open or close.
struct GripOptions {
  std::optional<double> width;  ///< of its opening [m]; empty: as far as it goes
  std::optional<double> force;  ///< [N]; empty: the gripper's own
};

/// The state of an arm as its driver measured it.
struct ArmState {
  ArmMode mode = ArmMode::kStarting;  ///< of its driver
  Cause cause;                        ///< why it brakes or does not follow commands
  std::vector<double> q;              ///< joint positions, base to tip [rad | m]
  std::vector<double> qd;             ///< joint velocities [rad/s | m/s]
  std::vector<std::string> carried;   ///< names of the objects attached to the tool
  Seconds age{};                      ///< since the state was received; in a CellStatus: by the supervisor
};

/// The pair of bodies whose distance limits the motion.
struct Binding {
  std::string own;        ///< "north/forearm"
  std::string other;      ///< "west/wrist" or "pallet"
  double distance = 0.0;  ///< [m]
};

/// How far the measured tool frame is from a pose goal.
struct ToolError {
  double position = 0.0;     ///< [m]
  double orientation = 0.0;  ///< without the free rotation [rad]
};

/// What the arm can do at the position of a pose goal that was rejected for its orientation.
struct NearestPose {
  Pose pose;           ///< of the tool frame in W
  double angle = 0.0;  ///< from the orientation of the goal, without the free rotation [rad]
};

/// Progress of a goal, as the planner of the arm reports it.
struct Progress {
  std::string arm;                         ///< name in the cell file
  std::string goal;                        ///< identifier, unique among the goals of the arm
  GoalState state = GoalState::kAccepted;  ///< of the goal
  Cause cause;                             ///< why it is blocked, or why it ended unreached
  std::optional<Binding> binding;          ///< limits the motion now; empty: no pair
  std::string recovery_action;             ///< of the planner while the arm is blocked, for people
  Seconds blocked_duration{};              ///< since the arm last moved freely; 0: it moves freely
  double distance = 0.0;                   ///< ‖q_goal − q‖ [rad | m]
  Seconds elapsed{};                       ///< since the planner accepted it
  /// Target configuration, once it is known; on an active trajectory that of half a second later [rad | m].
  std::vector<double> q_goal;
  std::string planner;                     ///< node that reports the progress
  std::string note;                        ///< what the planner changed in the goal, for people; empty: nothing
  std::optional<ToolError> tool_error;     ///< measured; empty: no pose goal, or not measured yet
  std::optional<NearestPose> nearest;      ///< with CauseKind::kGoalOrientation
  std::optional<Seconds> trajectory_time;  ///< in its trajectory that the arm has come to; empty: it has none
  double trajectory_rate = 0.0;            ///< of that time: 1 as the trajectory demands, 0 while the arm waits
  Seconds age{};                           ///< since this progress arrived; in a CellStatus 0
};

/// A point of a trajectory.
struct TrajectoryPoint {
  Seconds time{};           ///< since the start of the trajectory; greater than that of the point before
  std::vector<double> q;    ///< joint positions from base to tip [rad | m]
  std::vector<double> qd;   ///< velocities; empty in all points: not given [rad/s | m/s]
  std::vector<double> qdd;  ///< accelerations; empty in all points: not given [rad/s² | m/s²]
};

/// Joint positions with times.
struct Trajectory {
  std::vector<TrajectoryPoint> points;  ///< 1 to 4096, and points times joints at most 32768; the last one is at rest
  /// Each joint's largest distance from the trajectory, also where the arm goes around something; 0: none. Empty: no
  /// joint has one [rad | m].
  std::vector<double> path_tolerance;
};

/// The state is the last one of a goal.
[[nodiscard]] constexpr bool is_final(GoalState state) {
  return state != GoalState::kAccepted && state != GoalState::kActive && state != GoalState::kBlocked;
}

/// How a goal stands at the end of a wait.
enum class OutcomeKind {
  kReached,      ///< the measured arm is at the goal
  kRejected,     ///< the planner rejected the goal
  kCancelled,    ///< a client cancelled it
  kReplaced,     ///< a later goal of the same arm replaced it
  kTimedOut,     ///< the planner ended it at the time limit of the goal
  kBlocked,      ///< the wait ended; the arm has no path for now, and its planner continues to try
  kActive,       ///< the wait ended; the arm moves towards the goal
  kUnanswered,   ///< the wait ended; no planner has answered
  kInterrupted,  ///< the wait was interrupted
};

/// The outcome of a goal at the end of a wait. Only the first five kinds are final.
struct HECATON_API Outcome {
  OutcomeKind kind = OutcomeKind::kUnanswered;  ///< for programs
  std::optional<Progress> progress;             ///< the newest; empty: no planner has answered

  /// The goal was reached.
  explicit operator bool() const { return kind == OutcomeKind::kReached; }
  /// The cause of the newest progress; kNone without progress.
  [[nodiscard]] Cause cause() const { return progress ? progress->cause : Cause{}; }
  /// One sentence for people: "blocked: west/forearm is 18 mm from north/wrist".
  [[nodiscard]] std::string text() const;
};

/// A fault that the supervisor has detected.
struct Fault {
  std::string id;                        ///< unique for each occurrence
  Severity severity = Severity::kError;  ///< of the fault
  Cause cause;                           ///< kind, faulty component, and a sentence
  bool cleared = false;                  ///< the cause has ended
};

/// Contacts and separations that the world service has measured since the cell was started.
struct ContactReport {
  std::uint64_t contacts = 0;       ///< number of contacts that began
  std::optional<Binding> smallest;  ///< the smallest separation; nothing: no pair was checked
};

/// The status of an arm as its supervisor reports it.
struct ArmStatus {
  std::string name;                ///< in the cell file
  CellMode mode = CellMode::kRun;  ///< the stricter of the modes of the cell and of the arm
  double speed = 1.0;              ///< speed override in force: the lower of the cell's and the arm's own
  bool driver_alive = false;       ///< heartbeats of its driver arrive
  bool planner_alive = false;      ///< heartbeats of the planner in charge arrive
  std::optional<ArmState> state;   ///< empty: the supervisor has received none
  std::optional<Progress> goal;    ///< the newest; empty: none
  Cause waiting_for;               ///< why the arm waits; kNone while it moves
};

/// The status of a process of the cell.
struct NodeStatus {
  std::string name;                        ///< unique in the cell
  NodeKind kind = NodeKind::kOther;        ///< what it does
  NodeState state = NodeState::kStarting;  ///< as its heartbeats say
  std::string host;                        ///< on which it runs
  bool alive = false;                      ///< its heartbeats arrive
  Cause cause;                             ///< why it is degraded or has failed
  Seconds age{};  ///< since the supervisor received its last heartbeat; negative: none received
};

/// The status of a cell as its supervisor reports it.
struct CellStatus {
  std::string cell;                       ///< name in the cell file
  CellMode mode = CellMode::kRun;         ///< of the cell
  Cause cause;                            ///< why the mode is not kRun
  double speed = 1.0;                     ///< speed override of the cell, 0.01 to 1
  std::vector<std::string> held_arms;     ///< by name or by a fault
  std::vector<std::string> stopped_arms;  ///< by name
  std::string supervisor;                 ///< node that leads
  std::optional<std::string> standby;     ///< node that is ready to take over; empty: none
  std::vector<ArmStatus> arms;            ///< all arms of the cell
  std::vector<NodeStatus> nodes;          ///< all processes of the cell
  std::vector<Fault> faults;              ///< present faults, then the latest cleared ones
  std::optional<ContactReport> contacts;  ///< empty: the supervisor has received none
};

}  // namespace hecaton
