// The right of way on delayed states: docs/explanation/0007-right-of-way.md.
#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "planner/local/right_of_way.hpp"
#include "planner/simulation/network_model.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

constexpr double kPeriod = 0.01;  // [s]
constexpr int kArms = 5;

/// Arms that are near each other and blocked at random times, with delayed and lost priorities of each other.
class Crowd {
 public:
  Crowd(const NetworkParameters& network, std::uint64_t seed) : random_(seed), rights_(kArms) {
    parameters_.yielding.yield_request_delay = random_.uniform(0.2, 2.0);
    for (RightOfWay& right : rights_) right.under_way = true;
    for (int to = 0; to < kArms; ++to) {
      auto& row = channels_.emplace_back();
      for (int from = 0; from < kArms; ++from) row.emplace_back(network, random_.next());
    }
    for (int i = 0; i < kArms; ++i) {
      Row row;
      row.g = test::joints({1.0, 0.0});
      row.arm = i;
      row.influences = true;
      rows_.push_back(row);
    }
  }

  void step() {
    for (int to = 0; to < kArms; ++to) {
      for (int from = 0; from < kArms; ++from) {
        ArmObservation state;
        state.known = state.plans = true;
        state.has_goal = rights_[from].under_way;
        state.priority = rights_[from].priority;
        if (from != to) channels_[to][from].send(now_, state);
      }
    }
    for (int i = 0; i < kArms; ++i) {
      std::array<ArmObservation, kArms> seen;
      for (int from = 0; from < kArms; ++from) {
        if (from == i) continue;
        channels_[i][from].receive(now_);
        seen[from] = channels_[i][from].newest();
      }
      const bool blocked = random_.uniform() < 0.5;
      update({parameters_, seen, i, rows_, kPeriod, blocked, random_.uniform()}, random_, rights_[i]);
    }
    now_ += kPeriod;
  }

  /// True if some arm waits for itself, directly or through other arms.
  [[nodiscard]] bool somebody_waits_for_itself() const {
    for (int first = 0; first < kArms; ++first) {
      int i = rights_[first].yields_to;
      for (int k = 0; k < kArms && i >= 0; ++k) {
        if (i == first) return true;
        i = rights_[i].yields_to;
      }
    }
    return false;
  }
  [[nodiscard]] int waiting() const {
    return static_cast<int>(
        std::count_if(rights_.begin(), rights_.end(), [](const RightOfWay& right) { return right.yields_to >= 0; }));
  }
  [[nodiscard]] std::uint32_t most() const {
    std::uint32_t most = 0;
    for (const RightOfWay& right : rights_) most = std::max(most, right.priority);
    return most;
  }

 private:
  Random random_;
  LocalParameters parameters_;
  std::vector<RightOfWay> rights_;
  std::vector<std::vector<StateChannel<ArmObservation>>> channels_;  ///< [receiver][sender]
  std::vector<Row> rows_;
  double now_ = 0.0;
};

// Every arm knows every other arm with a different delay. Priorities never fall, so that no arm overestimates
// another's: this is sufficient.
TEST(RightOfWayProperty, ArmsNeverYieldInACircleForAnyDelay) {
  int waits = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Crowd crowd({.age = 0.3, .jitter = 0.3, .loss = 0.5}, seed);
    for (int k = 0; k < 2000; ++k) {
      crowd.step();
      ASSERT_FALSE(crowd.somebody_waits_for_itself()) << "seed " << seed << ", period " << k;
      waits += crowd.waiting();
    }
    EXPECT_GT(crowd.most(), 5U);
  }
  EXPECT_GT(waits, 100'000);
}

// Once all arms know all priorities, exactly one arm does not yield: the one that requested last.
TEST(RightOfWayProperty, ExactlyOneArmHasRightOfWayOnceAllPrioritiesHaveArrived) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Crowd crowd({.age = 0.05}, seed);
    std::uint32_t most = 0;
    int settled = 0;  // periods since the last asking
    int checked = 0;
    for (int k = 0; k < 2000; ++k) {
      crowd.step();
      settled = crowd.most() == most ? settled + 1 : 0;
      most = crowd.most();
      if (most == 0 || settled < 13) continue;
      ASSERT_EQ(crowd.waiting(), kArms - 1) << "seed " << seed << ", period " << k;
      ++checked;
    }
    EXPECT_GT(checked, 100);
  }
}

}  // namespace
}  // namespace hecaton::planner
