#include "planner/model/kinematics.hpp"

#include <cassert>

namespace hecaton::planner {

void forward_kinematics(const RobotModel& model, const Pose& X_WB, const JointVector& q, Kinematics& out) {
  assert(q.size() == model.joints());
  out.links = static_cast<int>(model.links.size());
  out.joints = model.joints();
  for (int i = 0; i < out.links; ++i) {
    const Link& link = model.links[i];
    Pose X_WJ = (link.parent < 0 ? X_WB : out.X_WL[link.parent]) * link.X_PJ;
    if (link.joint >= 0) {
      const Eigen::Vector3d axis_W = X_WJ.linear() * link.axis;
      out.axis_W[link.joint] = axis_W;
      out.origin_W[link.joint] = X_WJ.translation();
      out.prismatic[link.joint] = link.joint_type == JointType::kPrismatic;
      if (link.joint_type == JointType::kPrismatic) {
        X_WJ.translation() += axis_W * q[link.joint];
      } else {
        X_WJ.linear() = X_WJ.linear() * Eigen::AngleAxisd(q[link.joint], link.axis).toRotationMatrix();
      }
    }
    out.X_WL[i] = X_WJ;
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
  row.setZero(kinematics.joints);
  const int n = joints_before(model, link);
  for (int j = 0; j < n; ++j) {
    const Eigen::Vector3d& axis = kinematics.axis_W[j];
    row[j] = kinematics.prismatic[j] ? n_W.dot(axis) : n_W.dot(axis.cross(p_W - kinematics.origin_W[j]));
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

Eigen::Vector3d point_velocity(const RobotModel& model, const Kinematics& kinematics, int link,
                               const Eigen::Vector3d& p_W, const JointVector& qd) {
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();
  const int n = joints_before(model, link);
  for (int j = 0; j < n; ++j) {
    const Eigen::Vector3d& axis = kinematics.axis_W[j];
    v_W += qd[j] * (kinematics.prismatic[j] ? axis : axis.cross(p_W - kinematics.origin_W[j]).eval());
  }
  return v_W;
}

}  // namespace hecaton::planner
