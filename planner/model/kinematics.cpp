#include "planner/model/kinematics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "planner/model/kinematics_kernels.hpp"
#include "planner/simd/instruction_set.hpp"
#include "planner/simd/sine_cosine.hpp"

namespace hecaton::planner {
namespace {

void set_motion(Kinematics& out, int axis, bool prismatic, const ChainStep& step) {
  const Eigen::Vector3d axis_W(step.axis_W[0], step.axis_W[1], step.axis_W[2]);
  const Eigen::Vector3d origin_W(step.origin_W[0], step.origin_W[1], step.origin_W[2]);
  out.axis_W[axis] = axis_W;
  out.origin_W[axis] = origin_W;
  out.prismatic[axis] = prismatic;
  const Eigen::Vector3d angular_W = prismatic ? Eigen::Vector3d::Zero().eval() : axis_W;
  const Eigen::Vector3d linear_W = prismatic ? axis_W : origin_W.cross(axis_W).eval();
  for (int k = 0; k < 3; ++k) {
    out.angular_W[k][axis] = angular_W[k];
    out.linear_W[k][axis] = linear_W[k];
  }
}

using ChainSteps = std::array<ChainStep, kMaxLinks>;
using AxisPositions = std::array<double, kMaxJoints>;

/// Fills the positions of all axes and returns their number.
int place_axes(const RobotModel& model, const JointVector& q, AxisPositions& position) {
  if (!model.has_followers) {
    std::copy(q.begin(), q.end(), position.begin());
    return model.joints();
  }
  int axes = 0;
  for (const Link& link : model.links) {
    if (link.joint >= 0) position[axes++] = link.multiplier * q[link.joint] + link.offset;
  }
  return axes;
}

void place_links(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out, ChainSteps& steps) {
  assert(q.size() == model.joints());
  out.links = static_cast<int>(model.links.size());
  out.joints = model.joints();
  AxisPositions position;
  AxisPositions sine;
  AxisPositions cosine;
  const int axes = place_axes(model, q, position);
  std::fill(position.begin() + axes, position.end(), 0.0);
  sine_cosine(position.data(), axes, sine.data(), cosine.data());

  int axis = 0;
  for (int i = 0; i < out.links; ++i) {
    const Link& link = model.links[i];
    const bool shifts = link.joint >= 0 && link.joint_type == JointType::kPrismatic;
    const bool turns = link.joint >= 0 && !shifts;
    ChainStep& step = steps[i];
    step.motion = link.motion;
    step.X_WP = (link.parent < 0 ? X_WB : out.X_WL[link.parent]).data();
    step.X_PJ = link.X_PJ.data();
    step.axis = link.axis.data();
    step.sine = turns ? sine[axis] : 0.0;
    step.cosine = turns ? cosine[axis] : 1.0;
    step.shift = shifts ? position[axis] : 0.0;
    step.X_WL = out.X_WL[i].data();
    if (link.joint >= 0) ++axis;
  }
  static const ChainKernel place_chain = fastest(baseline::place_chain, avx2::place_chain);
  place_chain(steps.data(), out.links);
}

}  // namespace

void place_links(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out) {
  ChainSteps steps;
  place_links(model, X_WB, q, out, steps);
}

void forward_kinematics(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out) {
  ChainSteps steps;
  place_links(model, X_WB, q, out, steps);
  int axis = 0;
  for (int i = 0; i < out.links; ++i) {
    const Link& link = model.links[i];
    if (link.joint >= 0) set_motion(out, axis++, link.joint_type == JointType::kPrismatic, steps[i]);
  }
  out.X_WT = out.X_WL[model.tool_link] * model.X_LT;
}

int moved_link(const RobotModel& model, int link) {
  while (link >= 0 && model.links[link].joint < 0) link = model.links[link].parent;
  return link;
}

int axes_before(const RobotModel& model, int link) {
  int moved = moved_link(model, link);
  if (!model.has_followers) return moved < 0 ? 0 : model.links[moved].joint + 1;
  int axes = 0;
  for (; moved >= 0; moved = moved_link(model, model.links[moved].parent)) ++axes;
  return axes;
}

void axis_speeds(const RobotModel& model, const JointVector& speed, std::array<double, kMaxJoints>& out) {
  int axes = 0;
  if (model.has_followers) {
    for (const Link& link : model.links) {
      if (link.joint >= 0) out[axes++] = std::abs(link.multiplier) * speed[link.joint];
    }
  } else {
    for (; axes < speed.size(); ++axes) out[axes] = speed[axes];
  }
  std::fill(out.begin() + axes, out.end(), 0.0);
}

namespace {

/// Calls add(joint, multiplier, axis) for each axis that moves `link`, tip to base.
template <typename Add>
void for_each_axis(const RobotModel& model, int link, const Add& add) {
  int axis = axes_before(model, link);
  for (int i = moved_link(model, link); i >= 0; i = moved_link(model, model.links[i].parent)) {
    add(model.links[i].joint, model.links[i].multiplier, --axis);
  }
}

/// The velocity in W of the point at p_W per unit rate of the axis.
Eigen::Vector3d point_motion(const Kinematics& kinematics, int axis, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d& direction = kinematics.axis_W[axis];
  return kinematics.prismatic[axis] ? direction : direction.cross(p_W - kinematics.origin_W[axis]).eval();
}

}  // namespace

void point_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                    PointJacobian& J) {
  J.setZero(3, kinematics.joints);
  for_each_axis(model, link, [&](int joint, double multiplier, int axis) {
    J.col(joint) += multiplier * point_motion(kinematics, axis, p_W);
  });
}

void directional_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                          const Eigen::Vector3d& n_W, JointVector& row) {
  // n · (ω × p + v) = ω · (p × n) + v · n
  const Eigen::Vector3d moment = p_W.cross(n_W);
  const auto& w = kinematics.angular_W;
  const auto& v = kinematics.linear_W;
  const auto along = [&](int axis) {
    return w[0][axis] * moment.x() + w[1][axis] * moment.y() + w[2][axis] * moment.z() +
           (v[0][axis] * n_W.x() + v[1][axis] * n_W.y() + v[2][axis] * n_W.z());
  };
  row.setZero(kinematics.joints);
  if (model.has_followers) {
    for_each_axis(model, link, [&](int joint, double multiplier, int axis) { row[joint] += multiplier * along(axis); });
    return;
  }
  const int n = axes_before(model, link);
  for (int j = 0; j < n; ++j) row[j] = along(j);
}

void tool_jacobian(const RobotModel& model, const Kinematics& kinematics, FrameJacobian& J) {
  J.setZero(6, kinematics.joints);
  const Eigen::Vector3d p_W = kinematics.X_WT.translation();
  for_each_axis(model, model.tool_link, [&](int joint, double multiplier, int axis) {
    if (!kinematics.prismatic[axis]) J.col(joint).head<3>() += multiplier * kinematics.axis_W[axis];
    J.col(joint).tail<3>() += multiplier * point_motion(kinematics, axis, p_W);
  });
}

}  // namespace hecaton::planner
