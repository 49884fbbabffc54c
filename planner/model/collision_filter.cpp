#include "planner/model/collision_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "planner/model/kinematics.hpp"
#include "planner/model/separation_proof.hpp"

namespace hecaton::planner {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

JointVector random_configuration(const JointLimits& limits, std::mt19937_64& random) {
  JointVector q(limits.lower.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const bool endless = !std::isfinite(limits.lower[j]) || !std::isfinite(limits.upper[j]);
    const double lower = endless ? -std::numbers::pi : limits.lower[j];
    const double upper = endless ? std::numbers::pi : limits.upper[j];
    const double unit = static_cast<double>(random() >> 11U) * 0x1.0p-53;  // [0, 1), the same on every platform
    q[j] = lower + unit * (upper - lower);
  }
  return q;
}

Pairs always_touching(const RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  std::mt19937_64 random(options.random_seed);
  Pairs touching = model.self_pairs;
  Kinematics kinematics;
  for (int sample = 0; sample < options.samples && !touching.empty(); ++sample) {
    forward_kinematics(model, Pose::Identity(), random_configuration(model.limits, random), kinematics);
    std::erase_if(touching, [&](const std::pair<int, int>& pair) {
      const LinkGeometry& a = model.geometry[pair.first];
      const LinkGeometry& b = model.geometry[pair.second];
      return distance(a.shape, kinematics.X_WL[a.link] * a.X_LS, b.shape, kinematics.X_WL[b.link] * b.X_LS) > 0.0;
    });
  }
  return touching;
}

std::string names(const RobotModel& model, const Pairs& pairs) {
  std::string text;
  for (const auto& [a, b] : pairs) {
    const std::string pair = model.links[model.geometry[a].link].name + "–" + model.links[model.geometry[b].link].name;
    if (text.find(pair) == std::string::npos) text += (text.empty() ? "" : ", ") + pair;
  }
  return text;
}

void remove(RobotModel& model, const Pairs& pairs, const std::string& reason) {
  if (pairs.empty()) return;
  std::erase_if(model.self_pairs,
                [&](const auto& pair) { return std::find(pairs.begin(), pairs.end(), pair) != pairs.end(); });
  model.notes.push_back("self-collision is not checked between links that " + reason + ": " + names(model, pairs));
}

}  // namespace

Pairs pairs_of_separate_bodies(const RobotModel& model) {
  Pairs pairs;
  for (int a = 0; a < static_cast<int>(model.geometry.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(model.geometry.size()); ++b) {
      const int joints_a = joints_before(model, model.geometry[a].link);  // numbers the rigid bodies from the base
      const int joints_b = joints_before(model, model.geometry[b].link);
      if (std::abs(joints_a - joints_b) > 1) pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

void automatic_filter(RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  if (options.samples > 0) remove(model, always_touching(model, distance, options), "always touch");
  Pairs apart;
  for (const auto& [a, b] : model.self_pairs) {
    if (proven_apart(model, a, b, distance, options.apart, options.proof_budget)) apart.emplace_back(a, b);
  }
  remove(model, apart, "provably never come near each other");
}

}  // namespace hecaton::planner
