/// All methods on the same 200 queries, as [Cardenas10] compares its two families.

#include <string>

#include "planner/global/prm/prm.hpp"
#include "planner/global/timed_path.hpp"
#include "planner/methods/potential_field/gradient_path.hpp"
#include "tests/bench/query_set.hpp"
#include "tests/bench/run_benchmarks.hpp"
#include "tests/bench/timings.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;
using potential::Attraction;
using potential::PotentialParameters;
using Path = std::vector<std::vector<double>>;

constexpr int kFiner = 10;  ///< FCL looks at paths so many times as finely as the planners do

double length_of(const Path& path) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    double square = 0.0;
    for (std::size_t j = 0; j < path[i].size(); ++j) square += std::pow(path[i + 1][j] - path[i][j], 2);
    sum += std::sqrt(square);
  }
  return sum;
}

/// Figures of one method.
class Account {
 public:
  /// `path`: as shortened; empty: not solved. `search_us` and the time of shortening [µs].
  void add(const QueryScene& scene, const QueryScene::Query& query, const Path& path, double search_us,
           double shortening_us, test::FclCollisionChecker& checker) {
    search_.add(search_us);
    both_.add(search_us + shortening_us);
    ++queries_;
    if (path.empty()) return;
    ++solved_;
    length_ += length_of(path);
    ratio_ += length_of(path) / query.length;
    duration_ += timed_path(scene.validity, path).duration();
    invalid_ += checker.collisions_on(path, scene.validity.options().step / kFiner) > 0 ? 1.0 : 0.0;
  }

  void tell(benchmark::State& state) const {
    set_iteration_time(state, search_.total());
    state.counters["queries"] = queries_;
    state.counters["solved"] = solved_;
    state.counters["p50_us"] = search_.percentile(0.5);
    state.counters["p95"] = search_.percentile(0.95);
    state.counters["simplified_p50"] = both_.percentile(0.5);
    state.counters["simplified_p95"] = both_.percentile(0.95);
    state.counters["length"] = length_ / std::max(1.0, solved_);
    state.counters["length_ratio"] = ratio_ / std::max(1.0, solved_);
    state.counters["duration_s"] = duration_ / std::max(1.0, solved_);
    state.counters["invalid"] = invalid_;
  }

 private:
  Timings search_, both_;
  double queries_ = 0.0, solved_ = 0.0, length_ = 0.0, ratio_ = 0.0, duration_ = 0.0, invalid_ = 0.0;
};

/// Calls `enter(scene)` for each scene and `solve(scene, query, account, checker)` for each query.
template <typename Enter, typename Solve>
void run_all(benchmark::State& state, const Enter& enter, const Solve& solve) {
  const std::vector<QueryScene>& scenes = query_set();
  std::size_t all = 0;
  for (const QueryScene& scene : scenes) all += scene.queries.size();
  for (auto _ : state) {
    Account account;
    std::size_t done = 0;
    for (const QueryScene& scene : scenes) {
      test::FclCollisionChecker checker(scene.validity, scene.world);
      enter(scene);
      for (const QueryScene::Query& query : scene.queries) {
        show_progress(static_cast<double>(done++), static_cast<double>(all), "queries");
        solve(scene, query, account, checker);
      }
    }
    account.tell(state);
  }
}

/// A separate search for every query.
void searched(benchmark::State& state, PlanOptions options) {
  options.simplify = false;
  run_all(
      state, [](const QueryScene&) {},
      [&](const QueryScene& scene, const QueryScene::Query& query, Account& account,
          test::FclCollisionChecker& checker) {
        options.budget.ended = processor_deadline(kLongestSearch);
        Plan found;
        const double us = processor_time_once([&] { found = plan(scene.validity, query.start, query.goal, options); });
        const double more = processor_time_once([&] { simplify(scene.validity, options, found); });
        account.add(scene, query, found.path, us, more, checker);
      });
}

/// A scene for a potential field.
struct FieldScene {
  CellGeometry geometry{{test::puma()}, 0};
  potential::PotentialField field;
  potential::FreeMotion motion;

  FieldScene(const QueryScene& scene, const PotentialParameters& parameters)
      : FieldScene(obstacles_of(scene), parameters) {}

 private:
  FieldScene(const std::vector<world::Obstacle>& obstacles, const PotentialParameters& parameters)
      : geometry(with(obstacles)), field(geometry, parameters), motion(geometry, states_of(obstacles), {}, 0.0) {}

  static std::vector<world::Obstacle> obstacles_of(const QueryScene& scene) {
    std::vector<world::Obstacle> obstacles;
    for (const WorldBody& body : scene.world) {
      world::Obstacle& obstacle = obstacles.emplace_back();
      obstacle.name = body.name;
      obstacle.shapes.push_back({body.shape});
      obstacle.X_WO = body.X_WS;
    }
    return obstacles;
  }
  static CellGeometry with(const std::vector<world::Obstacle>& obstacles) {
    CellGeometry geometry({test::puma()}, 0);
    geometry.set_obstacles(obstacles);
    return geometry;
  }
  static std::vector<world::ObstacleState> states_of(const std::vector<world::Obstacle>& obstacles) {
    std::vector<world::ObstacleState> states;
    for (const world::Obstacle& obstacle : obstacles) states.push_back({obstacle.X_WO, {}, 0.0});
    return states;
  }
};

void down_a_field(benchmark::State& state, Attraction attraction) {
  PotentialParameters parameters;
  parameters.attraction = attraction;
  std::unique_ptr<FieldScene> field;
  const auto vector_of = [](const std::vector<double>& q) {
    return JointVector(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
  };
  run_all(
      state, [&](const QueryScene& scene) { field = std::make_unique<FieldScene>(scene, parameters); },
      [&](const QueryScene& scene, const QueryScene::Query& query, Account& account,
          test::FclCollisionChecker& checker) {
        potential::Descent descent;
        const double us = processor_time_once([&] {
          descent = potential::descend(field->field, field->motion, field->geometry.own_arm().limits,
                                       vector_of(query.start), vector_of(query.goal));
        });
        Path path;
        double more = 0.0;
        if (descent.outcome == potential::DescentOutcome::kReached) {
          std::vector<JointVector> refined;
          more = processor_time_once([&] { refined = potential::refine(descent.path, field->motion); });
          for (const JointVector& q : refined) path.emplace_back(q.begin(), q.end());
        }
        account.add(scene, query, path, us, more, checker);
      });
}

PlanOptions by(std::shared_ptr<const GlobalPlanner> planner) {
  PlanOptions options;
  options.planner = std::move(planner);
  return options;
}

void add(const std::string& name, const std::function<void(benchmark::State&)>& run) {
  benchmark::RegisterBenchmark(("methods/" + name).c_str(), run)
      ->Iterations(1)
      ->UseManualTime()
      ->Unit(benchmark::kMicrosecond);
}

[[maybe_unused]] const bool kRegistered = [] {
  add("potential_field/control_points", [](auto& state) { down_a_field(state, Attraction::kControlPoints); });
  add("potential_field/joints", [](auto& state) { down_a_field(state, Attraction::kJoints); });
  for (const auto& planner : built_in_planners().planners()) {
    add(std::string(planner->traits().name), [planner](auto& state) { searched(state, by(planner)); });
  }
  add("prm/dijkstra", [](auto& state) {
    searched(state, by(std::make_shared<const Prm>(PrmParameters{.search = RoadmapSearch::kDijkstra})));
  });
  return true;
}();

}  // namespace
}  // namespace hecaton::bench
