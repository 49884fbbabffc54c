#include "planner/strategy_search/run_kernel.hpp"
#include "planner/strategy_search/runner.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

/// Looks at a straight way, four places at a time; the goal is among them.
void precheck_path(const FlatProblem& problem, const FlatArm& arm, const Plane& plane, std::uint8_t* alone,
                 float* places) {
  const std::ptrdiff_t numbers = rough_numbers(arm);
  PlaneState state;
  while (plane_frame(state.at, plane.distance).left > 0.0) {
    PlanePoint at[kLanes];
    const int count = plane.next_places(state, problem.step, at);
    Lanes q[kFlatJoints];
    plane.four_q(arm, at, q);
    FourPlaces four_places;
    place(arm, q, four_places);
    check_alone(problem, arm, q, four_places);
    float* to[kLanes];
    for (int k = 0; k < kLanes; ++k) to[k] = places + k * numbers;
    round_places(arm, four_places, to);
    for (int k = 0; k < kLanes; ++k) alone[k] = (four_places.alone >> k) & 1U;
    alone += count;
    places += count * numbers;
    state.at = at[count - 1];
  }
}

}  // namespace

void precheck_paths(const FlatProblem& problem, const FlatTasks& tasks) {
  for (int i = 0; i < problem.arms; ++i) {
    const FlatArm& arm = problem.arm[i];
    const FlatPaths& paths = tasks.paths[i];
    double q[kFlatJoints];
    for (int j = 0; j < arm.joints; ++j) q[j] = tasks.start[i][j];
    int area = 0;
    for (int task = 0; task < paths.tasks; ++task) {
      area = area + 1 == tasks.areas[i] ? 0 : area + 1;
      Plane plane;
      plane.begin(q, tasks.goals[i] + (static_cast<std::int64_t>(task) * tasks.areas[i] + area) * arm.joints,
                  arm.joints);
      const auto first = static_cast<std::int64_t>(paths.first[task]);
      precheck_path(problem, arm, plane, paths.alone + first, paths.places + first * rough_numbers(arm));
      plane.q(arm, {plane.distance, 0.0}, q);
    }
  }
}

}  // namespace hecaton::planner::HECATON_ISA
