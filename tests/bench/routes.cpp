#include "planner/route/route_search.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/run_benchmarks.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 10'000.0;  // a control period [µs]
constexpr int kQuestions = 200;
constexpr int kMostDraws = 200'000;
constexpr double kRoom = 0.03;  // at both ends [m]

/// True if arm 0 is free at q, with all other bodies as in `now`.
class Room {
 public:
  explicit Room(const PairsCell& cell) : geometry_(cell.geometry().arms(), 0), validity_(with(cell)) {}

  void look(const Instant& now) {
    std::vector<Pose> X_WO;
    for (const world::ObstacleState& obstacle : now.obstacles) X_WO.push_back(obstacle.X_WO);
    validity_.set_world(global::world_bodies(geometry_, X_WO, now.q));
  }
  [[nodiscard]] bool at(const JointVector& q) const {
    std::vector<float> padded(validity_.stride(), 0.0F);
    for (Eigen::Index j = 0; j < q.size(); ++j) padded[j] = static_cast<float>(q[j]);
    return validity_.state_free(padded.data());
  }

 private:
  global::Validity with(const PairsCell& cell) {
    geometry_.set_obstacles(cell.obstacles());
    global::ValidityOptions options;
    options.padding = kRoom;
    return {{geometry_}, {}, options};
  }
  CellGeometry geometry_;
  global::Validity validity_;
};

/// Routes of a blocked arm of three among 20 boxes: the straight line of each question is not free.
void routes(benchmark::State& state) {
  PairsCell cell(20060521);
  RouteSearch search(cell.geometry().arms(), std::vector<LocalParameters>(3), 0);
  search.set_obstacles(cell.obstacles());
  Room room(cell);
  Timings answers;
  int found = 0;
  int within_one = 0;
  int within_two = 0;
  int asked = 0;
  for (int draw = 0; draw < kMostDraws && asked < kQuestions; ++draw) {
    show_progress(asked, kQuestions, "questions");
    const Instant from = cell.draw();
    const Instant to = cell.draw();
    room.look(from);
    if (!room.at(from.q[0]) || !room.at(to.q[0])) continue;
    RouteQuestion question;
    question.planned = {0};
    question.q = {from.q[0]};
    question.q_goal = {to.q[0]};
    question.arms = from.q;
    question.obstacles.assign(from.obstacles.begin(), from.obstacles.end());
    question.seed = static_cast<std::uint64_t>(draw) + 1;
    RouteAnswer answer;
    const double taken = time_once([&] { answer = search.answer(question); });
    if (answer.kind != RouteAnswer::Kind::kFound && answer.kind != RouteAnswer::Kind::kNone) continue;
    ++asked;
    found += answer.kind == RouteAnswer::Kind::kFound ? 1 : 0;
    within_one += taken < kPeriod ? 1 : 0;
    within_two += taken < 2.0 * kPeriod ? 1 : 0;
    answers.add(taken);
  }
  for (auto _ : state) set_iteration_time(state, answers.percentile(0.5));
  report(state, answers);
  state.counters["asked"] = asked;
  state.counters["found"] = found;
  state.counters["in_one_period"] = within_one;
  state.counters["in_two_periods"] = within_two;
}

BENCHMARK(routes)->Iterations(1)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
