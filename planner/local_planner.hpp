#pragma once
/// The reactive planner of one arm: from constraints and a goal to the next joint velocity.

#include <cstdint>
#include <span>

#include "planner/local/parameters.hpp"
#include "planner/local/right_of_way.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/model/limits.hpp"
#include "planner/qp/dense_qp.hpp"

namespace hecaton::planner {

enum class ManoeuvreKind : std::uint8_t {
  kContinue,  ///< whatever is being done: follow the boundary, or go straight as long as there is a way
  kAbandon,   ///< stop following, go straight to the goal
  kSubspace,  ///< follow in a fresh subspace, drawn with `seed`
  kDetour,    ///< visit `q` first, straight; then the goal
  kEvade,     ///< go to `q`, straight, and be there until `patience` is over, also without a goal; then go on
};

struct Manoeuvre {
  ManoeuvreKind kind = ManoeuvreKind::kContinue;
  std::uint64_t seed = 0;  ///< of all random choices from now on; not for kContinue
  JointVector q;           ///< of kDetour and kEvade [rad | m]
  double patience = 0.0;   ///< these end after so long at the latest [s]
};

/// The way-point of a detour, while there is one.
struct Detour {
  bool active = false;
  JointVector q;           ///< [rad | m]
  double time_left = 0.0;  ///< [s]
  bool stays = false;      ///< it ends with its time, not at its way-point
  bool of_route = false;  ///< a point of a route (planner/goal_progress.hpp), which says when it ends; the arm still makes room
};

struct LocalInput {
  const JointLimits& limits;
  const LocalParameters& parameters;
  const JointVector& q;       ///< reference position [rad | m]
  const JointVector& qd;      ///< reference velocity [rad/s | m/s]
  const JointVector& q_goal;  ///< [rad | m]; q itself to keep the place
  double dt;                  ///< control period [s]
  std::span<const Row> rows;
  std::span<const ArmObservation> arms = {};  ///< of every arm of the cell; empty: there are no others
  int self = 0;                               ///< index of the own arm
  bool has_goal = true;                       ///< q_goal is one
  const MethodScene* scene = nullptr;         ///< for the method; null: it does without
};

/// What the planner remembers between periods; a plain value.
struct LocalMemory {
  explicit LocalMemory(std::uint64_t seed = 1) : random(seed) {}

  Random random;
  MethodMemory method;
  Deviation deviation;
  QpWarmStart intended;
  QpWarmStart followed;
  QpWarmStart commanded;
  JointVector q_goal;           ///< of the last period: a new goal starts afresh
  double without_progress = 0;  ///< since the arm last moved noticeably [s]
  Detour detour;
  RightOfWay right_of_way;
  double rollout_wait = 0.0;  ///< a held-back arm waits so long for a rollout before its method deviates [s]
};

/// From the next period on the arm tries this. Nothing changes for kContinue.
void begin(const Manoeuvre& manoeuvre, LocalMemory& memory);

struct LocalResult {
  JointVector qd;          ///< for the next period [rad/s | m/s]
  bool following = false;  ///< the method leads the arm around something
  bool stalled = false;    ///< the method gets nowhere
  bool detouring = false;
  bool awaiting_rollout = false;  ///< its straight way is blocked, and it waits for a manoeuvre
  int yields_to = -1;             ///< index of the arm that this one makes room for; −1: none
  bool blocked = false;           ///< no noticeable motion for a while although the goal is not reached
  bool relaxed = false;  ///< the rows asked for more than acceleration limits can give; braked as hard as allowed
  int binding_row = -1;  ///< the row with the largest multiplier, −1: none holds the arm back
};

/// One period. The result always satisfies the velocity and acceleration limits; it satisfies every row, except those
/// that not even the stop profile can satisfy yet (then `relaxed`: no row is violated by more than the stop does, and
/// what comes is fled as well as can be).
[[nodiscard]] LocalResult plan_locally(const LocalInput& input, LocalMemory& memory);

}  // namespace hecaton::planner
