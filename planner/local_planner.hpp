#pragma once
/// The reactive planner of one arm: from constraints and a goal to the next joint velocity.

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "planner/local/parameters.hpp"
#include "planner/local/right_of_way.hpp"
#include "planner/local/trajectory_tracking.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/model/limits.hpp"
#include "planner/qp/dense_qp.hpp"

namespace hecaton::planner {

class StopPathCheck;

enum class ManoeuvreKind : std::uint8_t {
  kContinue,  ///< keep following the boundary or moving straight
  kAbandon,   ///< abandon the boundary and move straight to the goal
  kSubspace,  ///< follow the boundary in a new subspace, drawn with `seed`
  kDetour,    ///< move straight to `q` first, then to the goal
  kEvade,     ///< move straight to `q` and stay there for `time_limit`, also without a goal; then continue
};

/// What a blocked or threatened arm may try next. A manoeuvre changes only LocalMemory: a rollout tries it on a copy,
/// and the arm then does exactly what the rollout did.
struct Manoeuvre {
  ManoeuvreKind kind = ManoeuvreKind::kContinue;
  std::uint64_t seed = 0;   ///< of all random choices from now on; unused by kContinue
  JointVector q;            ///< of kDetour and kEvade [rad | m]
  double time_limit = 0.0;  ///< of kDetour and kEvade [s]
};

/// The way-point that the arm visits before its goal.
struct Detour {
  bool active = false;
  JointVector q;           ///< [rad | m]
  double time_left = 0.0;  ///< [s]
  bool stays = false;      ///< true: it ends after `time_left`; false: also at its way-point
  bool of_route = false;   ///< the next point of a Route, which decides when it ends; the arm still gives way

  void describe(MemoryArchive& archive) { archive(active, q, time_left, stays, of_route); }
};

/// One control period. References are valid during the call.
struct LocalInput {
  const JointLimits& limits;
  const LocalParameters& parameters;
  const JointVector& q;       ///< reference position [rad | m]
  const JointVector& qd;      ///< reference velocity [rad/s | m/s]
  const JointVector& q_goal;  ///< [rad | m]; equal to q without goal
  double dt;                  ///< control period [s]
  std::span<const Row> rows;
  std::span<const ArmObservation> arms = {};  ///< one per arm of the cell; empty: there are no others
  int self = 0;                               ///< index of the own arm
  bool has_goal = true;                       ///< q_goal is a goal
  const MethodScene* scene = nullptr;         ///< passed to the method; may be null
  StopPathCheck* stop_path = nullptr;         ///< begun in this period; null: the command is not checked, as in tests
  double speed = 1.0;                         ///< share of the arm's velocity limits that `limits` has, above 0
  const PathBox* box = nullptr;               ///< more position limits, of a trajectory; null: none
};

/// Memory of the local planner between periods. A value: rollouts copy it.
struct LocalMemory {
  explicit LocalMemory(std::uint64_t seed = 1) : random(seed) {}

  Random random;
  MethodMemory method;
  Deviation deviation;
  QpWarmStart intended;
  QpWarmStart followed;
  QpWarmStart commanded;
  JointVector q_goal;           ///< of the last period; a change resets the memory
  double without_progress = 0;  ///< time since the arm last moved noticeably [s]
  Detour detour;
  RightOfWay right_of_way;
  double rollout_wait = 0.0;    ///< remaining time that a blocked arm waits for a rollout before it deviates [s]
  TrajectoryTracking tracking;  ///< of a goal with a trajectory

  /// `of_arm`: prepares `method` before it is loaded.
  void describe(MemoryArchive& archive, const MotionMethod& of_arm) {
    archive(random);
    method.describe(archive, [&] { of_arm.prepare(method); });
    archive(deviation, intended, followed, commanded, q_goal, without_progress, detour, right_of_way, rollout_wait,
            tracking);
  }
};

/// Begins the manoeuvre in the next period. kContinue only ends the wait for a rollout.
void begin(const Manoeuvre& manoeuvre, LocalMemory& memory);

struct LocalResult {
  JointVector qd;                 ///< for the next period [rad/s | m/s]
  bool following = false;         ///< the method leads the arm around an obstacle
  bool stalled = false;           ///< the method makes no progress
  bool detouring = false;         ///< the arm moves to its Detour
  bool awaiting_rollout = false;  ///< the straight line is blocked; the arm waits for a rollout
  int yields_to = -1;             ///< index of the arm that the own arm makes room for; −1: none
  bool blocked = false;           ///< no noticeable motion for 0.5 s away from the goal
  bool relaxed = false;           ///< the rows require more than the acceleration limits allow
  /// Own bodies that the stop path of the velocity within the rows would bring too close; another one was taken.
  std::optional<std::pair<int, int>> too_close;
  int binding_row = -1;  ///< the row with the largest multiplier; −1: no row limits the motion
};

/// Plans one period. The result always satisfies the velocity and acceleration limits. It satisfies every row that the
/// stop profile can satisfy. Otherwise (`relaxed`) no row is violated by more than the stop profile violates it, and
/// the arm retreats from approaching bodies as far as its limits allow. The stop path of the result is clear, or the
/// result brakes on the stop profile.
[[nodiscard]] LocalResult plan_locally(const LocalInput& input, LocalMemory& memory);

}  // namespace hecaton::planner
