#include "planner/local/right_of_way.hpp"

#include <algorithm>
#include <limits>

namespace hecaton::planner {
namespace {

/// After moving freely for this long, nearer to its goal, the arm is not blocked any more [s].
constexpr double kFree = 0.5;
/// A yielding arm continues when the other arm has been away for this long [s].
constexpr double kApart = 0.3;
/// Random variation of the request delay, so that two arms do not request in turns forever.
constexpr double kSpread = 0.25;
/// Growth of the request delay with each own request on the way to a goal. Making room takes time; a request in between
/// would only reverse the motion.
constexpr double kGrowth = 1.25;
/// Limit of that growth.
constexpr double kMostGrowth = 16.0;

void begin_to_wait(const RightOfWayInput& input, Random& random, RightOfWay& right) {
  right.waited = 0.0;
  right.request_delay =
      right.growth * input.parameters.yielding.yield_request_delay * random.uniform(1.0 - kSpread, 1.0 + kSpread);
}

Priority priority_of(const RightOfWayInput& input, int i) {
  return {input.arms[i].priority, i};
}

/// The first near arm in the order that precedes the own arm; −1: none.
int first_near(const RightOfWayInput& input, const RightOfWay& right) {
  int first = -1;
  for (const Row& row : input.rows) {
    if (!row.influences || !goes_before(input, right, row.arm)) continue;
    if (first < 0 || priority_of(input, row.arm).precedes(priority_of(input, first))) first = row.arm;
  }
  return first;
}

void choose(const RightOfWayInput& input, Random& random, RightOfWay& right) {
  const int first = first_near(input, right);
  if (first >= 0) {
    // The other arm gets the full delay for each new request.
    if (right.answers != input.arms[first].priority) begin_to_wait(input, random, right);
    right.answers = input.arms[first].priority;
    right.yields_to = first;
    right.apart = 0.0;
  } else if (right.yields_to >= 0) {
    right.apart += input.dt;
    if (!goes_before(input, right, right.yields_to) || right.apart > kApart) right.yields_to = -1;
  }
}

void ask(const RightOfWayInput& input, RightOfWay& right) {
  std::uint32_t most = 0;
  for (int i = 0; i < static_cast<int>(input.arms.size()); ++i) {
    if (i != input.self && input.arms[i].known) most = std::max(most, input.arms[i].priority);
  }
  if (right.priority <= most) right.priority = most + 1;
  right.growth = std::min(kMostGrowth, kGrowth * right.growth);
  right.yields_to = -1;
}

/// Measures for how long the arm is blocked, and requests after the delay. Free motion alone does not end that time: an
/// arm that circles another one at rest is free on the far side of each turn.
void wait(const RightOfWayInput& input, Random& random, RightOfWay& right) {
  if (right.request_delay <= 0.0) begin_to_wait(input, random, right);
  if (input.blocked || right.yields_to >= 0) {
    right.waited += input.dt;
    right.free = 0.0;
    right.nearest = std::min(right.nearest, input.distance);
  } else if (input.distance < right.nearest && (right.free += input.dt) > kFree) {
    right.waited = 0.0;
    right.nearest = std::numeric_limits<double>::infinity();
  }
  if (right.waited < right.request_delay) return;
  ask(input, right);
  begin_to_wait(input, random, right);
}

bool leads(const RightOfWayInput& input, const RightOfWay& right) {
  if (!right.under_way || right.priority == 0) return false;
  for (int i = 0; i < static_cast<int>(input.arms.size()); ++i) {
    if (goes_before(input, right, i)) return false;
  }
  return true;
}

}  // namespace

bool goes_before(const RightOfWayInput& input, const RightOfWay& right, int i) {
  if (i < 0 || i == input.self || i >= static_cast<int>(input.arms.size())) return false;
  const ArmObservation& other = input.arms[i];
  const bool asks = other.known && other.plans && other.has_goal && other.priority > 0;
  if (!right.under_way) return asks && input.parameters.yielding.at_rest;
  return asks && priority_of(input, i).precedes({right.priority, input.self});
}

void update(const RightOfWayInput& input, Random& random, RightOfWay& right) {
  if (input.parameters.yielding.yield_request_delay <= 0.0) return;
  choose(input, random, right);
  if (right.under_way) wait(input, random, right);
  right.leads = leads(input, right);
}

// Each near link of these arms pushes along the gradient of its distance, −g. The weight is 0 at dᵢ, where the damper
// allows ½ ξ, and 1 at dₛ, where it allows no approach.
JointVector retreat_velocity(const RightOfWayInput& input, const RightOfWay& right, const JointLimits& limits) {
  const double free_speed = 0.5 * input.parameters.damper.convergence_speed;
  JointVector away = JointVector::Zero(limits.velocity.size());
  for (const Row& row : input.rows) {
    if (!row.influences || !goes_before(input, right, row.arm)) continue;
    const double norm = row.g.norm();
    if (norm > 0.0) away -= std::clamp(1.0 - row.h / free_speed, 0.0, 1.0) / norm * row.g;
  }
  const double most = std::max(1.0, away.cwiseAbs().maxCoeff());
  return away.cwiseProduct(limits.velocity) / most;
}

}  // namespace hecaton::planner
