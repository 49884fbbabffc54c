/// P5: RRT-Connect for a robot loaded at run time on MotionBenchMaker's problems [Chamzas21].

#include "tests/bench/motionbenchmaker.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>

#include "planner/collision/model_filter.hpp"
#include "planner/global/plan.hpp"
#include "services/config/moveit_files.hpp"
#include "tests/bench/timings.hpp"
#include "tests/support/fcl_collision_checker.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;

struct Problem {
  std::string name;
  std::vector<WorldBody> world;
  std::vector<double> start;
  std::vector<double> goal;
};
using Family = std::vector<Problem>;

constexpr int kCalls = 5;

std::vector<double> ordered(const RobotModel& model, const std::map<std::string, double>& positions) {
  std::vector<double> q;
  for (const std::string& joint : model.joint_names) q.push_back(positions.at(joint));
  return q;
}

Problem read_problem(const RobotModel& model, const std::filesystem::path& scene) {
  Problem problem{scene, {}, {}, {}};
  for (const world::Obstacle& obstacle : config::read_moveit_scene(scene).obstacles) {
    for (const world::PlacedShape& placed : obstacle.shapes) {
      problem.world.push_back({placed.shape, obstacle.X_WO * placed.X_BS, obstacle.name});
    }
  }
  const std::string number = scene.stem().string().substr(5);
  const auto request = config::read_moveit_request(scene.parent_path() / ("request" + number + ".yaml"));
  problem.start = ordered(model, request.start);
  problem.goal = ordered(model, request.goal);
  return problem;
}

class Sum {
 public:
  explicit Sum(bool proven) : proven_(proven) {}

  void solve(const Validity& validity, const Problem& problem, test::FclCollisionChecker& checker,
             benchmark::State& state) {
    PlanOptions options;
    options.simplify = false;
    options.check.proven = proven_;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    options.budget.ended = [end] { return std::chrono::steady_clock::now() > end; };
    // The fastest of some calls: percentiles tell how problems differ, and not when another process had the processor.
    Plan found;
    Plan shorter;
    double plan_us = std::numeric_limits<double>::infinity();
    double simplify_us = std::numeric_limits<double>::infinity();
    for (int call = 0; call < kCalls; ++call) {
      plan_us =
          std::min(plan_us, processor_time_once([&] { found = plan(validity, problem.start, problem.goal, options); }));
      shorter = found;
      if (!found.solved()) break;
      simplify_us = std::min(simplify_us, processor_time_once([&] { simplify(validity, options, shorter); }));
    }
    set_iteration_time(state, plan_us);
    ++problems_;
    if (!found.solved()) {
      std::fprintf(stderr, "%s: %s\n", problem.name.c_str(), found.reason.c_str());
      invalid_ends_ += found.status == PlanStatus::kBudgetEnded ? 0 : 1;
      return;
    }
    ++solved_;
    planned_.add(plan_us);
    simplified_.add(simplify_us);
    both_.add(plan_us + simplify_us);
    iterations_ += static_cast<double>(found.iterations);
    length_ += shorter.length;
    invalid_paths_ += checker.collisions_on(shorter.path, validity.options().step / 10.0) > 0 ? 1 : 0;
  }

  void tell(benchmark::State& state) const {
    report(state, planned_);
    state.counters["p95"] = planned_.percentile(0.95);
    state.counters["simplify_p50"] = simplified_.percentile(0.5);
    state.counters["both_p50"] = both_.percentile(0.5);
    state.counters["both_p95"] = both_.percentile(0.95);
    state.counters["iterations"] = iterations_ / std::max(1.0, solved_);
    state.counters["length"] = length_ / std::max(1.0, solved_);
    state.counters["problems"] = problems_;
    state.counters["solved"] = solved_;
    state.counters["bad_ends"] = invalid_ends_;
    state.counters["invalid"] = invalid_paths_;
  }

 private:
  bool proven_;
  Timings planned_, simplified_, both_;
  double iterations_ = 0.0, length_ = 0.0;  ///< sums
  double problems_ = 0.0, solved_ = 0.0, invalid_ends_ = 0.0, invalid_paths_ = 0.0;
};

void run(benchmark::State& state, const Arm& arm, const Family& family, bool proven) {
  ValidityOptions options;
  options.step = 1.0 / 32.0;  // VAMP's for this robot
  Validity validity({CellGeometry({arm}, 0)}, {}, options);
  Sum sum(proven);
  std::size_t next = 0;
  for (auto _ : state) {
    const Problem& problem = family[next++];
    validity.set_world(problem.world);
    test::FclCollisionChecker checker(validity, problem.world);
    sum.solve(validity, problem, checker, state);
  }
  sum.tell(state);
}

}  // namespace

void register_motionbenchmaker(const std::string& urdf, const std::string& srdf, const std::string& problems) {
  UrdfOptions options;
  options.srdf_path = srdf;
  options.tool_link = "panda_hand";
  Arm arm;
  arm.name = "panda";
  arm.model = load_arm_model(urdf, options);
  arm.limits = arm.model->limits;
  std::map<std::string, Family> families;
  std::vector<std::filesystem::path> scenes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(problems)) {
    if (entry.path().filename().string().starts_with("scene")) scenes.push_back(entry.path());
  }
  std::sort(scenes.begin(), scenes.end());
  for (const auto& scene : scenes) {
    Problem problem = read_problem(*arm.model, scene);
    families["all"].push_back(problem);
    families[scene.parent_path().filename()].push_back(std::move(problem));
  }
  // The URDF's controllers stop a hair before its joints do; some goals lie in between.
  for (const Problem& problem : families["all"]) {
    for (const auto* q : {&problem.start, &problem.goal}) {
      const Eigen::Map<const JointVector> end(q->data(), arm.model->joints());
      arm.limits.lower = arm.limits.lower.cwiseMin(end);
      arm.limits.upper = arm.limits.upper.cwiseMax(end);
    }
  }
  for (auto& [name, family] : families) {
    const auto iterations = static_cast<benchmark::IterationCount>(family.size());
    const auto shared = std::make_shared<Family>(std::move(family));
    for (const bool proven : {false, true}) {
      const std::string full = "motionbenchmaker/" + name + (proven ? "/proven" : "/unproven");
      benchmark::RegisterBenchmark(full.c_str(),
                                   [arm, shared, proven](benchmark::State& state) { run(state, arm, *shared, proven); })
          ->Iterations(iterations)
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond);
    }
  }
}

}  // namespace hecaton::bench
