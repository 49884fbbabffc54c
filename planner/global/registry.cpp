#include <algorithm>
#include <stdexcept>

#include "planner/global/est/est.hpp"
#include "planner/global/global_planner.hpp"
#include "planner/global/prm/prm.hpp"
#include "planner/global/rrt/rrt.hpp"
#include "planner/global/rrt_connect/rrt_connect.hpp"

namespace hecaton::planner::global {
namespace {

auto named(const std::vector<PlannerRegistry::Shared>& planners, std::string_view name) {
  return std::find_if(planners.begin(), planners.end(),
                      [&](const auto& planner) { return planner->traits().name == name; });
}

}  // namespace

const PlannerRegistry& built_in_planners() {
  static const PlannerRegistry registry = [] {
    PlannerRegistry planners;
    planners.add<RrtConnect>();
    planners.add<Rrt>();
    planners.add<Est>();
    planners.add<Prm>();
    return planners;
  }();
  return registry;
}

std::shared_ptr<const GlobalPlanner> default_planner() {
  static const auto planner = std::make_shared<const RrtConnect>();
  return planner;
}

void PlannerRegistry::add(Shared planner) {
  const std::string_view name = planner->traits().name;
  if (named(planners_, name) != planners_.end()) {
    throw std::invalid_argument("there are two global planners named " + std::string(name));
  }
  planners_.push_back(std::move(planner));
}

const PlannerRegistry::Shared& PlannerRegistry::at(std::string_view name) const {
  if (const auto found = named(planners_, name); found != planners_.end()) return *found;
  std::string allowed;
  for (const Shared& planner : planners_) {
    allowed += (allowed.empty() ? "" : ", ") + std::string(planner->traits().name);
  }
  throw std::invalid_argument("global planner = " + std::string(name) + " must be one of " + allowed);
}

}  // namespace hecaton::planner::global
