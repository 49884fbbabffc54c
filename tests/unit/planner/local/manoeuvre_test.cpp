// Effects of manoeuvres on the following ticks.
#include <gtest/gtest.h>

#include "tests/unit/planner/local/journey.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;

TEST(Manoeuvre, DetourVisitsItsWayPointFirst) {
  Journey journey({}, built_in_method("boundary_following"));
  Manoeuvre detour;
  detour.kind = ManoeuvreKind::kDetour;
  detour.q = joints({0, 1});
  detour.time_limit = 10.0;
  journey.input.q = joints({0, 0});
  journey.input.q_goal = joints({1, 0});
  (void)journey.step();  // a goal that was not seen before would end the detour
  begin(detour, journey.memory.local);
  double nearest = 10.0;
  TickResult result;
  for (int k = 0; k < 2000 && result.status != TickStatus::kReached; ++k) {
    result = journey.step();
    if (nearest > 0.15) {
      EXPECT_EQ(result.status, TickStatus::kDetouring) << k;
    }
    nearest = std::min(nearest, (result.q - detour.q).norm());
  }
  EXPECT_LT(nearest, 0.15);
  EXPECT_EQ(result.status, TickStatus::kReached);
}

TEST(Manoeuvre, DetourEndsAtItsTimeLimit) {
  Journey journey({}, built_in_method("boundary_following"));
  Manoeuvre detour;
  detour.kind = ManoeuvreKind::kDetour;
  detour.q = joints({0, 2});  // 4 s away
  detour.time_limit = 0.1;
  journey.input.q = joints({0, 0});
  journey.input.q_goal = joints({1, 0});
  (void)journey.step();
  begin(detour, journey.memory.local);
  for (int k = 0; k < 12; ++k) (void)journey.step();
  EXPECT_EQ(journey.step().status, TickStatus::kMoving);
}

TEST(Manoeuvre, DetourEndsWhenAWallBlocksIt) {
  Journey journey({box_obstacle("wall", {0, 0.5, 0}, {3, 0.1, 0.1})}, built_in_method("boundary_following"));
  Manoeuvre detour;
  detour.kind = ManoeuvreKind::kDetour;
  detour.q = joints({0, 1});
  detour.time_limit = 100.0;
  journey.input.q = joints({0, 0});
  journey.input.q_goal = joints({1, 0});
  (void)journey.step();
  begin(detour, journey.memory.local);
  TickResult result;
  for (int k = 0; k < 3000 && result.status != TickStatus::kReached; ++k) result = journey.step();
  EXPECT_EQ(result.status, TickStatus::kReached);
  EXPECT_GT(journey.nearest, 0.0);
}

TEST(Manoeuvre, NewGoalEndsDetour) {
  Journey journey({}, built_in_method("boundary_following"));
  Manoeuvre detour;
  detour.kind = ManoeuvreKind::kDetour;
  detour.q = joints({0, 2});
  detour.time_limit = 100.0;
  journey.input.q = joints({0, 0});
  journey.input.q_goal = joints({1, 0});
  (void)journey.step();
  begin(detour, journey.memory.local);
  EXPECT_EQ(journey.step().status, TickStatus::kDetouring);
  journey.input.q_goal = joints({-1, 0});
  EXPECT_EQ(journey.step().status, TickStatus::kMoving);
}

TEST(Manoeuvre, EvasionStaysAsideUntilItsTimeLimit) {
  Journey journey({}, built_in_method("boundary_following"));
  Manoeuvre evasion;
  evasion.kind = ManoeuvreKind::kEvade;
  evasion.q = joints({0, 0.2});
  evasion.time_limit = 3.0;
  journey.input.q = joints({0, 0});
  journey.input.q_goal = joints({1, 0});
  (void)journey.step();
  begin(evasion, journey.memory.local);
  for (int k = 0; k < 295; ++k) ASSERT_EQ(journey.step().status, TickStatus::kDetouring) << k;
  EXPECT_LT((journey.input.q - evasion.q).norm(), 0.01);
  for (int k = 0; k < 10; ++k) (void)journey.step();
  EXPECT_EQ(journey.step().status, TickStatus::kMoving);
}

TEST(Manoeuvre, ArmWithoutGoalEvadesAndStaysThere) {
  Journey journey({}, built_in_method("boundary_following"));
  Manoeuvre evasion;
  evasion.kind = ManoeuvreKind::kEvade;
  evasion.q = joints({0, 0.2});
  evasion.time_limit = 2.0;
  journey.input.q = joints({0, 0});
  journey.input.has_goal = false;
  (void)journey.step();
  begin(evasion, journey.memory.local);
  for (int k = 0; k < 400; ++k) ASSERT_EQ(journey.step().status, TickStatus::kIdle) << k;
  EXPECT_LT((journey.input.q - evasion.q).norm(), 0.01);
}

}  // namespace
}  // namespace hecaton::planner
