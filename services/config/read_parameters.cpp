#include "services/config/read_parameters.hpp"

#include <array>

#include "services/config/fields.hpp"

namespace hecaton::config {
namespace {

constexpr std::array<std::string_view, 8> kMethodNames = {"local",         "single_subspace", "boundary_following",
                                                          "sensed_cspace", "known_cspace",    "potential_field",
                                                          "strategy",      "strategy_step"};
constexpr std::array<planner::Method, 8> kMethods = {
    planner::Method::kLocal,        planner::Method::kSingleSubspace, planner::Method::kBoundaryFollowing,
    planner::Method::kSensedCspace, planner::Method::kKnownCspace,    planner::Method::kPotentialField,
    planner::Method::kStrategy,     planner::Method::kStrategyStep};

constexpr std::array<std::string_view, 2> kAttractionNames = {"control_points", "joints"};
constexpr std::array<planner::Attraction, 2> kAttractions = {planner::Attraction::kControlPoints,
                                                             planner::Attraction::kJoints};
constexpr std::array<std::string_view, 3> kRememberNames = {"never", "until_nearer", "always"};
constexpr std::array<planner::Remember, 3> kRemember = {planner::Remember::kNever, planner::Remember::kUntilNearer,
                                                        planner::Remember::kAlways};

constexpr Bounds kDistance{0.0, 10.0, "m", true};
constexpr Bounds kFraction{0.0, 1.0, "", true};

void read_damper(const MapView& map, planner::DamperParameters& damper) {
  read_number(map, "influence_distance", kDistance, damper.influence_distance);
  read_number(map, "security_distance", kDistance, damper.security_distance);
  read_number(map, "convergence_speed", {0.0, 100.0, "m/s", true}, damper.convergence_speed);
  read_number(map, "self_influence_distance", kDistance, damper.self_influence_distance);
  read_number(map, "self_security_distance", kDistance, damper.self_security_distance);
}

void read_follower(const MapView& map, planner::FollowerParameters& follower) {
  read_number(map, "deadlock_fraction", kFraction, follower.deadlock_fraction);
  read_number(map, "exit_fraction", kFraction, follower.exit_fraction);
  read_seconds(map, "redraw_after", {0.0, 3600.0, "s"}, follower.redraw_after);
  read_number(map, "redraw_growth", {1.0, 100.0, ""}, follower.redraw_growth);
  read_seconds(map, "redraw_longest", {0.0, 3600.0, "s"}, follower.redraw_longest);
}

void read_yielding(const MapView& map, planner::YieldingParameters& yielding) {
  read_seconds(map, "patience", {0.0, 3600.0, "s"}, yielding.patience);
  read_boolean(map, "at_rest", yielding.at_rest);
}

void read_rollout(const MapView& map, planner::RolloutParameters& rollout) {
  if (const auto count = map.find("candidates")) rollout.candidates = count->integer(0, 1000);
  read_seconds(map, "horizon", {0.0, 60.0, "s", true}, rollout.horizon);
  read_number(map, "horizon_growth", {1.0, 100.0, ""}, rollout.horizon_growth);
  read_seconds(map, "longest_horizon", {0.0, 60.0, "s", true}, rollout.longest_horizon);
  read_seconds(map, "interval", {0.0, 60.0, "s", true}, rollout.interval);
  if (const auto ticks = map.find("ticks_per_period")) rollout.ticks_per_period = ticks->integer(1, 1'000'000);
}

void read_route(const MapView& map, planner::RouteParameters& route) {
  read_seconds(map, "after", {0.0, 3600.0, "s"}, route.after);
  read_seconds(map, "together_after", {0.0, 3600.0, "s"}, route.together_after);
}

void read_sensed(const MapView& map, planner::SensedParameters& sensed) {
  if (const auto cells = map.find("cells")) sensed.cells = cells->integer(36, 1440);
  read_number(map, "margin", {0.0, 1.0, "m", true}, sensed.margin);
  if (const auto remember = map.find("remember")) sensed.remember = kRemember[remember->choice(kRememberNames)];
}

void read_potential(const MapView& map, planner::PotentialParameters& potential) {
  if (const auto attract = map.find("attraction")) {
    potential.attraction = kAttractions[attract->choice(kAttractionNames)];
  }
  read_number(map, "goal_distance", {0.0, 10.0, "m or rad", true}, potential.goal_distance);
  read_number(map, "repulsion", {0.0, 10.0, "m⁴", true}, potential.repulsion);
  read_number(map, "influence_distance", kDistance, potential.influence_distance);
  read_number(map, "spacing", {0.005, 10.0, "m"}, potential.spacing);
}

void read_strategy(const MapView& map, planner::StrategyParameters& parameters) {
  constexpr std::array<std::string_view, 2> kDirections = {"1", "-1"};
  if (const auto joints = map.find("joints")) parameters.joints = joints->integer(2, planner::kMaxJoints);
  if (const auto coefficients = map.find("coefficients")) {
    parameters.coefficients = 0;
    parameters.strategy.coefficients.fill(0.0);
    for (const YamlView& item : coefficients->items(0, planner::kMaxJoints - 2, "numbers")) {
      parameters.strategy.coefficients[parameters.coefficients++] = item.number(kCoefficient);
    }
  }
  if (const auto direction = map.find("direction")) {
    parameters.strategy.direction = direction->choice(kDirections) == 0 ? 1.0 : -1.0;
  }
  if (const auto file = map.find("file")) {
    for (const char* key : {"coefficients", "direction"}) {
      if (const auto given = map.find(key)) given->fail("left out, because strategy.file says it");
    }
  }
  read_number(map, "distance", {0.001, 1.0, "m"}, parameters.distance);
  read_number(map, "step", {1e-4, 1.0, "rad"}, parameters.step);
}

}  // namespace

void read_strategy_file(const YamlView& file, const std::string& arm, planner::StrategyParameters& parameters) {
  const std::string path = beside(file.file(), file.text());
  const YamlNode tree = read_yaml_file(path, file.sources());
  const YamlSource source{path, file.sources()};
  const YamlView root(tree, source, "");
  for (const auto& [name, view] : root.named_items(128)) {
    if (name != arm) continue;
    const MapView map = view.map(section::kStrategy);
    static_cast<void>(map.at("coefficients"));
    if (const auto other = map.find("file")) other->fail("left out: this is such a file itself");
    read_strategy(map, parameters);
    return;
  }
  root.fail_with("there is no strategy for arm " + arm);
}

void read_parameters(const MapView& map, planner::LocalParameters& parameters) {
  if (const auto method = map.find("method")) parameters.method = kMethods[method->choice(kMethodNames)];
  if (const auto damper = map.find("damper")) read_damper(damper->map(section::kDamper), parameters.damper);
  if (const auto follower = map.find("follower")) read_follower(follower->map(section::kFollower), parameters.follower);
  if (const auto yielding = map.find("yielding")) read_yielding(yielding->map(section::kYielding), parameters.yielding);
  if (const auto rollout = map.find("rollout")) read_rollout(rollout->map(section::kRollout), parameters.rollout);
  if (const auto route = map.find("route")) read_route(route->map(section::kRoute), parameters.route);
  if (const auto sensed = map.find("sensed")) read_sensed(sensed->map(section::kSensed), parameters.sensed);
  if (const auto field = map.find("potential")) read_potential(field->map(section::kPotential), parameters.potential);
  if (const auto strategy = map.find("strategy")) read_strategy(strategy->map(section::kStrategy), parameters.strategy);
  read_number(map, "goal_tolerance", {0.0, 0.1, "rad (m for a prismatic joint)", true}, parameters.goal_tolerance);
  read_number(map, "acceleration_of_obstacles", {0.0, 100.0, "m/s²", true}, parameters.acceleration_of_obstacles);
  read_seconds(map, "state_age_limit", {0.001, 10.0, "s"}, parameters.state_age_limit);
}

}  // namespace hecaton::config
