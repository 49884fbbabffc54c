#include "planner/local/right_of_way.hpp"

#include <algorithm>

namespace hecaton::planner {
namespace {

/// An arm that went freely this long is not held back any more [s].
constexpr double kFree = 0.5;
/// An arm that has made room goes on when the other has been away this long [s].
constexpr double kApart = 0.3;
/// Patience varies by this share from time to time, lest two arms ask in turns for ever.
constexpr double kSpread = 0.25;
/// After each own asking on the way to a goal it waits this many times longer: making room takes as long as the arms
/// are slow and the way is long, and whoever asks back sooner only reverses it.
constexpr double kGrowth = 1.25;
/// But no more than this many times as long as at first.
constexpr double kMostGrowth = 16.0;

void begin_to_wait(const RightOfWayInput& input, Random& random, RightOfWay& right) {
  right.waited = 0.0;
  right.patience =
      right.growth * input.parameters.yielding.yield_request_delay * random.uniform(1.0 - kSpread, 1.0 + kSpread);
}

Priority priority_of(const RightOfWayInput& input, int i) {
  return {input.arms[i].priority, i};
}

/// The first in the order among those near that go before the own arm; −1: none.
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
    // Every new priority gets its time.
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

/// Counts how long the arm has been held back, and asks when that was too long.
void wait(const RightOfWayInput& input, Random& random, RightOfWay& right) {
  if (right.patience <= 0.0) begin_to_wait(input, random, right);
  if (input.held_back || right.yields_to >= 0) {
    right.waited += input.dt;
    right.free = 0.0;
  } else if ((right.free += input.dt) > kFree) {
    right.waited = 0.0;
  }
  if (right.waited < right.patience) return;
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

// Each near link of theirs pushes along the gradient of its distance, −g; weight 0 at dᵢ, where the damper leaves
// ½ ξ, and 1 at dₛ, where it leaves nothing.
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
