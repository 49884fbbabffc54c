#include "planner/methods/registry.hpp"

#include <algorithm>
#include <stdexcept>

#include "planner/local/parameters.hpp"
#include "planner/methods/boundary_following/boundary_following.hpp"
#include "planner/methods/potential_field/field_method.hpp"
#include "planner/methods/sensed_cspace/cspace_method.hpp"
#include "planner/methods/strategy/strategy_method.hpp"

namespace hecaton::planner {

const MethodRegistry& built_in_methods() {
  static const MethodRegistry registry = [] {
    MethodRegistry methods;
    methods.add<ConstraintsAlone>();
    methods.add<SingleSubspace>();
    methods.add<BoundaryFollowing>();
    methods.add<cspace::SensedCspace>();
    methods.add<cspace::KnownCspace>();
    methods.add<potential::FieldMethod>();
    methods.add<StrategyFollowing>();
    methods.add<StrategyStep>();
    return methods;
  }();
  return registry;
}

std::shared_ptr<const MotionMethod> default_method() {
  static const auto method = std::make_shared<const BoundaryFollowing>();
  return method;
}

std::shared_ptr<const MotionMethod> built_in_method(std::string_view name) {
  const auto all = built_in_methods().make_all();
  if (auto found = find_method({all.begin(), all.end()}, name)) return found;
  std::string allowed;
  for (const std::string_view known : built_in_methods().names()) {
    allowed += (allowed.empty() ? "" : ", ") + std::string(known);
  }
  throw std::invalid_argument("method = " + std::string(name) + " must be one of " + allowed);
}

void MethodRegistry::add(const Make& make) {
  const MethodTraits traits = make()->traits();
  if (std::any_of(traits_.begin(), traits_.end(),
                  [&](const MethodTraits& known) { return known.name == traits.name; })) {
    throw std::invalid_argument("there are two motion methods named " + std::string(traits.name));
  }
  makers_.push_back(make);
  traits_.push_back(traits);
}

std::vector<std::string_view> MethodRegistry::names() const {
  std::vector<std::string_view> names;
  for (const MethodTraits& traits : traits_) names.push_back(traits.name);
  return names;
}

std::vector<std::shared_ptr<MotionMethod>> MethodRegistry::make_all() const {
  std::vector<std::shared_ptr<MotionMethod>> methods;
  for (const Make& make : makers_) methods.push_back(make());
  return methods;
}

}  // namespace hecaton::planner
