#include "planner/global/plan.hpp"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/fcl_collision_checker.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

using Configuration = std::vector<double>;

/// A scene with a free start and a free goal.
struct Query {
  std::vector<WorldBody> world;
  Validity validity;
  Configuration start;
  Configuration goal;

  explicit Query(std::uint64_t seed, int boxes = 12) : Query(Random(seed), boxes) {}

 private:
  Query(Random random, int boxes)
      : world(test::random_boxes(boxes, random)), validity({CellGeometry({test::puma()}, 0)}, world) {
    start = draw(random);
    goal = draw(random);
  }
  [[nodiscard]] Configuration draw(Random& random) const {
    const Space space = space_of(validity);
    std::vector<float> q(space.stride);
    do {
      space.sample(random, q.data());
    } while (!validity.state_free(q.data()));
    return {q.begin(), q.begin() + 6};
  }
};

/// Colliding configurations of the path by FCL, at steps `finer` times as fine as the planner's.
int contacts(const Query& query, const Plan& plan, int finer) {
  test::FclCollisionChecker checker(query.validity, query.world);
  return checker.collisions_on(plan.path, query.validity.options().step / finer);
}

class EveryPlanner : public testing::TestWithParam<std::shared_ptr<const GlobalPlanner>> {};

TEST_P(EveryPlanner, FindsPathsThatFclConfirms) {
  PlanOptions options;
  options.planner = GetParam();
  options.budget.iterations = 50'000;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Query query(seed);
    const Plan found = plan(query.validity, query.start, query.goal, options);
    ASSERT_TRUE(found.solved()) << "seed " << seed << ": " << found.reason;
    EXPECT_EQ(found.path.front(), query.start);
    EXPECT_EQ(found.path.back(), query.goal);
    EXPECT_EQ(contacts(query, found, 1), 0) << "seed " << seed;
  }
}

TEST_P(EveryPlanner, GivesTheSamePathForTheSameSeed) {
  PlanOptions options;
  options.planner = GetParam();
  const Query query(3);
  const Plan first = plan(query.validity, query.start, query.goal, options);
  const Plan again = plan(query.validity, query.start, query.goal, options);
  EXPECT_EQ(first.path, again.path);
  EXPECT_EQ(first.checks, again.checks);
}

TEST_P(EveryPlanner, ReportsThatTheBudgetEnded) {
  PlanOptions options;
  options.planner = GetParam();
  options.simplify = false;
  int blocked = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Query query(seed, 15);
    options.budget.iterations = 50'000;
    if (plan(query.validity, query.start, query.goal, options).path.size() == 2) continue;  // the direct edge is free
    ++blocked;
    options.budget.iterations = 0;
    const Plan found = plan(query.validity, query.start, query.goal, options);
    EXPECT_EQ(found.status, PlanStatus::kBudgetEnded);
    EXPECT_NE(found.reason.find("the budget ended after"), std::string::npos) << found.reason;
    EXPECT_TRUE(found.path.empty());
    options.budget.iterations = 1'000'000;
    options.budget.ended = [] { return true; };
    const Plan stopped = plan(query.validity, query.start, query.goal, options);
    EXPECT_TRUE(stopped.solved() || stopped.iterations <= 64);
    options.budget.ended = {};
  }
  EXPECT_GT(blocked, 5);
}

/// The number of checks serves as the clock: a sample may take long, with a fine step or with many arms.
TEST_P(EveryPlanner, KeepsItsBudgetWithFineSteps) {
  constexpr std::uint64_t kCheckBudget = 200'000;
  PlanOptions options;
  options.planner = GetParam();
  int ended = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Query query(seed, 15);
    ValidityOptions fine;
    fine.step = 1e-4;
    const Validity validity({CellGeometry({test::puma()}, 0)}, query.world, fine);
    // The search ends, and so does the shortening.
    options.budget.ended = [&] { return validity.checks() > kCheckBudget; };
    const Plan found = plan(validity, query.start, query.goal, options);
    // One edge across the space, checked and proven, is the smallest unit of work.
    EXPECT_LT(validity.checks(), 5 * kCheckBudget) << "seed " << seed;
    ended += found.checks > kCheckBudget ? 1 : 0;
  }
  EXPECT_GT(ended, 0);
}

INSTANTIATE_TEST_SUITE_P(Global, EveryPlanner, testing::ValuesIn(built_in_planners().planners()),
                         [](const auto& tried) { return std::string(tried.param->traits().name); });

TEST(Plan, NamesThePairThatMakesTheStartInvalid) {
  Query query(1, 0);
  const WorldBody block{world::Box{{0.2, 0.2, 0.2}}, Pose(Eigen::Translation3d(0.4, 0.15, 0.67)), "block"};
  query.validity.set_world(std::vector{block});
  const Configuration level(6, 0.0);  // the upper arm lies level along +x, at a height of 0.672 m
  const Plan blocked = plan(query.validity, level, query.goal);
  EXPECT_EQ(blocked.status, PlanStatus::kStartInvalid);
  EXPECT_NE(blocked.reason.find("start is in collision: puma/"), std::string::npos) << blocked.reason;
  EXPECT_NE(blocked.reason.find("and block overlap"), std::string::npos) << blocked.reason;
  EXPECT_NE(blocked.reason.find(" mm (minimum distance "), std::string::npos) << blocked.reason;
  EXPECT_TRUE(blocked.reason.ends_with("; choose another start, or move what is in the way")) << blocked.reason;
}

TEST(Plan, RejectsStartOutsideTheLimits) {
  const Query query(1, 0);
  Configuration far = query.goal;
  far[2] = 100.0;
  const Plan refused = plan(query.validity, query.start, far);
  EXPECT_EQ(refused.status, PlanStatus::kGoalInvalid);
  EXPECT_NE(refused.reason.find("joint3 = 100 must be within"), std::string::npos) << refused.reason;
  EXPECT_EQ(plan(query.validity, Configuration{1.0}, far).status, PlanStatus::kStartInvalid);
}

TEST(Plan, SimplifyingShortensAndStaysFree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Query query(seed, 15);
    PlanOptions options;
    options.simplify = false;
    Plan found = plan(query.validity, query.start, query.goal, options);
    ASSERT_TRUE(found.solved());
    const double before = found.length;
    simplify(query.validity, options, found);
    EXPECT_LE(found.length, before + 1e-6);
    EXPECT_EQ(found.path.front(), query.start);
    EXPECT_EQ(found.path.back(), query.goal);
    EXPECT_EQ(contacts(query, found, 1), 0) << "seed " << seed;
  }
}

/// A PUMA whose first joint is continuous, and an obstacle.
struct Turning {
  std::vector<WorldBody> world;
  Validity validity;

  explicit Turning(std::vector<WorldBody> bodies) : world(std::move(bodies)), validity({geometry()}, world) {}

  static CellGeometry geometry() {
    Arm arm = test::puma();
    arm.limits.lower[0] = -std::numeric_limits<double>::infinity();
    arm.limits.upper[0] = std::numeric_limits<double>::infinity();
    return CellGeometry({arm}, 0);
  }
};

/// Stretched towards azimuth q0.
Configuration stretched(double q0) {
  return {q0, 0.0, 1.5, 0.0, 0.0, 0.0};
}

constexpr double kWhole = 2.0 * std::numbers::pi;

TEST_P(EveryPlanner, TurnsTheShortWay) {
  const Turning free({});
  PlanOptions options;
  options.planner = GetParam();
  for (const double turns : {0.0, kWhole, -2.0 * kWhole}) {
    const Plan found = plan(free.validity, stretched(3.0 + kWhole), stretched(-3.0 + turns), options);
    ASSERT_TRUE(found.solved()) << found.reason;
    EXPECT_EQ(found.path.front(), stretched(3.0 + kWhole));
    EXPECT_NEAR(found.path.back()[0], -3.0 + 2.0 * kWhole, 1e-9);
    EXPECT_NEAR(found.length, kWhole - 6.0, 1e-6);
  }
}

TEST_P(EveryPlanner, TurnsTheLongWayIfTheShortWayIsBlocked) {
  // A radial wall at azimuth π, on the short way.
  WorldBody wall{world::Box{{1.0, 0.02, 3.0}}, Pose::Identity(), "wall"};
  wall.X_WS.translation() = Eigen::Vector3d(-1.4, 0.0, 0.0);
  const Turning walled({wall});
  PlanOptions options;
  options.planner = GetParam();
  options.budget.iterations = 50'000;
  const Configuration start = stretched(1.65);
  for (const double turns : {0.0, kWhole, 3.0 * kWhole}) {
    const Configuration goal = stretched(-1.65 + turns);
    const Plan found = plan(walled.validity, start, goal, options);
    ASSERT_TRUE(found.solved()) << found.reason;
    EXPECT_GT(found.path.size(), 1U);
    EXPECT_EQ(found.path.front(), start);
    EXPECT_NEAR(std::remainder(found.path.back()[0] - goal[0], kWhole), 0.0, 1e-9);
    test::FclCollisionChecker checker(walled.validity, walled.world);
    EXPECT_EQ(checker.collisions_on(found.path, walled.validity.options().step / 10.0), 0);
  }
}

}  // namespace
}  // namespace hecaton::planner::global
