#include "planner/model/inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planner/model/kinematics.hpp"

namespace hecaton::planner {
namespace {

using TaskVector = Eigen::Matrix<double, 6, 1>;  // [rotation; translation], as in FrameJacobian

/// Rotation vector in W that turns `from` into `to`.
Eigen::Vector3d rotation_error(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  const Eigen::AngleAxisd turn(to * from.transpose());
  return turn.angle() * turn.axis();
}

/// Shortest rotation vector in W that turns the unit vector `from` into `to`.
Eigen::Vector3d direction_error(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d cross = from.cross(to);
  const double sine = cross.norm();
  const double angle = std::atan2(sine, from.dot(to));
  if (sine > 1e-9) return angle / sine * cross;
  return angle < 1.0 ? cross : Eigen::Vector3d(angle * from.unitOrthogonal());
}

class Solver {
 public:
  Solver(const Arm& arm, const Pose& X_WT, const IkOptions& options) : arm_(arm), X_WT_(X_WT), options_(options) {}

  /// [Nakamura86, Wampler86] Δq = Jᵀ (J Jᵀ + λ² I)⁻¹ e with λ from Levenberg–Marquardt: a step that reduces ‖e‖ lowers
  /// λ; any other step is undone and raises λ. A joint that a step would push beyond its limit stays on the limit, and
  /// the step is solved again without that joint.
  [[nodiscard]] bool converge(JointVector& q) {
    double damping = 0.1;
    q = q.cwiseMax(arm_.limits.lower).cwiseMin(arm_.limits.upper);
    TaskVector error = task_error(q);
    for (int i = 0; i < options_.iterations; ++i) {
      if (is_met(error)) return true;
      task_jacobian();
      const JointVector next = limited_step(q, error, damping);
      const TaskVector next_error = task_error(next);
      if (next_error.squaredNorm() < error.squaredNorm()) {
        q = next;
        error = next_error;
        damping = std::max(1e-6, damping * 0.3);
      } else {
        if (damping > 1e3) return false;
        damping *= 4.0;
        task_error(q);  // kinematics_ back to q
      }
    }
    return is_met(error);
  }

 private:
  TaskVector task_error(const JointVector& q) {
    forward_kinematics(*arm_.model, arm_.X_WB, q, kinematics_);
    TaskVector error = TaskVector::Zero();
    error.tail<3>() = X_WT_.translation() - kinematics_.X_WT.translation();
    if (options_.task == IkTask::kPose) {
      error.head<3>() = rotation_error(kinematics_.X_WT.linear(), X_WT_.linear());
    } else if (options_.task == IkTask::kPositionAndAxis) {
      error.head<3>() = direction_error(kinematics_.X_WT.linear().col(2), X_WT_.linear().col(2));
    }
    return error;
  }

  [[nodiscard]] bool is_met(const TaskVector& error) const {
    return error.tail<3>().norm() <= options_.position_tolerance &&
           error.head<3>().norm() <= options_.orientation_tolerance;
  }

  void task_jacobian() {
    tool_jacobian(*arm_.model, kinematics_, J_);
    if (options_.task == IkTask::kPosition) J_.topRows<3>().setZero();
    if (options_.task == IkTask::kPositionAndAxis) {  // a rotation about z does not move z
      const Eigen::Vector3d z_W = kinematics_.X_WT.linear().col(2);
      for (Eigen::Index j = 0; j < J_.cols(); ++j) J_.col(j).head<3>() -= z_W * z_W.dot(J_.col(j).head<3>());
    }
  }

  [[nodiscard]] JointVector limited_step(const JointVector& q, const TaskVector& error, double damping) const {
    constexpr double kLongest = 0.5;  // of any joint in one step [rad | m]: beyond, the linearisation is invalid
    FrameJacobian J = J_;
    JointVector fixed_step = JointVector::Zero(q.size());
    for (Eigen::Index round = 0; round <= q.size(); ++round) {
      const Eigen::Matrix<double, 6, 6> A =
          J * J.transpose() + damping * damping * Eigen::Matrix<double, 6, 6>::Identity();
      JointVector step = J.transpose() * A.ldlt().solve(error - J_ * fixed_step);
      const double longest = step.size() > 0 ? step.cwiseAbs().maxCoeff() : 0.0;
      if (longest > kLongest) step *= kLongest / longest;
      bool hit = false;
      for (Eigen::Index j = 0; j < q.size(); ++j) {
        const double target = q[j] + step[j];
        const double inside = std::clamp(target, arm_.limits.lower[j], arm_.limits.upper[j]);
        if (inside == target || J.col(j).isZero(0.0)) continue;
        hit = true;
        fixed_step[j] = inside - q[j];
        J.col(j).setZero();
      }
      if (!hit) return (q + step + fixed_step).cwiseMax(arm_.limits.lower).cwiseMin(arm_.limits.upper);
    }
    return (q + fixed_step).cwiseMax(arm_.limits.lower).cwiseMin(arm_.limits.upper);
  }

  const Arm& arm_;
  const Pose& X_WT_;
  const IkOptions& options_;
  Kinematics kinematics_;
  FrameJacobian J_;
};

/// Adds whole turns to revolute joints, so that they are as near to `start` as the limits allow.
JointVector unwound(const Arm& arm, JointVector q, const JointVector& start) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (const Link& link : arm.model->links) {
    if (link.joint < 0 || link.joint_type == JointType::kPrismatic) continue;
    const int j = link.joint;
    const double turned = q[j] + kTurn * std::round((start[j] - q[j]) / kTurn);
    if (turned >= arm.limits.lower[j] && turned <= arm.limits.upper[j]) q[j] = turned;
  }
  return q;
}

}  // namespace

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

std::optional<JointVector> inverse_kinematics(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                              const IkOptions& options) {
  Solver solver(arm, X_WT, options);
  std::mt19937_64 random(options.random_seed);
  for (int attempt = 0; attempt <= options.seeds; ++attempt) {
    JointVector q = attempt == 0 ? start : random_configuration(arm.limits, random);
    if (!solver.converge(q)) continue;
    q = unwound(arm, q, start);
    if (!options.accept || options.accept(q)) return q;
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
