#pragma once
/// The interface of a motion method: what velocity an arm wants in a control period. docs/how-to/add-a-motion-method.md
/// leads through it; planner/methods/registry.cpp lists the methods.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/pass_input.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/random.hpp"
#include "planner/local/velocity_constraints.hpp"
#include "planner/methods/method_memory.hpp"
#include "planner/methods/parameter_visitor.hpp"
#include "planner/model/range_sensor.hpp"

namespace hecaton::planner {

class ExactDistance;

/// What the rest of Hecaton asks about a method, instead of comparing names.
struct MethodTraits {
  std::string_view name;     ///< in the cell file, on the command line and in reports
  std::string_view summary;  ///< one phrase, for lists
  /// The arm takes part in right of way, tries rollouts, asks for routes and agrees on coupled plans.
  bool coordinates = false;
  /// The arm knows no obstacle but what its own sensors see: it needs sensors, and no message about obstacles.
  bool sensor_only = false;
  /// How `hecaton plan --method` plans a path by this method.
  enum class Path {
    kNone,     ///< it does not
    kDescent,  ///< down the gradient of the method's field
    kWalk,     ///< the arm goes its way alone, in virtual time
  } path = Path::kNone;
  /// What `--plot` draws of an arm with this method.
  enum class Plot { kNone, kField, kCspace } plot = Plot::kNone;
};

/// Storage of one thread for one method and one CellGeometry. Its contents mean nothing between ticks.
class MethodWorkspace {
 public:
  virtual ~MethodWorkspace() = default;
  /// After CellGeometry::set_obstacles. May allocate.
  virtual void rebuild(const CellGeometry& geometry) = 0;
};

/// What is around the arm now. References are valid during the call.
struct MethodScene {
  const CellGeometry& geometry;
  CellPoses poses;                       ///< arms and obstacles, brought forward to now
  std::span<const ArmObservation> arms;  ///< as last observed, one per arm of the cell
  double self_security_distance;         ///< between links of the arm [m]
  ExactDistance& distance;               ///< of the cell; scratch
  MethodWorkspace* workspace;            ///< as made by make_workspace(); null: it made none
};

/// One control period of an arm that has a goal. References are valid during the call.
struct MethodInput {
  const JointLimits& limits;  ///< of the arm; slower near other things
  const JointVector& q;       ///< reference position [rad | m]
  const JointVector& qd;      ///< reference velocity [rad/s | m/s]
  const JointVector& q_goal;  ///< [rad | m]
  const JointVector& target;  ///< where to go now: the goal, or a way-point of a route or detour [rad | m]
  double dt;                  ///< control period [s]
  std::span<const Row> rows;  ///< the constraints on the velocity
  const MethodScene* scene;   ///< null where the local planner runs without a tick, as in tests
};

/// How a method leads its arm off the straight way: what the rest of the planner reads of it, and may end.
struct Deviation {
  bool active = false;  ///< the arm goes around something; a planner that clears it makes the method abandon that way
  bool renew = false;   ///< a rollout chose to try another way around; holds for one period
  int drawn = 0;        ///< ways around that the method has tried for this goal
  int row = -1;         ///< index of the constraint that the arm follows; −1: none, or a limit of a joint
};

/// What a method may change in a tick.
struct MethodState {
  MethodMemory& memory;  ///< empty for each new goal
  Deviation& deviation;  ///< default for each new goal
  Random& random;        ///< the arm's
  double& rollout_wait;  ///< a held-back arm waits so long for a rollout before it deviates [s]
};

struct WantedMotion {
  JointVector velocity;  ///< [rad/s | m/s]
  bool stalled = false;  ///< the method gets nowhere, although the arm may move: the arm reports that it is blocked
};

/// What the constraints leave of a wanted velocity.
struct ConstrainedMotion {
  const JointVector& wanted;     ///< [rad/s | m/s]
  const JointVector& possible;   ///< the nearest velocity that all constraints allow [rad/s | m/s]
  const VelocityBounds& bounds;  ///< of speed and position limits
  int blocking_row;              ///< the constraint that holds the arm back most; −1: none
  bool has_right_of_way;         ///< the other arms make room
};

struct Redirection {
  std::optional<JointVector> velocity;  ///< to want instead [rad/s | m/s]; nothing: the first wish stands
  bool awaiting_rollout = false;        ///< the arm is held back, and waits for a rollout before it deviates
};

/// Where an arm goes by what it has gathered between ticks.
enum class GuidedPath : std::uint8_t {
  kStraight,   ///< to the goal, as far as is known
  kAround,     ///< what is known to be in the way
  kSearching,  ///< stays until it is known
  kNone,       ///< what is known leaves no way
};

/// What one arm gathers beside its ticks and a rollout cannot copy: a map, for example. Rollouts go without.
/// Runs in the planner's loop: bounded work in each call. Not thread-safe.
class MotionGuide {
 public:
  struct Aim {
    GuidedPath path = GuidedPath::kSearching;
    JointVector q;  ///< where to go now, straight; the arm's own place to stay [rad | m]
  };

  virtual ~MotionGuide() = default;
  /// The cell's obstacles, whenever they change. An arm with a guide gets no constraint from an obstacle: its guide
  /// keeps it away.
  virtual void set_obstacles(std::span<const world::Obstacle> /*obstacles*/) {}
  /// What a sensor of the arm has measured.
  virtual void sense(const RangeScan& /*scan*/) {}
  /// For the arm at (q, q̇) on its way to q_goal; once in each period that has a goal.
  [[nodiscard]] virtual Aim guide(const JointVector& q, const JointVector& qd, const JointVector& q_goal) = 0;
  /// From `from`, the arm may be at (q, q̇) when the period ends.
  [[nodiscard]] virtual bool may_go(const JointVector& from, const JointVector& q, const JointVector& qd) const = 0;
  /// Why guide() found no way for an arm at `q`, as a sentence's middle; nothing if it found one.
  [[nodiscard]] virtual std::optional<std::string> why_none(const JointVector& q) const = 0;
};

/// Immutable once a cell is loaded: planners and rollouts share it. Functions that a tick calls (want, redirect,
/// held_back) are pure: no clock, allocation, log or network. Thread-safe.
class MotionMethod {
 public:
  explicit MotionMethod(const MethodTraits& traits) : traits_(traits) {}
  virtual ~MotionMethod() = default;

  [[nodiscard]] const MethodTraits& traits() const { return traits_; }

  // Once, when a cell is loaded.
  /// Shows each parameter to the visitor, which may set it.
  virtual void visit_parameters(ParameterVisitor& /*visitor*/) {}
  /// Nothing when the parameters are consistent; otherwise one sentence: key, value, what is allowed.
  [[nodiscard]] virtual std::optional<std::string> validate() const { return std::nullopt; }
  /// Nothing when the method suits the arm; otherwise how the sentence "METHOD …" goes on.
  [[nodiscard]] virtual std::optional<std::string> objection(const Arm& /*arm*/,
                                                             std::span<const RangeSensor> /*sensors*/) const {
    return std::nullopt;
  }
  /// Simulated tasks begin and end at least this far from everything [m]; nothing: as the dampers need.
  [[nodiscard]] virtual std::optional<double> least_rest_distance() const { return std::nullopt; }
  /// What the arm keeps from seen points, for what is between two beams: key and value [m]; nothing: no matter.
  struct SensingMargin {
    std::string_view key;
    double value;
  };
  [[nodiscard]] virtual std::optional<SensingMargin> sensing_margin() const { return std::nullopt; }

  // Once for each arm or thread. May allocate. Null: the method needs none.
  [[nodiscard]] virtual std::unique_ptr<MethodWorkspace> make_workspace(const CellGeometry& geometry) const;
  /// `dt`: control period [s].
  [[nodiscard]] virtual std::unique_ptr<MotionGuide> make_guide(const Arm& arm, double dt) const;

  // In each tick that has a goal.
  /// The velocity that the arm wants if nothing constrains it; by default straight to the target.
  [[nodiscard]] virtual WantedMotion want(const MethodInput& input, MethodState state) const;
  /// The velocity that the arm wants instead, once the constraints have acted; by default the first wish stands.
  /// Not called at the goal, on a detour, and while the arm makes room for another.
  [[nodiscard]] virtual Redirection redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                             MethodState state) const;
  /// The constraints leave so little of the wish that the arm is held back.
  [[nodiscard]] virtual bool held_back(const JointVector& possible, const JointVector& wanted) const;

 private:
  MethodTraits traits_;
};

/// A method with parameters of type P; `parameters_of<P>` finds them.
template <class P>
struct Configured {
  P parameters;
};

/// Methods that one arm can be planned by, each with the parameters that the cell file gives it.
using MethodSet = std::vector<std::shared_ptr<const MotionMethod>>;

/// The method of that name; null: there is none.
[[nodiscard]] std::shared_ptr<const MotionMethod> find_method(const MethodSet& methods, std::string_view name);

/// The parameters of the first method that has such; defaults where none has.
template <class P>
[[nodiscard]] P parameters_of(const MethodSet& methods) {
  for (const auto& method : methods) {
    if (const auto* found = dynamic_cast<const Configured<P>*>(method.get())) return found->parameters;
  }
  return {};
}

}  // namespace hecaton::planner
