/// A roadmap that is kept: what the first query of a scene costs, the second one, and the same after a box has moved
/// into its way, beside roadmaps that begin anew.

#include <cmath>
#include <optional>

#include "planner/global/prm.hpp"
#include "tests/bench/query_set.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;

std::vector<float> floats_of(const Space& space, const std::vector<double>& q) {
  std::vector<float> result(space.stride, 0.0F);
  for (std::size_t j = 0; j < q.size(); ++j) result[j] = static_cast<float>(q[j]);
  return result;
}

bool is_free(const Points& path, const Validity& validity) {
  for (int i = 0; i + 1 < path.size(); ++i) {
    if (!validity.proven_free(path[i], path[i + 1])) return false;
  }
  return true;
}

/// The world with one box shifted by at most 30 cm so that it cuts the path but leaves its ends free.
std::optional<std::vector<WorldBody>> cut(const QueryScene& scene, const Points& path, Validity& moved,
                                          Random& random) {
  for (int i = 0; i < 200; ++i) {
    std::vector<WorldBody> world = scene.world;
    WorldBody& box = world[random.next() % world.size()];
    for (int k = 0; k < 3; ++k) box.X_WS.translation()[k] += random.uniform(-0.17, 0.17);
    moved.set_world(world);
    const bool ends = moved.state_free(path[0]) && moved.state_free(path[path.size() - 1]);
    if (ends && !is_free(path, moved)) return world;
  }
  return std::nullopt;
}

struct Sum {
  Timings first, second, moved, anew;
  double trials = 0.0, solved = 0.0, solved_anew = 0.0, invalid = 0.0;
};

void run_pair(const QueryScene& scene, const QueryScene::Query& one, const QueryScene::Query& two, Random& random,
              Sum& sum) {
  const Space space = space_of(scene.validity, one.start, one.goal);
  Validity validity = scene.validity;
  const std::vector<float> from[] = {floats_of(space, one.start), floats_of(space, two.start)};
  const std::vector<float> to[] = {floats_of(space, one.goal), floats_of(space, two.goal)};
  const auto ask = [&](Roadmap& roadmap, int which, Timings& timings) {
    SearchProblem problem{validity, space, from[which].data(), to[which].data()};
    problem.budget.ended = processor_deadline(kLongestSearch);
    problem.check.proven = true;
    SearchResult found;
    timings.add(processor_time_once([&] { found = roadmap.query(problem); }));
    return found;
  };
  Roadmap kept(space);
  if (!ask(kept, 0, sum.first).solved) return;
  const SearchResult second = ask(kept, 1, sum.second);
  if (!second.solved) return;
  const auto world = cut(scene, second.path, validity, random);
  if (!world) return;
  ++sum.trials;
  kept.world_changed();
  const SearchResult around = ask(kept, 1, sum.moved);
  Roadmap fresh(space);
  sum.solved_anew += ask(fresh, 1, sum.anew).solved ? 1.0 : 0.0;
  if (!around.solved) return;
  ++sum.solved;
  test::FclReferee referee(validity, *world);
  std::vector<std::vector<double>> path;
  for (int i = 0; i < around.path.size(); ++i) path.emplace_back(around.path[i], around.path[i] + 6);
  sum.invalid += referee.collisions_on(path, validity.options().step / 10) > 0 ? 1.0 : 0.0;
}

void kept_roadmaps(benchmark::State& state) {
  for (auto _ : state) {
    Sum sum;
    Random random(3);
    for (const QueryScene& scene : query_set()) {
      for (std::size_t i = 0; i + 1 < scene.queries.size(); i += 2) {
        run_pair(scene, scene.queries[i], scene.queries[i + 1], random, sum);
      }
    }
    set_iteration_time(state, sum.first.total() + sum.second.total() + sum.moved.total() + sum.anew.total());
    state.counters["first_p50_us"] = sum.first.percentile(0.5);
    state.counters["second_p50_us"] = sum.second.percentile(0.5);
    state.counters["moved_p50_us"] = sum.moved.percentile(0.5);
    state.counters["anew_p50_us"] = sum.anew.percentile(0.5);
    state.counters["first_p95"] = sum.first.percentile(0.95);
    state.counters["second_p95"] = sum.second.percentile(0.95);
    state.counters["moved_p95"] = sum.moved.percentile(0.95);
    state.counters["anew_p95"] = sum.anew.percentile(0.95);
    state.counters["cut"] = sum.trials;
    state.counters["solved"] = sum.solved;
    state.counters["solved_anew"] = sum.solved_anew;
    state.counters["invalid"] = sum.invalid;
  }
}

BENCHMARK(kept_roadmaps)->Name("roadmap/kept")->Iterations(1)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
