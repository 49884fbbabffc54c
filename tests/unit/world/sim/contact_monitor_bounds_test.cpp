// The monitor's bounds avoid nearly all exact distances, and change no report.
#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "tests/unit/world/sim/small_worlds.hpp"
#include "world/sim/contact_monitor.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

// Three arms of eight capsule links that swing smoothly, six obstacles.
struct Cell {
  Cell() {
    for (int arm = 0; arm < 3; ++arm) {
      ArmBodies bodies;
      bodies.name = "arm" + std::to_string(arm + 1);
      for (int link = 0; link < 8; ++link) {
        bodies.parts.push_back(
            {link, "link" + std::to_string(link), {Capsule{0.05, 0.08}, at_point(0, 0, 0.08)}, link > 0});
        for (int other = 0; other + 2 < link; ++other) bodies.self_pairs.emplace_back(other, link);
      }
      arms.push_back(bodies);
    }
    for (int i = 0; i < 6; ++i) {
      Obstacle box;
      box.name = "box" + std::to_string(i);
      box.shapes = {{Box{Vector3d(0.1, 0.1, 0.1)}, Pose::Identity()}};
      obstacles.push_back(box);
      ObstacleState state;
      state.X_WO = at_point(0.6 * std::cos(i * 1.047), 0.6 * std::sin(i * 1.047), 1.0 + 0.05 * i);
      states.push_back(state);
    }
  }

  /// Chains of links 0.16 m long, each joint bent by a sine of its own.
  std::vector<std::vector<Pose>> at(double time) const {
    std::vector<std::vector<Pose>> poses(3);
    for (int arm = 0; arm < 3; ++arm) {
      const double angle = 2.0944 * arm;
      Pose X = at_point(0.7 * std::cos(angle), 0.7 * std::sin(angle), 0);
      for (int link = 0; link < 8; ++link) {
        const double bend = link == 0 ? 0.0 : 0.35 * std::sin(0.7 * time + 1.3 * link + 2.1 * arm);
        const Vector3d axis = link % 2 == 0 ? Vector3d::UnitX() : Vector3d::UnitY();
        X.linear() = X.linear() * Eigen::AngleAxisd(bend, axis).toRotationMatrix();
        poses[arm].push_back(X);
        X = X * at_point(0, 0, 0.16);
      }
    }
    return poses;
  }

  void update(ContactMonitor& monitor, double time) const {
    const auto poses = at(time);
    std::vector<MeasuredArm> measured;
    measured.reserve(poses.size());
    for (const auto& links : poses) measured.push_back({true, links});
    monitor.update(measured, states, time);
  }

  std::vector<ArmBodies> arms;
  std::vector<Obstacle> obstacles;
  std::vector<ObstacleState> states;
};

TEST(ContactMonitorBounds, BoundsAvoidNearlyAllExactChecks) {
  const Cell cell;
  ContactMonitor monitor(cell.arms);
  monitor.set_obstacles(cell.obstacles);
  constexpr int kSteps = 10000;
  for (int i = 0; i < kSteps; ++i) cell.update(monitor, 0.01 * i);
  // 192 − 3 + 126 + 45 pairs: without bounds 3.6 million checks. 20 µs a step would allow about 8 checks each.
  EXPECT_LT(monitor.exact_checks(), 4U * kSteps);
  EXPECT_TRUE(monitor.report().kinds[kArmArm].has_smallest);
  EXPECT_TRUE(monitor.report().kinds[kArmObstacle].has_smallest);
  EXPECT_TRUE(monitor.report().kinds[kArmSelf].has_smallest);
}

TEST(ContactMonitorBounds, ReportsTheSameAsWithoutBounds) {
  // A new monitor in every step has no bounds of earlier steps. The monitor with bounds must report the minimum of
  // their distances, and at least their contacts.
  Cell cell;
  // Obstacles that sweep through the arms, so that contacts come and go.
  ContactMonitor keeper(cell.arms);
  keeper.set_obstacles(cell.obstacles);
  double least[kContactKinds] = {1e9, 1e9, 1e9};
  std::uint64_t contacts_seen_afresh = 0;
  for (int i = 0; i < 1500; ++i) {
    const double time = 0.02 * i;
    for (int k = 0; k < 6; ++k) {
      cell.states[k].X_WO = at_point(0.7 * std::cos(0.3 * time + k), 0.7 * std::sin(0.2 * time + k), 0.9 + 0.05 * k);
    }
    cell.update(keeper, time);
    ContactMonitor fresh(cell.arms);
    fresh.set_obstacles(cell.obstacles);
    cell.update(fresh, time);
    const ContactReport now = fresh.report();
    for (int kind = 0; kind < kContactKinds; ++kind) {
      least[kind] = std::min(least[kind], now.kinds[kind].smallest.distance);
      ASSERT_NEAR(keeper.report().kinds[kind].smallest.distance, least[kind], 1e-12) << "step " << i;
    }
    contacts_seen_afresh = std::max(contacts_seen_afresh, now.contacts);
    ASSERT_GE(keeper.report().contacts, contacts_seen_afresh);
  }
  EXPECT_GT(keeper.report().contacts, 5U);
}

// Two rows of arms pass each other at different times, so that blocks of pairs are skipped for long and return.
TEST(ContactMonitorBounds, ReportsTheSameAsWithoutBlocks) {
  constexpr int kArms = 8;
  const Cell pattern;
  std::vector<ArmBodies> arms;
  for (int i = 0; i < kArms; ++i) {
    arms.push_back(pattern.arms[0]);
    arms.back().name = "arm" + std::to_string(i);
  }
  const auto at = [&](double time) {
    std::vector<std::vector<Pose>> poses;
    for (int i = 0; i < kArms; ++i) {
      poses.push_back(pattern.at(time + i)[0]);
      // Every other arm passes at 0.5 m/s.
      const Vector3d offset(i % 2 == 0 ? 0.5 * time - 3.0 : 0.0, 1.03 * (i / 2), 0.0);
      for (Pose& X : poses.back()) X.pretranslate(offset);
    }
    return poses;
  };
  const auto update = [&](ContactMonitor& monitor, double time) {
    const auto poses = at(time);
    std::vector<MeasuredArm> measured;
    for (const auto& links : poses) measured.push_back({true, links});
    monitor.update(measured, {}, time);
  };
  // The monitor of all arms must report the minimum distance and the sum of contacts of monitors of two arms each,
  // which lose their bounds in every step.
  ContactMonitor all(arms);
  std::vector<ContactMonitor> of_two;
  std::vector<std::pair<int, int>> arms_of;
  for (int a = 0; a < kArms; ++a) {
    for (int b = a + 1; b < kArms; ++b) {
      of_two.emplace_back(std::vector<ArmBodies>{arms[a], arms[b]});
      arms_of.emplace_back(a, b);
    }
  }
  for (int i = 0; i < 300; ++i) {
    const double time = 0.04 * i;
    update(all, time);
    const auto poses = at(time);
    double least = 1e9;
    std::uint64_t contacts = 0;
    for (std::size_t k = 0; k < of_two.size(); ++k) {
      const MeasuredArm measured[] = {{true, poses[arms_of[k].first]}, {true, poses[arms_of[k].second]}};
      of_two[k].set_obstacles({});  // an edit keeps the totals and drops all bounds
      of_two[k].update(measured, {}, time);
      const KindReport report = of_two[k].report().kinds[kArmArm];
      least = std::min(least, report.smallest.distance);
      contacts += report.contacts;
    }
    const KindReport report = all.report().kinds[kArmArm];
    ASSERT_EQ(report.contacts, contacts) << "step " << i;
    ASSERT_NEAR(report.smallest.distance, least, 1e-12) << "step " << i;
  }
  EXPECT_GT(all.report().kinds[kArmArm].contacts, 5U);
}

}  // namespace
}  // namespace hecaton::world
