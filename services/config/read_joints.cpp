#include <algorithm>
#include <cmath>

#include "services/config/readers.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

using planner::JointLimits;
using planner::JointVector;
using planner::RobotModel;

constexpr double kFastest = 1e3;             // [rad/s | m/s]
constexpr double kLeastAcceleration = 1e-3;  // [rad/s² | m/s²]; with less, an arm practically never stops
constexpr double kMostAcceleration = 1e5;    // [rad/s² | m/s²]

std::string unit_of(const RobotModel& model, int joint, const char* per = "") {
  return (joint_type(model, joint) == planner::JointType::kPrismatic ? "m" : "rad") + std::string(per);
}

std::vector<YamlView> one_per_joint(const YamlView& view, const RobotModel& model) {
  const auto joints = static_cast<std::size_t>(model.joints());
  std::string names;
  for (const std::string& name : model.joint_names) names += (names.empty() ? "" : ", ") + name;
  return view.items(joints, joints, "numbers, one for each joint (" + names + ")");
}

// A list gives every joint its own position limit, which must not be wider than the URDF's. A single number applies to
// all joints.
void tighten_positions(const YamlView& view, const RobotModel& model, bool upper, JointLimits& limits) {
  JointVector& bound = upper ? limits.upper : limits.lower;
  const auto tighten = [&](const YamlView& number, int joint) {
    const std::string unit = unit_of(model, joint);
    const double low = std::max(model.limits.lower[joint], -1e6);
    const double high = std::min(model.limits.upper[joint], 1e6);
    const double value = number.number({-1e6, 1e6, unit});
    if (value < low || value > high) {
      number.fail("within the limits of " + model.joint_names[joint] + ", " + Bounds{low, high, unit}.text());
    }
    bound[joint] = value;
  };
  if (view.is_sequence()) {
    const auto numbers = one_per_joint(view, model);
    for (int joint = 0; joint < model.joints(); ++joint) tighten(numbers[joint], joint);
  } else {
    for (int joint = 0; joint < model.joints(); ++joint) tighten(view, joint);
  }
}

// A list gives every joint its own velocity limit, at most the URDF's. A single number caps all joints.
void tighten_velocities(const YamlView& view, const RobotModel& model, JointLimits& limits) {
  if (!view.is_sequence()) {
    const double cap = view.number({0.0, kFastest, "rad/s (m/s for a prismatic joint)", true});
    limits.velocity = limits.velocity.cwiseMin(cap);
    return;
  }
  const auto numbers = one_per_joint(view, model);
  for (int joint = 0; joint < model.joints(); ++joint) {
    const std::string unit = unit_of(model, joint, "/s");
    const double value = numbers[joint].number({0.0, kFastest, unit, true});
    if (value > model.limits.velocity[joint]) {
      numbers[joint].fail("at most " + number_text(model.limits.velocity[joint]) + " " + unit +
                          ", the URDF's limit of " + model.joint_names[joint]);
    }
    limits.velocity[joint] = value;
  }
}

void set_accelerations(const YamlView& view, const RobotModel& model, JointLimits& limits) {
  const Bounds bounds{kLeastAcceleration, kMostAcceleration, "rad/s² (m/s² for a prismatic joint)"};
  if (!view.is_sequence()) {
    limits.acceleration.setConstant(view.number(bounds));
    return;
  }
  const auto numbers = one_per_joint(view, model);
  for (int joint = 0; joint < model.joints(); ++joint) limits.acceleration[joint] = numbers[joint].number(bounds);
}

}  // namespace

JointLimits read_limits(const ArmView& arm, const RobotModel& model) {
  const auto find = [&](std::string_view key) { return arm.find("limits", section::kArmLimits, key); };
  JointLimits limits = model.limits;
  const auto lower = find("lower");
  const auto upper = find("upper");
  if (lower) tighten_positions(*lower, model, false, limits);
  if (upper) tighten_positions(*upper, model, true, limits);
  for (int joint = 0; joint < model.joints(); ++joint) {
    if (limits.lower[joint] < limits.upper[joint]) continue;
    // The cell file gives one of them: the loader refuses a URDF with reversed limits.
    const YamlView& given = lower ? *lower : *upper;
    const double other = lower ? limits.upper[joint] : limits.lower[joint];
    (given.is_sequence() ? one_per_joint(given, model)[joint] : given)
        .fail((lower ? "below " : "above ") + number_text(other) + " " + unit_of(model, joint) + ", the " +
              (lower ? "upper" : "lower") + " limit of " + model.joint_names[joint]);
  }
  if (const auto velocity = find("velocity")) tighten_velocities(*velocity, model, limits);
  if (const auto acceleration = find("acceleration")) set_accelerations(*acceleration, model, limits);
  return limits;
}

JointVector read_configuration(const YamlView& view, const RobotModel& model, const JointLimits& limits) {
  const auto numbers = one_per_joint(view, model);
  JointVector q(model.joints());
  for (int joint = 0; joint < model.joints(); ++joint) {
    const std::string unit = unit_of(model, joint);
    q[joint] = numbers[joint].number({-1e6, 1e6, unit});
    const double inside = std::clamp(q[joint], limits.lower[joint], limits.upper[joint]);
    if (std::abs(inside - q[joint]) <= planner::kLimitRounding) {  // a rounded text: no finding
      q[joint] = inside;
    } else {
      numbers[joint].fail(Bounds{limits.lower[joint], limits.upper[joint], unit}.text() + ", the limits of " +
                          model.joint_names[joint]);
    }
  }
  return q;
}

}  // namespace hecaton::config
