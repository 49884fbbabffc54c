// Old news never lead to a contact: docs/design/0006-old-news.md against adversaries.
#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/local/old_news.hpp"
#include "planner/simulation/arm_model.hpp"
#include "planner/simulation/network_model.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kPeriod = 0.01;  // [s]
constexpr double kRadius = 0.05;  // of a planar point's ball [m]

// A pair on a line. The own body keeps a constant speed; the other accelerates as it likes between its limits, but no
// faster towards the own than its damper allows. What is really left is never less than least_distance says.
TEST(OldNewsProperty, NoOtherWithinItsLimitsComesNearerThanTheLeastDistance) {
  Random random(11);
  double smallest_slack = 1.0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const double security = random.uniform(0.01, 0.05);
    const double slope = random.uniform(0.5, 5.0);
    const double acceleration = random.uniform(1.0, 30.0);
    const double own_speed = random.uniform(-1.0, 1.0);
    const double age = random.uniform(0.0, 0.25);
    double distance = security + random.uniform(0.001, 0.5);
    const double other_speed = random.uniform(-1.5, slope * (distance - security));
    const double expected = distance - (own_speed + other_speed) * age;
    const double lazy = random.uniform(-0.2, 1.0);  // some do less than they may

    constexpr int kSteps = 2000;
    const double dt = age / kSteps;
    double speed = other_speed;
    for (int k = 0; k < kSteps; ++k) {
      const double faster = speed + lazy * acceleration * dt;
      speed = std::min(faster, slope * (distance - security));
      distance -= (own_speed + speed) * dt;
    }
    const double least = least_distance({expected, age, own_speed, other_speed, acceleration}, security, slope);
    ASSERT_LE(least, expected);
    ASSERT_GE(distance, least - 2e-4) << "trial " << trial;
    smallest_slack = std::min(smallest_slack, distance - least);
  }
  EXPECT_LT(smallest_slack, 1e-3);  // and somebody came as near as it says
}

struct Limits {
  double speed;         ///< [m/s]
  double acceleration;  ///< [m/s²]
};

/// Balls on a line under their real controllers, that hear of each other over a bad network and get new goals all the
/// time, most of them beyond the other.
class Duel {
 public:
  Duel(Limits limits, const NetworkParameters& network, bool ages_known, std::uint64_t seed)
      : random_(seed), ages_known_(ages_known) {
    for (const char* name : {"a", "b"}) {
      Arm arm = test::planar_point(name, kRadius);
      arm.limits.velocity.setConstant(limits.speed);
      arm.limits.acceleration.setConstant(limits.acceleration);
      arms_.push_back(arm);
    }
    LocalParameters parameters;
    parameters.method = Method::kLocal;  // no way around
    parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
    parameters.state_age_limit = 1.0;
    for (int i = 0; i < 2; ++i) {
      controllers_.emplace_back(CellGeometry(arms_, i), parameters, kPeriod, random_.next());
      drives_.emplace_back(arms_[i].limits, joints({i == 0 ? -0.6 : 0.6, 0.0}), 0.05);
      channels_.emplace_back(network, random_.next());
    }
  }

  /// The smallest distance of the two balls in `seconds`.
  double run(double seconds) {
    double smallest = 10.0;
    for (double now = 0.0; now < seconds; now += kPeriod) {
      for (int i = 0; i < 2; ++i) {
        channels_[i].send(now, {drives_[1 - i].q(), drives_[1 - i].qd(), 0.0, true, true});
        channels_[i].receive(now);
        if (random_.uniform() < 0.02) set_goal(i);
      }
      for (int i = 0; i < 2; ++i) {
        std::array<ArmObservation, 2> seen;
        seen[1 - i] = channels_[i].newest();
        if (channels_[i].known() && ages_known_) seen[1 - i].age = channels_[i].age(now);
        const TickResult result = controllers_[i].step({drives_[i].q(), drives_[i].qd()}, seen, {}, false);
        drives_[i].command(result.q, result.qd, kPeriod);
      }
      for (ArmModel& drive : drives_) drive.step(kPeriod);
      smallest = std::min(smallest, (drives_[0].q() - drives_[1].q()).norm() - 2.0 * kRadius);
    }
    return smallest;
  }

 private:
  void set_goal(int i) {
    const JointVector beyond = drives_[1 - i].q() + 0.5 * (drives_[1 - i].q() - drives_[i].q());
    const JointVector away = joints({random_.uniform(0.0, i == 0 ? -1.0 : 1.0), 0.0});
    controllers_[i].set_goal(random_.uniform() < 0.7 ? beyond : away);
  }

  Random random_;
  bool ages_known_;
  std::vector<Arm> arms_;
  std::vector<ArmController> controllers_;
  std::vector<ArmModel> drives_;
  std::vector<StateChannel<ArmObservation>> channels_;  ///< [receiver]
};

double smallest_of_duels(bool ages_known) {
  Random random(5);
  double smallest = 10.0;
  for (int trial = 0; trial < 150; ++trial) {
    const double speed = random.uniform(0.3, 3.0);
    const double age = random.uniform(0.0, 0.1);
    const Limits limits{speed, speed / random.uniform(0.05, 0.3)};
    const NetworkParameters network{.age = age, .jitter = random.uniform(0.0, age), .loss = 0.2, .burst = 2.0};
    smallest = std::min(smallest, Duel(limits, network, ages_known, random.next()).run(6.0));
  }
  return smallest;
}

TEST(OldNewsProperty, TwoThatWantToBeWhereTheOtherIsNeverTouch) {
  EXPECT_GT(smallest_of_duels(true), 0.02);  // dₛ is 0.03
}

TEST(OldNewsProperty, TheSameWithAgesIgnoredComesNearer) {
  EXPECT_LT(smallest_of_duels(false), 0.02);
}

}  // namespace
}  // namespace hecaton::planner
