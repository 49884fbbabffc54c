#include "planner/model/kinematics.hpp"

#include <algorithm>
#include <cassert>

#include "planner/model/kinematics_kernels.hpp"
#include "planner/simd/instruction_set.hpp"
#include "planner/simd/sine_cosine.hpp"

namespace hecaton::planner {
namespace {

void set_motion(Kinematics& out, int joint, bool prismatic, const ChainStep& step) {
  const Eigen::Vector3d axis_W(step.axis_W[0], step.axis_W[1], step.axis_W[2]);
  const Eigen::Vector3d origin_W(step.origin_W[0], step.origin_W[1], step.origin_W[2]);
  out.axis_W[joint] = axis_W;
  out.origin_W[joint] = origin_W;
  out.prismatic[joint] = prismatic;
  const Eigen::Vector3d angular_W = prismatic ? Eigen::Vector3d::Zero().eval() : axis_W;
  const Eigen::Vector3d linear_W = prismatic ? axis_W : origin_W.cross(axis_W).eval();
  for (int k = 0; k < 3; ++k) {
    out.angular_W[k][joint] = angular_W[k];
    out.linear_W[k][joint] = linear_W[k];
  }
}

using ChainSteps = std::array<ChainStep, kMaxLinks>;

void place_links(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out, ChainSteps& steps) {
  assert(q.size() == model.joints());
  out.links = static_cast<int>(model.links.size());
  out.joints = model.joints();
  std::array<double, kMaxJoints> angle;
  std::array<double, kMaxJoints> sine;
  std::array<double, kMaxJoints> cosine;
  std::copy(q.begin(), q.end(), angle.begin());
  std::fill(angle.begin() + out.joints, angle.end(), 0.0);
  sine_cosine(angle.data(), out.joints, sine.data(), cosine.data());

  for (int i = 0; i < out.links; ++i) {
    const Link& link = model.links[i];
    const bool shifts = link.joint >= 0 && link.joint_type == JointType::kPrismatic;
    const bool turns = link.joint >= 0 && !shifts;
    ChainStep& step = steps[i];
    step.motion = link.motion;
    step.X_WP = (link.parent < 0 ? X_WB : out.X_WL[link.parent]).data();
    step.X_PJ = link.X_PJ.data();
    step.axis = link.axis.data();
    step.sine = turns ? sine[link.joint] : 0.0;
    step.cosine = turns ? cosine[link.joint] : 1.0;
    step.shift = shifts ? q[link.joint] : 0.0;
    step.X_WL = out.X_WL[i].data();
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
  for (int i = 0; i < out.links; ++i) {
    const Link& link = model.links[i];
    if (link.joint >= 0) set_motion(out, link.joint, link.joint_type == JointType::kPrismatic, steps[i]);
  }
  out.X_WT = out.X_WL[model.tool_link] * model.X_LT;
}

int joints_before(const RobotModel& model, int link) {
  for (int i = link; i >= 0; i = model.links[i].parent) {
    if (model.links[i].joint >= 0) return model.links[i].joint + 1;
  }
  return 0;
}

void point_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                    PointJacobian& J) {
  J.setZero(3, kinematics.joints);
  const int n = joints_before(model, link);
  for (int j = 0; j < n; ++j) {
    J.col(j) = kinematics.prismatic[j] ? kinematics.axis_W[j]
                                       : kinematics.axis_W[j].cross(p_W - kinematics.origin_W[j]).eval();
  }
}

void directional_jacobian(const RobotModel& model, const Kinematics& kinematics, int link, const Eigen::Vector3d& p_W,
                          const Eigen::Vector3d& n_W, JointVector& row) {
  // n · (ω × p + v) = ω · (p × n) + v · n
  const Eigen::Vector3d moment = p_W.cross(n_W);
  const auto& w = kinematics.angular_W;
  const auto& v = kinematics.linear_W;
  row.setZero(kinematics.joints);
  const int n = joints_before(model, link);
  for (int j = 0; j < n; ++j) {
    row[j] = w[0][j] * moment.x() + w[1][j] * moment.y() + w[2][j] * moment.z() +
             (v[0][j] * n_W.x() + v[1][j] * n_W.y() + v[2][j] * n_W.z());
  }
}

void tool_jacobian(const RobotModel& model, const Kinematics& kinematics, FrameJacobian& J) {
  J.setZero(6, kinematics.joints);
  const Eigen::Vector3d p_W = kinematics.X_WT.translation();
  const int n = joints_before(model, model.tool_link);
  for (int j = 0; j < n; ++j) {
    const Eigen::Vector3d& axis = kinematics.axis_W[j];
    if (kinematics.prismatic[j]) {
      J.col(j).tail<3>() = axis;
    } else {
      J.col(j).head<3>() = axis;
      J.col(j).tail<3>() = axis.cross(p_W - kinematics.origin_W[j]);
    }
  }
}

}  // namespace hecaton::planner
