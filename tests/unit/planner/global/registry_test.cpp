#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "planner/global/global_planner.hpp"
#include "planner/global/plan.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

/// A planner that always gives a reason instead of a path.
class Hesitant final : public GlobalPlanner {
 public:
  explicit Hesitant(std::string_view name) : GlobalPlanner({.name = name, .summary = "stays where it is"}) {}
  [[nodiscard]] SearchResult search(const SearchProblem& /*problem*/) const override {
    return {.status = PlanStatus::kStuck, .reason = "the arm stays where it is"};
  }
};

TEST(PlannerRegistry, ListsEachBuiltInPlannerOnce) {
  std::set<std::string_view> names;
  for (const auto& planner : built_in_planners().planners()) {
    const PlannerTraits& traits = planner->traits();
    EXPECT_TRUE(names.insert(traits.name).second) << traits.name;
    EXPECT_FALSE(traits.summary.empty()) << traits.name;
    EXPECT_EQ(built_in_planners().at(traits.name), planner);
  }
  EXPECT_TRUE(names.contains(default_planner()->traits().name));
}

TEST(PlannerRegistry, AddingToACopyLeavesTheBuiltInListUnchanged) {
  PlannerRegistry planners = built_in_planners();
  planners.add(std::make_shared<const Hesitant>("hesitant"));
  EXPECT_EQ(planners.at("hesitant")->traits().name, "hesitant");
  EXPECT_THROW((void)built_in_planners().at("hesitant"), std::invalid_argument);
}

TEST(PlannerRegistry, RejectsDuplicateName) {
  PlannerRegistry planners = built_in_planners();
  EXPECT_THROW(planners.add(std::make_shared<const Hesitant>("prm")), std::invalid_argument);
}

TEST(PlannerRegistry, UnknownNameGivesAllowedNames) {
  try {
    (void)built_in_planners().at("magic");
    FAIL() << "must throw";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "global planner = magic must be one of rrt_connect, rrt, est, prm");
  }
}

TEST(Plan, ReportsThePlannersReasonWhenItIsStuck) {
  const Validity validity({CellGeometry({test::puma()}, 0)}, {});
  const std::vector<double> start{0.0, 0.0, 1.5, 0.0, 0.0, 0.0};
  const std::vector<double> goal{0.5, 0.0, 1.5, 0.0, 0.0, 0.0};
  ASSERT_TRUE(plan(validity, start, goal).solved());
  PlanOptions options;
  options.planner = std::make_shared<const Hesitant>("hesitant");
  const Plan found = plan(validity, start, goal, options);
  EXPECT_EQ(found.status, PlanStatus::kStuck);
  EXPECT_EQ(found.reason, "the arm stays where it is");
  EXPECT_TRUE(found.path.empty());
}

}  // namespace
}  // namespace hecaton::planner::global
