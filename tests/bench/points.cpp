/// An arm among points on the surfaces of boxes, beside the same arm among the boxes.

#include <cmath>
#include <memory>

#include "planner/collision/exact_distance.hpp"
#include "planner/global/plan.hpp"
#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"
#include "planner/tick.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr int kBoxes = 20;
constexpr int kChecks = 2000;
constexpr int kTicks = 5000;
constexpr int kTicksAJourney = 250;
constexpr int kBruteEvery = 20;
constexpr double kPeriod = 0.010;  // [s]

/// A box with its pose in the world.
struct PosedBox {
  world::Box box;
  Pose X_WS = Pose::Identity();
};

std::vector<PosedBox> draw_boxes(std::mt19937_64& random) {
  std::vector<PosedBox> boxes(kBoxes);
  for (PosedBox& one : boxes) {
    const double angle = uniform(random, -3.14, 3.14);
    const double away = uniform(random, 0.4, 1.0);
    one.box.half_extents = {uniform(random, 0.02, 0.1), uniform(random, 0.02, 0.1), uniform(random, 0.02, 0.1)};
    one.X_WS.translation() = Eigen::Vector3d(away * std::cos(angle), away * std::sin(angle), uniform(random, 0.0, 1.2));
    one.X_WS.linear() = Eigen::AngleAxisd(uniform(random, -3.0, 3.0), Eigen::Vector3d::UnitX()).toRotationMatrix();
  }
  return boxes;
}

/// `count` points on the boxes, with balls that close the gaps between them.
std::shared_ptr<const world::PointCloud> scan(const std::vector<PosedBox>& boxes, int count, std::mt19937_64& random) {
  double area = 0.0;
  for (const PosedBox& one : boxes) {
    const Eigen::Vector3d& h = one.box.half_extents;
    area += 8.0 * (h.x() * h.y() + h.y() * h.z() + h.z() * h.x());
  }
  std::vector<Eigen::Vector3f> points;
  while (static_cast<int>(points.size()) < count) {
    const PosedBox& one = boxes[random() % boxes.size()];
    Eigen::Vector3d p(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
    const auto axis = static_cast<Eigen::Index>(random() % 3);
    p[axis] = std::copysign(1.0, p[axis]);
    points.push_back((one.X_WS * p.cwiseProduct(one.box.half_extents)).cast<float>());
  }
  return std::make_shared<const world::PointCloud>(std::move(points), std::sqrt(area / count));
}

/// The arm among points, and among boxes.
struct Scenes {
  explicit Scenes(int count) : random(20060521), boxes(draw_boxes(random)), cloud(scan(boxes, count, random)) {
    world::Obstacle scanned;
    scanned.name = "scan";
    scanned.shapes = {{world::Points{cloud}}};
    of_points.set_obstacles({&scanned, 1});
    std::vector<world::Obstacle> all;
    for (const PosedBox& one : boxes) {
      world::Obstacle& box = all.emplace_back();
      box.name = "box" + std::to_string(all.size());
      box.shapes = {{one.box}};
      box.X_WO = one.X_WS;
      box_states.emplace_back().X_WO = one.X_WS;
    }
    of_boxes.set_obstacles(all);
  }

  [[nodiscard]] JointVector draw() {
    const JointLimits& limits = of_points.own_arm().limits;
    JointVector q(limits.lower.size());
    for (Eigen::Index j = 0; j < q.size(); ++j)
      q[j] = uniform(random, std::max(-3.0, limits.lower[j]), std::min(3.0, limits.upper[j]));
    return q;
  }
  [[nodiscard]] global::Validity validity(const CellGeometry& geometry,
                                          const std::vector<world::ObstacleState>& states) const {
    std::vector<Pose> X_WO;
    for (const auto& state : states) X_WO.push_back(state.X_WO);
    return global::Validity({geometry}, global::world_bodies(geometry, X_WO, std::vector<JointVector>(1)));
  }
  /// The smallest distance of a moving link from a ball, ball by ball [m].
  [[nodiscard]] double all_balls(const JointVector& q) const {
    const Arm& arm = of_points.own_arm();
    Kinematics kinematics;
    forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
    double least = HUGE_VAL;
    for (const Body& body : of_points.own_bodies()) {
      const auto* capsule = std::get_if<world::Capsule>(&body.shape);
      if (capsule == nullptr) continue;
      const Pose X_WS = kinematics.X_WL[body.link] * body.X_CS;
      const Eigen::Vector3d axis = X_WS.linear().col(2);
      for (const Eigen::Vector3f& point : cloud->points()) {
        const Eigen::Vector3d way = point.cast<double>() - X_WS.translation();
        const double along = std::clamp(way.dot(axis), -capsule->half_length, capsule->half_length);
        least = std::min(least, (way - along * axis).norm() - capsule->radius - cloud->radius());
      }
    }
    return least;
  }

  std::mt19937_64 random;
  std::vector<PosedBox> boxes;
  std::shared_ptr<const world::PointCloud> cloud;
  CellGeometry of_points{{puma_like("arm", Eigen::Vector3d::Zero())}, 0};
  CellGeometry of_boxes{{puma_like("arm", Eigen::Vector3d::Zero())}, 0};
  std::vector<world::ObstacleState> point_states{1};
  std::vector<world::ObstacleState> box_states;
};

void report_brute(benchmark::State& state, const Timings& ours, const Timings& brute, double share) {
  state.counters["brute_p50"] = brute.percentile(0.5) * share;
  state.counters["brute_ratio"] = brute.percentile(0.5) * share / ours.percentile(0.5);
}

/// Eight configurations at a time.
void states(benchmark::State& state, int count) {
  Scenes scenes(count);
  const global::Validity points = scenes.validity(scenes.of_points, scenes.point_states);
  const global::Validity boxes = scenes.validity(scenes.of_boxes, scenes.box_states);
  const auto stride = static_cast<std::size_t>(points.stride());
  std::vector<float> q(global::kWidth * stride);
  Timings ours, peer, brute;
  double free = 0.0;
  double box_free = 0.0;
  int i = 0;
  for (auto _ : state) {
    JointVector one;
    for (std::size_t lane = 0; lane < global::kWidth; ++lane) {
      one = scenes.draw();
      for (Eigen::Index j = 0; j < one.size(); ++j)
        q[lane * stride + static_cast<std::size_t>(j)] = static_cast<float>(one[j]);
    }
    unsigned hits = 0;
    set_iteration_time(state, ours.measure([&] { hits = points.collisions(q.data()); }));
    free += 8.0 - __builtin_popcount(hits);
    peer.measure([&] { hits = boxes.collisions(q.data()); });
    box_free += 8.0 - __builtin_popcount(hits);
    if (i++ % kBruteEvery == 0) brute.measure([&] { benchmark::DoNotOptimize(scenes.all_balls(one)); });
  }
  report(state, ours, peer);
  report_brute(state, ours, brute, global::kWidth);
  state.counters["free"] = benchmark::Counter(free / 8.0, benchmark::Counter::kAvgIterations);
  state.counters["peer_free"] = benchmark::Counter(box_free / 8.0, benchmark::Counter::kAvgIterations);
}

/// Proven edges of 1 rad from a free configuration.
void edges(benchmark::State& state, int count) {
  Scenes scenes(count);
  const global::Validity points = scenes.validity(scenes.of_points, scenes.point_states);
  const global::Validity boxes = scenes.validity(scenes.of_boxes, scenes.box_states);
  const global::Space space = global::space_of(points);
  std::vector<float> a(static_cast<std::size_t>(space.stride)), b(a.size());
  Timings ours, peer;
  double free = 0.0;
  double box_free = 0.0;
  const auto draw = [&](std::vector<float>& q) {
    const JointVector one = scenes.draw();
    for (Eigen::Index j = 0; j < one.size(); ++j) q[static_cast<std::size_t>(j)] = static_cast<float>(one[j]);
  };
  for (auto _ : state) {
    do draw(a);
    while (!points.state_free(a.data()));
    draw(b);
    space.interpolate(a.data(), b.data(), std::min(1.0F, 1.0F / space.distance(a.data(), b.data())), b.data());
    bool ok = false;
    set_iteration_time(state, ours.measure([&] { ok = points.edge_free(a.data(), b.data()); }));
    free += ok ? 1.0 : 0.0;
    peer.measure([&] { ok = boxes.edge_free(a.data(), b.data()); });
    box_free += ok ? 1.0 : 0.0;
  }
  report(state, ours, peer);
  state.counters["free"] = benchmark::Counter(free, benchmark::Counter::kAvgIterations);
  state.counters["peer_free"] = benchmark::Counter(box_free, benchmark::Counter::kAvgIterations);
}

/// Ticks on journeys among the points; the peer ticks from the same states among the boxes.
void ticks(benchmark::State& state, int count) {
  Scenes scenes(count);
  const LocalParameters parameters;
  TickScratch scratch(scenes.of_points, parameters);
  TickScratch box_scratch(scenes.of_boxes, parameters);
  ExactDistance distance(scenes.of_points);
  TickMemory memory;
  TickMemory box_memory;
  TickInput input;
  input.dt = kPeriod;
  const std::vector<ArmObservation> arms(1);
  input.arms = arms;
  const Arm& arm = scenes.of_points.own_arm();
  Kinematics kinematics;
  Timings ours, peer, brute;
  double rows = 0.0;
  double box_rows = 0.0;
  int i = 0;
  for (auto _ : state) {
    if (i % kTicksAJourney == 0) {
      std::vector<Clearance> one(1);
      do {
        input.q = scenes.draw();
        forward_kinematics(*arm.model, arm.X_WB, input.q, kinematics);
      } while (distance.clearances({&kinematics, {&kinematics, 1}, scenes.point_states}, {.others = 0.05}, one) != 0);
      input.qd = JointVector::Zero(input.q.size());
      input.q_goal = scenes.draw();
      input.has_goal = true;
      memory = box_memory = {LocalMemory(static_cast<std::uint64_t>(i))};
    }
    const TickMemory before = memory;
    input.obstacles = scenes.point_states;
    TickResult result;
    set_iteration_time(state,
                       ours.measure([&] { memory = before; },
                                    [&] { result = tick(scenes.of_points, parameters, input, memory, scratch); }));
    rows += result.rows;
    if (i % kBruteEvery == 0) brute.measure([&] { benchmark::DoNotOptimize(scenes.all_balls(input.q)); });
    input.obstacles = scenes.box_states;
    const TickMemory box_before = box_memory;
    TickResult box_result;
    peer.measure([&] { box_memory = box_before; },
                 [&] { box_result = tick(scenes.of_boxes, parameters, input, box_memory, box_scratch); });
    box_rows += box_result.rows;
    input.q = result.q;
    input.qd = result.qd;
    if (result.status == TickStatus::kReached) input.q_goal = scenes.draw();
    ++i;
  }
  report(state, ours, peer);
  report_brute(state, ours, brute, 1.0);
  state.counters["rows"] = benchmark::Counter(rows, benchmark::Counter::kAvgIterations);
  state.counters["peer_rows"] = benchmark::Counter(box_rows, benchmark::Counter::kAvgIterations);
}

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, auto function, int count, int iterations) {
    benchmark::RegisterBenchmark(("points/" + name + "/" + std::to_string(count)).c_str(), function, count)
        ->Iterations(iterations)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  };
  for (const int count : {1000, 10'000, 100'000}) {
    add("eight_states", states, count, kChecks);
    add("edge", edges, count, kChecks);
    add("tick", ticks, count, kTicks);
  }
  return true;
}();

}  // namespace
}  // namespace hecaton::bench
