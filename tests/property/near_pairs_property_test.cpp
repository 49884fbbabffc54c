// The broad phases of contact monitor and ray caster change no result: random cells, against every pair by itself.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pairwise_contacts.hpp"
#include "world/sim/contact_monitor.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kOfObstacles = static_cast<std::size_t>(ContactKind::kArmObstacle);

class RandomCell {
 public:
  RandomCell(std::uint64_t seed, int obstacles, double spread) : random_(seed), spread_(spread) {
    for (int arm = 0; arm < 2; ++arm) {
      ArmBodies& bodies = arms.emplace_back();
      bodies.name = "arm" + std::to_string(arm);
      for (int link = 0; link < 5; ++link) {
        bodies.parts.push_back({link, "link" + std::to_string(link), {shape(0.1), pose(0.1)}, link > 0});
        phases_.push_back({uniform(0, 6), uniform(0, 6), uniform(0, 6), uniform(0.4, 1.5)});
      }
    }
    // arm0 carries the first obstacle, which is for the reference one more link.
    piece_ = {"arm0", {{0, "piece", {shape(0.05), pose(0.02)}, true}}, {}, {}};
    X_TO_ = pose(0.2);
    Obstacle carried;
    carried.name = "piece";
    carried.shapes = {piece_.parts[0].shape};
    carried.attachment = Attachment{"arm0", X_TO_};
    all.push_back(carried);
    for (int i = 0; i < obstacles; ++i) {
      Obstacle& one = standing.emplace_back();
      one.name = "obstacle" + std::to_string(i);
      one.shapes.push_back({shape(0.05), pose(0.02)});
      one.X_WO = pose(spread);
    }
    all.insert(all.end(), standing.begin(), standing.end());
    for (const Obstacle& one : all) states.push_back({one.X_WO, {}, 0.0});
    changes.assign(all.size(), 1);
  }

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3d point(double spread) {
    return {uniform(-spread, spread), uniform(-spread, spread), uniform(-spread, spread)};
  }
  Pose pose(double spread) {
    return pose_from_xyz_rpy(point(spread), {uniform(-3, 3), uniform(-1.5, 1.5), uniform(-3, 3)});
  }
  Shape shape(double size) {
    const auto length = [&] { return uniform(0.2 * size, size); };
    switch (std::uniform_int_distribution<int>(0, 4)(random_)) {
      case 0:
        return Box{{length(), length(), length()}};
      case 1:
        return Sphere{length()};
      case 2:
        return Capsule{length(), length()};
      case 3:
        return Cylinder{length(), length()};
      default:
        break;
    }
    auto hull = std::make_shared<ConvexHull>();
    const double a = length();
    hull->vertices = {{-a, -a, -a}, {2 * a, 0, 0}, {0, 2 * a, 0}, {0, 0, 2 * a}};
    hull->faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return Convex{hull};
  }

  /// Moves all links on closed curves, and what arm0 carries.
  void move(double time) {
    links.assign(2, {});
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      const auto& [x, y, z, rate] = phases_[i];
      const double t = rate * time;
      links[i / 5].push_back(pose_from_xyz_rpy(
          {spread_ * std::sin(t + x), spread_ * std::sin(1.3 * t + y), spread_ * std::sin(0.7 * t + z)}, {t, x, y}));
    }
    states[0].X_WO = links[0][4] * X_TO_;
    ++changes[0];
    last_change_ = std::max(last_change_, changes[0]);
  }
  /// Puts an obstacle that stands elsewhere.
  void put_elsewhere() {
    const auto i = std::uniform_int_distribution<std::size_t>(1, all.size() - 1)(random_);
    states[i].X_WO = pose(spread_);
    changes[i] = changes[0] = ++last_change_;
  }

  void update(ContactMonitor& monitor, double time) const {
    const MeasuredArm measured[] = {{true, links[0]}, {true, links[1]}};
    monitor.update(measured, {states, changes}, time);
  }
  /// Arms, and the piece as a link of its own.
  [[nodiscard]] PairwiseContacts pairwise() const {
    std::vector<ArmBodies> bodies = arms;
    bodies.push_back(piece_);
    return {bodies, standing};
  }
  void update(PairwiseContacts& pairwise, double time) const {
    const MeasuredArm measured[] = {{true, links[0]}, {true, links[1]}, {true, std::span(&states[0].X_WO, 1)}};
    pairwise.update(measured, std::span(states).subspan(1), time, false);
  }

  std::vector<ArmBodies> arms;
  std::vector<Obstacle> standing;
  std::vector<Obstacle> all;  ///< the carried one, and those that stand
  std::vector<ObstacleState> states;
  std::vector<std::uint64_t> changes;
  std::vector<std::vector<Pose>> links;  ///< of each arm

 private:
  struct Phase {
    double x, y, z, rate;
  };
  std::mt19937_64 random_;
  double spread_;
  std::vector<Phase> phases_;
  ArmBodies piece_;
  Pose X_TO_ = Pose::Identity();
  std::uint64_t last_change_ = 1;
};

void expect_same(const Separation& actual, const Separation& expected) {
  EXPECT_EQ(actual.distance, expected.distance);
  EXPECT_EQ(actual.a, expected.a);
  EXPECT_EQ(actual.b, expected.b);
  EXPECT_EQ(actual.time, expected.time);
}

struct Case {
  int obstacles;
  double spread;  ///< [m]
};

class NearPairsProperty : public testing::TestWithParam<Case> {};

TEST_P(NearPairsProperty, ReportsTheSameAsEveryPairByItself) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    RandomCell cell(seed, GetParam().obstacles, GetParam().spread);
    ContactMonitor monitor(cell.arms);
    monitor.set_obstacles(cell.all);
    PairwiseContacts pairwise = cell.pairwise();
    for (int i = 0; i < 250; ++i) {
      const double time = 0.02 * i;
      cell.move(time);
      if (i % 20 == 7) cell.put_elsewhere();
      if (i % 60 == 31) monitor.set_obstacles(cell.all);  // an edit keeps the totals
      if (i == 150) {                                     // another process continues
        ContactMonitor next(cell.arms);
        next.set_obstacles(cell.all);
        next.restore(monitor.checkpoint());
        monitor = std::move(next);
      }
      cell.update(monitor, time);
      cell.update(pairwise, time);
      const ContactReport report = monitor.report();
      ASSERT_EQ(report.kinds[kOfObstacles].contacts, pairwise.contacts().size()) << "step " << i;
      expect_same(report.kinds[kOfObstacles].smallest, pairwise.smallest());
      if (testing::Test::HasFailure()) FAIL() << "step " << i;
    }
    std::size_t next = 0;
    for (const Separation& event : monitor.report().events) {
      if (event.kind == ContactKind::kArmObstacle) expect_same(event, pairwise.contacts()[next++]);
    }
    contacts += pairwise.contacts().size();
  }
  EXPECT_TRUE(GetParam().obstacles < 20 || contacts > 0);
}

TEST_P(NearPairsProperty, NearestIsTheLeastOfEveryPair) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomCell cell(seed, GetParam().obstacles, GetParam().spread);
    cell.arms.resize(1);  // only obstacles are near
    cell.all.erase(cell.all.begin());
    ContactMonitor monitor(cell.arms);
    monitor.set_obstacles(cell.all);
    for (int i = 0; i < 20; ++i) {
      cell.move(0.3 * i);
      const MeasuredArm measured[] = {{true, cell.links[0]}};
      const std::span<const ObstacleState> standing = std::span(cell.states).subspan(1);
      monitor.update(measured, standing, 0.3 * i);
      PairwiseContacts pairwise(cell.arms, cell.standing);
      pairwise.update(measured, standing, 0.3 * i, false);
      const auto nearest = monitor.nearest(0);
      ASSERT_TRUE(nearest.has_value());
      expect_same(*nearest, pairwise.smallest());
    }
  }
}

TEST_P(NearPairsProperty, RaysEndWhereTheyEndOnEachObstacleByItself) {
  RandomCell cell(11, GetParam().obstacles, GetParam().spread);
  RayCaster all;
  all.set_obstacles(cell.all);
  std::vector<RayCaster> each(cell.standing.size());
  int hits = 0;
  for (int round = 0; round < 10; ++round) {
    cell.move(0.1 * round);
    for (int i = 0; i < 5; ++i) cell.put_elsewhere();
    all.place({cell.states, cell.changes});
    for (std::size_t i = 0; i < each.size(); ++i) {
      each[i].set_obstacles(std::span(&cell.standing[i], 1));
      each[i].place(std::span<const ObstacleState>(&cell.states[i + 1], 1));
    }
    for (int ray = 0; ray < 40; ++ray) {
      const Vector3d aim = cell.states[1 + ray % each.size()].X_WO.translation() + cell.point(0.05);
      const Vector3d p = aim + cell.point(0.8);
      const Vector3d d = (aim - p).normalized();
      std::optional<double> nearest;
      for (const RayCaster& one : each) {
        const auto distance = one.cast(p, d, 1.5);
        if (distance && (!nearest || *distance < *nearest)) nearest = distance;
      }
      ASSERT_EQ(all.cast(p, d, 1.5), nearest) << "round " << round << ", ray " << ray;
      hits += nearest ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 0);
}

INSTANTIATE_TEST_SUITE_P(Cells, NearPairsProperty,
                         testing::Values(Case{1, 0.5}, Case{20, 1.0}, Case{300, 1.0}, Case{300, 4.0}));

}  // namespace
}  // namespace hecaton::world
