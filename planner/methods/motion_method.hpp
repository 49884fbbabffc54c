#pragma once
/// The interface of motion methods. A method says what velocity an arm wants in a control period. Tutorial:
/// docs/how-to/add-a-motion-method.md. planner/methods/registry.cpp lists the built-in methods.

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

/// Properties of a method. Other code decides on these and never on the name.
struct MethodTraits {
  std::string_view name;     ///< in the cell file, on the command line and in reports
  std::string_view summary;  ///< one phrase, for lists
  /// The arm takes part in right of way, rollouts, replanning and coupled plans.
  bool coordinates = false;
  /// The arm knows obstacles from its own sensors only. It needs sensors, and no messages about obstacles.
  bool sensor_only = false;
  /// How `hecaton plan --method` plans a path by this method.
  enum class Path {
    kNone,               ///< not available
    kDescent,            ///< down the gradient of the method's field
    kWalk,               ///< simulation of the arm alone, in virtual time
  } path = Path::kNone;  ///< how `hecaton plan` uses it
  /// What `--plot` draws for this method.
  enum class Plot {
    kNone,               ///< nothing
    kField,              ///< the field at the height of the goal
    kCspace,             ///< the C-space of two joints
  } plot = Plot::kNone;  ///< what `--plot` draws
};

/// Storage of one thread for one method and one CellGeometry. Its contents have no meaning between ticks.
class MethodWorkspace {
 public:
  virtual ~MethodWorkspace() = default;
  /// Called after CellGeometry::set_obstacles. May allocate.
  virtual void rebuild(const CellGeometry& geometry) = 0;
};

/// The surroundings of the arm. References are valid during the call.
struct MethodScene {
  const CellGeometry& geometry;          ///< bodies of the arm, of other arms and of obstacles
  CellPoses poses;                       ///< arms and obstacles, extrapolated to now
  std::span<const ArmObservation> arms;  ///< as last observed, one per arm of the cell
  double self_security_distance;         ///< between links of the arm [m]
  /// Of the cell: `distance.clearances(poses, …)` measures what is near, in this thread; it changes its scratch. Needs
  /// planner/collision/exact_distance.hpp.
  ExactDistance& distance;
  MethodWorkspace* workspace;  ///< result of make_workspace(); may be null
};

/// One control period of an arm that has a goal. References are valid during the call.
struct MethodInput {
  const JointLimits& limits;  ///< of the arm, with reduced velocities near other bodies
  const JointVector& q;       ///< reference position [rad | m]
  const JointVector& qd;      ///< reference velocity [rad/s | m/s]
  const JointVector& q_goal;  ///< [rad | m]
  const JointVector& target;  ///< the goal, or the way-point of a route or detour [rad | m]
  double dt;                  ///< control period [s]
  std::span<const Row> rows;  ///< constraints on the velocity
  const MethodScene* scene;   ///< null if the local planner runs without a tick, as in tests
  double speed = 1.0;         ///< share of the arm's velocity limits that it may use; time limits count with it
};

/// The deviation of an arm from the straight line. The method sets it; the rest of the planner reads it and may end it.
struct Deviation {
  bool active = false;  ///< the arm goes around an obstacle; clearing it makes the method abandon the deviation
  bool renew = false;   ///< a rollout chose another deviation; valid for one period
  int drawn = 0;        ///< deviations that the method has tried for this goal
  int row = -1;         ///< index of the followed row; −1: none, or a joint limit

  void describe(MemoryArchive& archive) {
    archive(active, renew);
    archive.count(drawn);
    archive.count(row);
  }
};

/// State that a method may change in a tick.
struct MethodState {
  MethodMemory& memory;  ///< empty at each new goal
  Deviation& deviation;  ///< default at each new goal
  Random& random;        ///< of the arm
  double& rollout_wait;  ///< remaining time that a blocked arm waits for a rollout before it deviates [s]
};

/// What an arm wants before any constraint acts.
struct WantedMotion {
  JointVector velocity;  ///< [rad/s | m/s]
  bool stalled = false;  ///< the method makes no progress although the arm may move: the arm reports kBlocked
};

/// A wanted velocity and its projection onto the constraints.
struct ConstrainedMotion {
  const JointVector& wanted;     ///< [rad/s | m/s]
  const JointVector& possible;   ///< the nearest velocity that all constraints allow [rad/s | m/s]
  const VelocityBounds& bounds;  ///< of speed and position limits
  int blocking_row;              ///< the row with the largest multiplier; −1: none
  bool has_right_of_way;         ///< the other arms yield
};

/// What an arm wants after the constraints have acted.
struct Redirection {
  std::optional<JointVector> velocity;  ///< new wanted velocity [rad/s | m/s]; nothing: unchanged
  bool awaiting_rollout = false;        ///< the arm is blocked and waits for a rollout before it deviates
};

/// The kind of path that a guide has found.
enum class GuidedPath : std::uint8_t {
  kStraight,   ///< straight to the goal, as far as known
  kAround,     ///< around known obstacles
  kSearching,  ///< not known yet: the arm stays
  kNone,       ///< there is no path in the known space
};

/// State of a method that is too large to copy into rollouts, such as a map. Rollouts run without it. The planner's
/// loop calls the guide: each call does bounded work. Not thread-safe.
class MotionGuide {
 public:
  /// Where the arm goes next.
  struct Aim {
    GuidedPath path = GuidedPath::kSearching;  ///< that q belongs to
    JointVector q;  ///< next target on a straight line; the arm's rest position to stay [rad | m]
  };

  virtual ~MotionGuide() = default;
  /// Called whenever the cell's obstacles change. An arm with a guide gets no rows from obstacles: the guide keeps the
  /// arm away from them.
  virtual void set_obstacles(std::span<const world::Obstacle> /*obstacles*/) {}
  /// Called for each scan of the arm's sensors.
  virtual void sense(const RangeScan& /*scan*/) {}
  /// The next aim of the arm at (q, q̇). Called once in each period with a goal.
  [[nodiscard]] virtual Aim guide(const JointVector& q, const JointVector& qd, const JointVector& q_goal) = 0;
  /// True if the arm may move from `from` to (q, q̇) in this period.
  [[nodiscard]] virtual bool may_go(const JointVector& from, const JointVector& q, const JointVector& qd) const = 0;
  /// The reason why guide() found no path for an arm at `q`, as a clause; nothing if it found one.
  [[nodiscard]] virtual std::optional<std::string> no_path_reason(const JointVector& q) const = 0;
};

/// A motion method. Immutable once a cell is loaded, because planners and rollouts share it: then thread-safe.
/// Functions that a tick calls (want, redirect, is_blocked) are pure: no clock, allocation, log or network.
class MotionMethod {
 public:
  explicit MotionMethod(const MethodTraits& traits) : traits_(traits) {}  ///< the texts must outlive the method
  virtual ~MotionMethod() = default;

  [[nodiscard]] const MethodTraits& traits() const { return traits_; }  ///< as given

  // Called once, when a cell is loaded.
  /// Passes each parameter to the visitor, which may set it.
  virtual void visit_parameters(ParameterVisitor& /*visitor*/) {}
  /// Nothing if the parameters are consistent; otherwise one sentence with key, value and rule.
  [[nodiscard]] virtual std::optional<std::string> validate() const { return std::nullopt; }
  /// Nothing if the method suits the arm; otherwise the rest of a sentence that begins with the method's name.
  [[nodiscard]] virtual std::optional<std::string> objection(const Arm& /*arm*/,
                                                             std::span<const RangeSensor> /*sensors*/) const {
    return std::nullopt;
  }
  /// Least distance from other bodies at the ends of simulated tasks [m]; nothing: as the dampers need.
  [[nodiscard]] virtual std::optional<double> least_rest_distance() const { return std::nullopt; }
  /// The distance that the arm keeps from measured points, to cover the gaps between beams; nothing: not used.
  struct SensingMargin {
    std::string_view key;  ///< in the cell file
    double value;          ///< [m]
  };
  /// Nothing if the method uses no sensors.
  [[nodiscard]] virtual std::optional<SensingMargin> sensing_margin() const { return std::nullopt; }
  /// Nothing if the method keeps the arm free of contact; otherwise a sentence that begins with the key at fault.
  [[nodiscard]] virtual std::optional<std::string> contact_risk() const { return std::nullopt; }

  // Called once for each arm or thread. May allocate. Null: the method needs none.
  /// Storage for one thread and this geometry.
  [[nodiscard]] virtual std::unique_ptr<MethodWorkspace> make_workspace(const CellGeometry& geometry) const;
  /// Large state of this arm. `dt`: control period [s].
  [[nodiscard]] virtual std::unique_ptr<MotionGuide> make_guide(const Arm& arm, double dt) const;

  // Called in each tick with a goal.
  /// The velocity that the arm wants without constraints. Default: straight to the target.
  [[nodiscard]] virtual WantedMotion want(const MethodInput& input, MethodState state) const;
  /// The velocity that the arm wants after the constraints have acted. Default: unchanged. Not called at the goal, on a
  /// detour, or while the arm yields.
  [[nodiscard]] virtual Redirection redirect(const MethodInput& input, const ConstrainedMotion& constrained,
                                             MethodState state) const;
  /// True if the constraints leave so little of the wanted velocity that the arm counts as blocked.
  [[nodiscard]] virtual bool is_blocked(const JointVector& possible, const JointVector& wanted) const;

  /// Stores a default value of the method's own type, before a saved memory is loaded. Override it if the method uses
  /// MethodState::memory. That type has a function describe(MemoryArchive&).
  virtual void prepare(MethodMemory& memory) const { memory.clear(); }

 private:
  MethodTraits traits_;
};

/// Base of a method with parameters of type P; `parameters_of<P>()` finds them.
template <class P>
struct Configured {
  P parameters;  ///< set by the reader of the cell file
};

/// The methods of one arm, each with the parameters of the cell file.
using MethodSet = std::vector<std::shared_ptr<const MotionMethod>>;

/// The method of that name; null if there is none.
[[nodiscard]] std::shared_ptr<const MotionMethod> find_method(const MethodSet& methods, std::string_view name);

/// The parameters of the first method with parameters of type P; defaults if there is none.
template <class P>
[[nodiscard]] P parameters_of(const MethodSet& methods) {
  for (const auto& method : methods) {
    if (const auto* found = dynamic_cast<const Configured<P>*>(method.get())) return found->parameters;
  }
  return {};
}

}  // namespace hecaton::planner
