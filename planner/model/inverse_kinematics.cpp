#include "planner/model/inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>

#include "planner/model/kinematics.hpp"
#include "planner/model/whole_turns.hpp"

namespace hecaton::planner {
namespace {

using TaskVector = Eigen::Matrix<double, 6, 1>;  // [rotation; translation], as in FrameJacobian

class Solver {
 public:
  Solver(const Arm& arm, const Pose& X_WT, const IkOptions& options) : arm_(arm), X_WT_(X_WT), options_(options) {}

  /// Moves q to a solution. False when the search ends elsewhere.
  [[nodiscard]] bool converge(JointVector& q) { return is_met(minimise(q, options_.free_rotation, 1.0)); }

  /// Moves q to the position of X_WT, with an orientation that is locally the nearest. False when the search ends at
  /// another position. The weight of the orientation decreases, because at the end only the position counts.
  [[nodiscard]] bool approach_orientation(JointVector& q) {
    for (const double metres_per_radian : {0.3, 0.02}) (void)minimise(q, options_.free_rotation, metres_per_radian);
    return minimise(q, FreeRotation::kAll, 1.0).tail<3>().norm() <= options_.position_tolerance;
  }

  /// Moves q to a local minimum of the error in position and orientation, and returns that error.
  [[nodiscard]] ToolError approach(JointVector& q) {
    constexpr double kMetresPerRadian = 0.3;
    const TaskVector error = minimise(q, options_.free_rotation, kMetresPerRadian);
    return {error.tail<3>().norm(), error.head<3>().norm()};
  }

  /// Of the last configuration.
  [[nodiscard]] const Pose& X_WT() const { return kinematics_.X_WT; }

 private:
  /// [Nakamura86, Wampler86] Δq = Jᵀ (J Jᵀ + λ² I)⁻¹ e with λ from Levenberg–Marquardt: a step that reduces ‖e‖ lowers
  /// λ; any other step is undone and raises λ. A joint that a step would push beyond its limit stays on the limit, and
  /// the step is solved again without that joint. Returns e at the final q. `weight`: of the orientation in ‖e‖
  /// [m/rad].
  TaskVector minimise(JointVector& q, FreeRotation free_rotation, double weight) {
    constexpr double kSmallestGain = 1e-9;  // of a step, as a share of ‖e‖²: the search is at a minimum
    double damping = 0.1;
    q = q.cwiseMax(arm_.limits.lower).cwiseMin(arm_.limits.upper);
    TaskVector error = task_error(q, free_rotation, weight);
    for (int i = 0; i < options_.iterations && !is_met(error, weight); ++i) {
      task_jacobian(free_rotation, weight);
      const JointVector next = limited_step(q, error, damping);
      const TaskVector next_error = task_error(next, free_rotation, weight);
      if (next_error.squaredNorm() < error.squaredNorm()) {
        const bool ends = weight != 1.0 && next_error.squaredNorm() > (1.0 - kSmallestGain) * error.squaredNorm();
        q = next;
        error = next_error;
        damping = std::max(1e-6, damping * 0.3);
        if (ends) break;
      } else {
        task_error(q, free_rotation, weight);  // kinematics_ back to q
        if (damping > 1e3) break;
        damping *= 4.0;
      }
    }
    error.head<3>() /= weight;
    return error;
  }

  TaskVector task_error(const JointVector& q, FreeRotation free_rotation, double weight) {
    forward_kinematics(*arm_.model, arm_.X_WB, q, kinematics_);
    TaskVector error;
    error.head<3>() = weight * rotation_error(free_rotation, kinematics_.X_WT.linear(), X_WT_.linear());
    error.tail<3>() = X_WT_.translation() - kinematics_.X_WT.translation();
    return error;
  }

  [[nodiscard]] bool is_met(const TaskVector& error, double weight = 1.0) const {
    return error.tail<3>().norm() <= options_.position_tolerance &&
           error.head<3>().norm() <= weight * options_.orientation_tolerance;
  }

  void task_jacobian(FreeRotation free_rotation, double weight) {
    tool_jacobian(*arm_.model, kinematics_, J_);
    switch (free_rotation) {
      case FreeRotation::kNone:
        break;
      case FreeRotation::kAll:
        J_.topRows<3>().setZero();
        break;
      case FreeRotation::kRoll:
      case FreeRotation::kPitch:
      case FreeRotation::kYaw: {  // a rotation about the axis does not move the axis
        const auto column = static_cast<Eigen::Index>(free_rotation) - static_cast<Eigen::Index>(FreeRotation::kRoll);
        const Eigen::Vector3d axis_W = kinematics_.X_WT.linear().col(column);
        for (Eigen::Index j = 0; j < J_.cols(); ++j) J_.col(j).head<3>() -= axis_W * axis_W.dot(J_.col(j).head<3>());
        break;
      }
    }
    J_.topRows<3>() *= weight;
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

bool tool_stays_on_surface(const Arm& arm) {
  constexpr int kPostures = 16;
  constexpr double kFlat = 1e-10;  // smallest over largest squared singular value
  if (arm.model->joints() < 3) return true;
  std::mt19937_64 random(1);
  Kinematics kinematics;
  FrameJacobian J;
  for (int posture = 0; posture < kPostures; ++posture) {
    forward_kinematics(*arm.model, arm.X_WB, random_configuration(arm.limits, random), kinematics);
    tool_jacobian(*arm.model, kinematics, J);
    const Eigen::Matrix3d squares = J.bottomRows<3>() * J.bottomRows<3>().transpose();
    const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares).eigenvalues();
    if (values[0] > kFlat * values[2]) return false;
  }
  return true;
}

std::optional<JointVector> inverse_kinematics(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                              const IkOptions& options) {
  Solver solver(arm, X_WT, options);
  std::mt19937_64 random(options.random_seed);
  for (int attempt = 0; attempt <= options.seeds; ++attempt) {
    JointVector q = attempt == 0 ? start : random_configuration(arm.limits, random);
    if (!solver.converge(q)) continue;
    q = nearest_turns(arm, q, start);
    if (!options.accept || options.accept(q)) return q;
  }
  return std::nullopt;
}

namespace {

/// The same where none of the local minima is accepted: of the accepted configurations that meet the position, whatever
/// their orientation, the nearest one.
std::optional<NearestOrientation> accepted_orientation(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                                       const IkOptions& options) {
  IkOptions position = options;
  position.free_rotation = FreeRotation::kAll;
  Solver solver(arm, X_WT, position);
  std::mt19937_64 random(options.random_seed);
  std::optional<NearestOrientation> nearest;
  for (int attempt = 0; attempt <= options.seeds; ++attempt) {
    JointVector q = attempt == 0 ? start : random_configuration(arm.limits, random);
    if (!solver.converge(q)) continue;
    const double angle = rotation_error(options.free_rotation, solver.X_WT().linear(), X_WT.linear()).norm();
    if (nearest && nearest->angle <= angle) continue;
    q = nearest_turns(arm, q, start);
    if (options.accept(q)) nearest = NearestOrientation{q, solver.X_WT(), angle};
  }
  return nearest;
}

}  // namespace

std::optional<NearestOrientation> nearest_orientation(const Arm& arm, const Pose& X_WT, const JointVector& start,
                                                      const IkOptions& options) {
  Solver solver(arm, X_WT, options);
  std::mt19937_64 random(options.random_seed);
  std::vector<NearestOrientation> found;
  for (int attempt = 0; attempt <= options.seeds; ++attempt) {
    JointVector q = attempt == 0 ? start : random_configuration(arm.limits, random);
    if (!solver.approach_orientation(q)) continue;
    const double angle = rotation_error(options.free_rotation, solver.X_WT().linear(), X_WT.linear()).norm();
    found.push_back({nearest_turns(arm, q, start), solver.X_WT(), angle});
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.angle < b.angle; });
  const auto accepted = std::find_if(found.begin(), found.end(), [&](const NearestOrientation& candidate) {
    return !options.accept || options.accept(candidate.q);
  });
  if (accepted != found.end()) return *accepted;
  return found.empty() || !options.accept ? std::nullopt : accepted_orientation(arm, X_WT, start, options);
}

NearestPose nearest_pose(const Arm& arm, const Pose& X_WT, const JointVector& start, const IkOptions& options) {
  Solver solver(arm, X_WT, options);
  NearestPose nearest{.q = start, .X_WT = Pose::Identity(), .error = {}};
  nearest.error = solver.approach(nearest.q);
  nearest.X_WT = solver.X_WT();
  nearest.q = nearest_turns(arm, nearest.q, start);
  return nearest;
}

}  // namespace hecaton::planner
