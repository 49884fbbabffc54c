#pragma once
/// The fast simulation of a motion problem [Mediavilla02, section 3.1]. Input and output are plain arrays, because it
/// is compiled once per instruction set (planner/simd). Other code includes evaluate.hpp.

#include <cstddef>
#include <cstdint>

namespace hecaton::planner {

inline constexpr int kFlatJoints = 16;  ///< planner/model's kMaxJoints
inline constexpr int kFlatBodies = 16;  ///< capsules of one arm, a multiple of the lanes
inline constexpr int kFlatPairs = 48;   ///< pairs of capsules checked for self-collision
inline constexpr int kFlatArms = 8;
inline constexpr int kFlatBoxes = 32;

/// A joint that the strategy moves, with the fixed joints before it; its axis is the z axis of its frame.
struct FlatJoint {
  double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rotation to the previous joint's frame at q = 0, column by column
  double p[3] = {0, 0, 0};                    ///< origin in the previous joint's frame [m]; of the first joint: in W
  bool rotated = false;                       ///< R is not the identity
  bool prismatic = false;
  double lower = 0.0;  ///< [rad | m]
  double upper = 0.0;
  double lever = 0.0;  ///< upper bound of the speed of body segments per joint rate [m/rad | 1]
};

/// A capsule in a joint's frame; in W if it is fixed.
struct FlatBody {
  int joint = -1;         ///< index of its joint; −1: fixed
  double p[3] = {};       ///< one end of its segment [m]
  double d[3] = {};       ///< from there to the other end [m]
  double radius = 0.0;    ///< [m]
  double inverse2 = 0.0;  ///< 1/|d|², 0 for a point [1/m²]
  unsigned boxes = 0;     ///< bit k: FlatProblem::box[k] is within reach
  double reach = 0.0;     ///< radius of the bounding sphere about the segment's midpoint [m]
};

/// Size of the places of an arm's bodies in single precision (rough_distance.hpp).
inline constexpr int kRoughLanes = 8;
inline constexpr int kMaxRoughNumbers = 6 * kFlatBodies;

struct FlatPair {
  int first = 0;   ///< indices into FlatArm::body
  int second = 0;  ///< the body with more joints before it
};

struct FlatArm {
  int joints = 0;
  FlatJoint joint[kFlatJoints];
  int bodies = 0;
  int fixed = 0;  ///< number of fixed bodies, which come first
  FlatBody body[kFlatBodies];
  int pairs = 0;
  FlatPair pair[kFlatPairs];
};

inline std::ptrdiff_t rough_numbers(const FlatArm& arm) {
  return std::ptrdiff_t{6} * kRoughLanes * ((arm.bodies + kRoughLanes - 1) / kRoughLanes);
}

/// A static box.
struct FlatBox {
  double R[9];     ///< axes in W, column by column
  double c[3];     ///< centre in W [m]
  double half[3];  ///< half extents [m]
  double low[3];   ///< minimum corner of the bounding box in W [m]
  double high[3];  ///< maximum corner [m]
};

inline constexpr int kStrategyNumbers = kFlatJoints - 2;

/// The motion problem, and the parameters of its simulation.
struct FlatProblem {
  int arms = 0;
  FlatArm arm[kFlatArms];
  int boxes = 0;
  FlatBox box[kFlatBoxes];
  double step = 0.05 / 0.85;   ///< Δ [rad]
  double distance = 0.05;      ///< h, minimum distance to arms and obstacles [m]
  double rounding = 0.0;       ///< upper bound of the error of distances in single precision [m]
  double self_distance = 0.0;  ///< minimum distance between links of one arm [m]
  int timeout_factor = 200;    ///< a task that takes this many times its free time is a fault
  int basis = 0;               ///< BasisOrder of planner/methods/strategy/plane.hpp
  bool nearest_first = false;  ///< try neighbours nearest to the goal first, instead of the paper's order
};

/// The straight paths of an arm's first tasks, checked in advance: they are the same for all strategies until the first
/// fault. One place per step.
struct FlatPaths {
  int tasks = 0;                      ///< number of tasks; 0: none
  std::int32_t* first = nullptr;      ///< [task]: index of its first step
  std::uint8_t* self_free = nullptr;  ///< [step]: 1 if within limits, clear of itself and of boxes
  float* places = nullptr;            ///< [step][rough_numbers]
};

/// The tasks, drawn in advance, so that all strategies get the same. An arm visits its areas in order; it starts in the
/// first.
struct FlatTasks {
  int tasks = 0;                              ///< of each arm, N
  int areas[kFlatArms] = {};                  ///< of each arm
  const double* goals[kFlatArms] = {};        ///< [task][area][joint]: goal of the task if it ends in this area [rad]
  const std::int32_t* waits[kFlatArms] = {};  ///< [task]: steps before its start
  int starts = 0;                             ///< > 0
  const double* start[kFlatArms] = {};  ///< [start][joint]: initial configuration, and that after the k-th fault [rad]
  FlatPaths paths[kFlatArms];
};

struct FlatStrategy {
  double coefficients[kStrategyNumbers] = {};
  double direction = 1.0;
};

struct RunOptions {
  bool stop_at_fault = false;           ///< end the run at the first fault
  bool detect_cycles = true;            ///< skip the rest of a cycle of states until the time-out; same result
  std::int32_t* times[kFlatArms] = {};  ///< [task]: duration [steps]; may be null
  /// Called with `context` and the number of finished tasks of all arms after each; true ends the run. May be null.
  bool (*ended)(void* context, std::int64_t tasks) = nullptr;
  void* context = nullptr;
};

struct RunResult {
  int tasks[kFlatArms] = {};     ///< finished tasks, faults included, at most N
  int faults[kFlatArms] = {};    ///< of these, faults
  double time[kFlatArms] = {};   ///< of these, sum of durations [steps]
  double time2[kFlatArms] = {};  ///< of these, sum of squares [steps²]
  std::uint64_t arm_ticks = 0;   ///< simulated steps of moving arms
};

/// Simulates the tasks. `strategies`: one per arm.
using RunKernel = void (*)(const FlatProblem& problem, const FlatTasks& tasks, const FlatStrategy* strategies,
                           const RunOptions& options, RunResult& result);
/// Bit i: arm i at q[i] [rad] is within its limits, and clear of itself, of boxes, and (if `others`) of other arms.
using ClearKernel = unsigned (*)(const FlatProblem& problem, const double* const* q, bool others);

/// Fills the arrays of tasks.paths, which have the steps of FlatPaths::tasks tasks.
using PathsKernel = void (*)(const FlatProblem& problem, const FlatTasks& tasks);

/// The kernels for this processor. All give the same results to the last bit.
[[nodiscard]] RunKernel fastest_run();
[[nodiscard]] ClearKernel fastest_clear();
[[nodiscard]] PathsKernel fastest_paths();

namespace baseline {
void run_strategies(const FlatProblem& problem, const FlatTasks& tasks, const FlatStrategy* strategies,
                    const RunOptions& options, RunResult& result);
unsigned clear_arms(const FlatProblem& problem, const double* const* q, bool others);
void precheck_paths(const FlatProblem& problem, const FlatTasks& tasks);
}  // namespace baseline
namespace avx2 {
void run_strategies(const FlatProblem& problem, const FlatTasks& tasks, const FlatStrategy* strategies,
                    const RunOptions& options, RunResult& result);
unsigned clear_arms(const FlatProblem& problem, const double* const* q, bool others);
void precheck_paths(const FlatProblem& problem, const FlatTasks& tasks);
}  // namespace avx2

}  // namespace hecaton::planner
