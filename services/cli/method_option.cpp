#include "services/cli/method_option.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "services/command_line/choice_option.hpp"

namespace hecaton::services::cli {
namespace {

using Entry = std::pair<const char*, planner::Method>;
constexpr std::array<Entry, 8> kMethods{{{"local", planner::Method::kLocal},
                                         {"single_subspace", planner::Method::kSingleSubspace},
                                         {"boundary_following", planner::Method::kBoundaryFollowing},
                                         {"sensed_cspace", planner::Method::kSensedCspace},
                                         {"known_cspace", planner::Method::kKnownCspace},
                                         {"potential_field", planner::Method::kPotentialField},
                                         {"strategy", planner::Method::kStrategy},
                                         {"strategy_step", planner::Method::kStrategyStep}}};

}  // namespace

void add_method(CLI::App& app, std::string& name) {
  std::vector<std::string> names;
  names.reserve(kMethods.size());
  for (const auto& [text, method] : kMethods) names.emplace_back(text);
  add_choice(app, "--method", name, names, "what decides each tick, for all arms, instead of the cell file's");
}

planner::Method method_of(const std::string& name) {
  const auto* found = std::find_if(kMethods.begin(), kMethods.end(), [&](const Entry& e) { return name == e.first; });
  return found == kMethods.end() ? planner::Method::kBoundaryFollowing : found->second;
}

std::string method_name(planner::Method method) {
  const auto* found =
      std::find_if(kMethods.begin(), kMethods.end(), [&](const Entry& e) { return method == e.second; });
  return found == kMethods.end() ? "" : found->first;
}

}  // namespace hecaton::services::cli
