#include "tests/bench/query_set.hpp"

#include <ctime>

#include "tests/bench/ompl_peer.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;

constexpr int kScenes = 10;
constexpr int kQueriesOfAScene = 20;

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

ValidityOptions steps() {
  ValidityOptions options;
  options.step = 0.031;
  return options;
}

std::vector<QueryScene> draw_set() {
  std::vector<QueryScene> scenes;
  scenes.reserve(kScenes);
  Random random(11);
  for (int i = 0; i < kScenes; ++i) {
    QueryScene& scene = scenes.emplace_back(20, random);
    test::FclCollisionChecker checker(scene.validity, scene.world);
    while (scene.queries.size() < kQueriesOfAScene) {
      QueryScene::Query query{draw_free(scene.validity, checker, random), draw_free(scene.validity, checker, random)};
      if (checker.collisions_on({query.start, query.goal}, scene.validity.options().step) == 0) continue;
      if (!path_exists(scene.validity, checker, query.start, query.goal)) continue;
      query.length = plan(scene.validity, query.start, query.goal).length;
      scene.queries.push_back(std::move(query));
    }
  }
  return scenes;
}

}  // namespace

std::function<bool()> processor_deadline(double seconds) {
  return [end = processor_seconds() + seconds] { return processor_seconds() > end; };
}

QueryScene::QueryScene(int boxes, Random& random)
    : world(test::random_boxes(boxes, random)), validity({CellGeometry({test::puma()}, 0)}, world, steps()) {}

std::vector<double> draw_free(const Validity& validity, test::FclCollisionChecker& checker, Random& random) {
  const std::vector<double> zero(validity.dimensions(), 0.0);
  const Space space = space_of(validity, zero, zero);
  std::vector<float> q(space.stride);
  do {
    space.sample(random, q.data());
  } while (!validity.state_free(q.data()) || checker.collides(q.data()));
  return {q.begin(), q.begin() + space.dimensions};
}

bool path_exists(const Validity& validity, test::FclCollisionChecker& checker, const std::vector<double>& start,
                 const std::vector<double>& goal) {
  PlanOptions options;
  options.seed = 77;
  options.check.proven = false;
  options.budget.iterations = 20'000;
  return plan(validity, start, goal, options).solved() || plan_with_ompl(validity, checker, start, goal, 1.0).solved;
}

const std::vector<QueryScene>& query_set() {
  static const std::vector<QueryScene> set = draw_set();
  return set;
}

}  // namespace hecaton::bench
