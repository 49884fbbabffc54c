#include "tests/bench/ompl_peer.hpp"

#include <algorithm>
#include <chrono>

#include <ompl/base/ScopedState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include "planner/global/plan.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

std::shared_ptr<ob::RealVectorStateSpace> make_space(const planner::global::Validity& validity,
                                                     const std::vector<double>& start,
                                                     const std::vector<double>& goal) {
  const planner::global::Space box = space_of(validity, start, goal);
  const auto space = std::make_shared<ob::RealVectorStateSpace>(box.dimensions);
  ob::RealVectorBounds bounds(box.dimensions);
  for (int j = 0; j < box.dimensions; ++j) {
    // The box is rounded to floats; an end at a limit must not be outside.
    bounds.setLow(j, std::min({static_cast<double>(box.lower[j]), start[j], goal[j]}));
    bounds.setHigh(j, std::max({static_cast<double>(box.upper[j]), start[j], goal[j]}));
  }
  space->setBounds(bounds);
  space->setLongestValidSegmentFraction(validity.options().step / space->getMaximumExtent());
  return space;
}

ob::PlannerTerminationCondition ended_after(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  return ob::PlannerTerminationCondition([end] { return std::chrono::steady_clock::now() > end; });
}

}  // namespace

OmplPlan plan_with_ompl(const planner::global::Validity& validity, test::FclCollisionChecker& checker,
                        const std::vector<double>& start, const std::vector<double>& goal, double seconds,
                        OmplShortening shortening) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  const auto space = make_space(validity, start, goal);
  og::SimpleSetup setup(space);
  setup.setStateValidityChecker([&](const ob::State* state) {
    return !checker.collides(state->as<ob::RealVectorStateSpace::StateType>()->values);
  });
  ob::ScopedState<> from(space);
  ob::ScopedState<> to(space);
  for (unsigned j = 0; j < start.size(); ++j) {
    from[j] = start[j];
    to[j] = goal[j];
  }
  setup.setStartAndGoalStates(from, to);
  const auto planner = std::make_shared<og::RRTConnect>(setup.getSpaceInformation());
  setup.setPlanner(planner);
  OmplPlan plan;
  plan.plan_us = processor_time_once(
      [&] { plan.solved = setup.solve(ended_after(seconds)) == ob::PlannerStatus::EXACT_SOLUTION; });
  if (!plan.solved) return plan;
  if (shortening == OmplShortening::kSimplify) {
    plan.simplify_us = processor_time_once([&] { setup.simplifySolution(ended_after(seconds)); });
  }
  for (const ob::State* state : setup.getSolutionPath().getStates()) {
    const double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
    plan.path.emplace_back(values, values + start.size());
  }
  return plan;
}

}  // namespace hecaton::bench
