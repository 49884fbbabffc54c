#pragma once
/// The fast simulation of a motion problem [Mediavilla02, section 3.1]: plain arrays in and out, because it is compiled
/// once for each instruction set (planner/simd). Who needs it includes evaluate.hpp.

#include <cstddef>
#include <cstdint>

namespace hecaton::planner {

inline constexpr int kFlatJoints = 16;  ///< planner/model's kMaxJoints
inline constexpr int kFlatBodies = 16;  ///< capsules of one arm, a multiple of the lanes
inline constexpr int kFlatPairs = 48;   ///< pairs of them that self-collision looks at
inline constexpr int kFlatArms = 8;
inline constexpr int kFlatBoxes = 32;

/// A joint that avoids, with fixed joints before it folded in; its axis is the z axis of its frame.
struct FlatJoint {
  double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< axes of its frame at q = 0 in the last one's, column by column
  double p[3] = {0, 0, 0};                    ///< its origin there [m]; of the first joint: in W
  bool turned = false;                        ///< R is not the identity
  bool slides = false;
  double lower = 0.0;  ///< [rad | m]
  double upper = 0.0;
  double lever = 0.0;  ///< no segment of a body moves faster per joint rate [m/rad | 1]
};

/// A capsule on a joint's frame, or in W if it never moves.
struct FlatBody {
  int joint = -1;         ///< whose frame; −1: W
  double p[3] = {};       ///< one end of its segment [m]
  double d[3] = {};       ///< from there to the other [m]
  double radius = 0.0;    ///< [m]
  double inverse2 = 0.0;  ///< 1/|d|², 0 for a point [1/m²]
  unsigned boxes = 0;     ///< bit k: it can come near FlatProblem::box[k]
  double reach = 0.0;     ///< of the ball round the segment's middle that holds the capsule [m]
};

/// Numbers that say roughly where an arm's bodies are (rough_distance.hpp).
inline constexpr int kRoughLanes = 8;
inline constexpr int kRoughMost = 6 * kFlatBodies;

struct FlatPair {
  int first = 0;   ///< indices into FlatArm::body
  int second = 0;  ///< the one that moves more
};

struct FlatArm {
  int joints = 0;
  FlatJoint joint[kFlatJoints];
  int bodies = 0;
  int fixed = 0;  ///< the first of them never move
  FlatBody body[kFlatBodies];
  int pairs = 0;
  FlatPair pair[kFlatPairs];
};

inline std::ptrdiff_t rough_numbers(const FlatArm& arm) {
  return std::ptrdiff_t{6} * kRoughLanes * ((arm.bodies + kRoughLanes - 1) / kRoughLanes);
}

/// A box that stands still.
struct FlatBox {
  double R[9];     ///< its axes in W, column by column
  double c[3];     ///< its centre in W [m]
  double half[3];  ///< half extents [m]
  double low[3];   ///< of its bounding box along the axes of W [m]
  double high[3];
};

inline constexpr int kStrategyNumbers = kFlatJoints - 2;

/// How the problem is simulated.
struct FlatProblem {
  int arms = 0;
  FlatArm arm[kFlatArms];
  int boxes = 0;
  FlatBox box[kFlatBoxes];
  double step = 0.05 / 0.85;   ///< Δ [rad]
  double distance = 0.05;      ///< h, to arms and obstacles [m]
  double rounding = 0.0;       ///< distances of two arms in single precision are off by less [m]
  double self_distance = 0.0;  ///< between links of one arm [m]
  int timeout_factor = 200;          ///< a task that takes this many times its free time is a fault
  int basis = 0;               ///< BasisOrder of planner/methods/strategy/plane.hpp
  bool nearest_first = false;  ///< neighbours are tried nearest to the goal first, not in the paper's order
};

/// The straight ways of an arm's first tasks as far as no fault comes between them: the same for all strategies, and
/// looked at once. Places after each step.
struct FlatPaths {
  int tasks = 0;                  ///< 0: none are known
  std::int32_t* first = nullptr;  ///< [task]: its first step in what follows
  std::uint8_t* alone = nullptr;  ///< [step]: 1: within limits, clear of itself and of boxes
  float* places = nullptr;        ///< [step][rough_numbers]
};

/// What the arms have to do, drawn beforehand, so that all strategies get the same. Areas of an arm are numbered in the
/// order in which it goes through them; it starts in the first.
struct FlatTasks {
  int tasks = 0;                              ///< of each arm, N
  int areas[kFlatArms] = {};                  ///< of each arm
  const double* goals[kFlatArms] = {};        ///< [task][area][joint]: the goal of a task that leads there [rad]
  const std::int32_t* waits[kFlatArms] = {};  ///< [task]: steps before it begins
  int starts = 0;                             ///< > 0
  const double* start[kFlatArms] = {};        ///< [start][joint]: at the beginning, and after the k-th fault [rad]
  FlatPaths paths[kFlatArms];
};

struct FlatStrategy {
  double coefficients[kStrategyNumbers] = {};
  double direction = 1.0;
};

struct RunOptions {
  bool stop_at_fault = false;           ///< the first fault ends the run
  bool find_cycles = true;              ///< who repeats himself is not simulated until his time is over: same result
  std::int32_t* times[kFlatArms] = {};  ///< [task]: steps that each took, if wanted
};

struct RunResult {
  int tasks[kFlatArms] = {};     ///< that were done or faulty, at most N of each arm
  int faults[kFlatArms] = {};    ///< of these
  double time[kFlatArms] = {};   ///< of these, sum [steps]
  double time2[kFlatArms] = {};  ///< of these, sum of squares [steps²]
  std::uint64_t arm_ticks = 0;   ///< steps that arms under way were simulated for
};

/// `strategies`: one an arm.
using RunKernel = void (*)(const FlatProblem& problem, const FlatTasks& tasks, const FlatStrategy* strategies,
                           const RunOptions& options, RunResult& result);
/// Whether each of the arms, at q[arm] [rad], is at least h from everything that it must avoid: its limits, itself,
/// boxes, and (if `others`) the other arms. Bit i: arm i is.
using ClearKernel = unsigned (*)(const FlatProblem& problem, const double* const* q, bool others);

/// Fills the arrays of tasks.paths for the tasks that they have room for: of each, as many steps as lie between its
/// first and the next one's, and then some.
using PathsKernel = void (*)(const FlatProblem& problem, const FlatTasks& tasks);

/// The ones for this machine; both give the same result to the last bit.
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
