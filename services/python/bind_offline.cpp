/// CellModel and its results as classes of `_hecaton`.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <hecaton/client.hpp>

#include "services/config/text.hpp"
#include "services/python/bindings.hpp"
#include "services/python/casters.hpp"
#include "services/python/cell_model.hpp"
#include "services/python/interruptible.hpp"

namespace hecaton::python {
namespace {

using Shared = std::shared_ptr<CellModel>;

py::array_t<double> array_of_joints(const planner::JointVector& q) {
  return array_of(std::span(q.data(), static_cast<std::size_t>(q.size())));
}

Pose to_public(const planner::Pose& X) {
  const Eigen::Quaterniond rotation(X.linear());
  return {{X.translation().x(), X.translation().y(), X.translation().z()},
          {rotation.w(), rotation.x(), rotation.y(), rotation.z()}};
}

planner::Pose from_public(const Pose& pose) {
  planner::Pose X = planner::Pose::Identity();
  X.translation() << pose.position.x, pose.position.y, pose.position.z;
  X.linear() =
      Eigen::Quaterniond(pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]).toRotationMatrix();
  return X;
}

std::string name_of(planner::global::PlanStatus status) {
  switch (status) {
    case planner::global::PlanStatus::kSolved:
      return "solved";
    case planner::global::PlanStatus::kStartInvalid:
      return "start_invalid";
    case planner::global::PlanStatus::kGoalInvalid:
      return "goal_invalid";
    case planner::global::PlanStatus::kBudgetEnded:
      return "budget_ended";
    case planner::global::PlanStatus::kStuck:
      return "stuck";
  }
  return "unknown";
}

/// The columns of one planned arm.
struct Columns {
  std::size_t first = 0;
  std::size_t count = 0;
};

std::vector<Columns> columns_of(const PlanAnswer& answer) {
  std::vector<Columns> columns;
  std::size_t first = 0;
  for (const int joints : answer.joints) {
    columns.push_back({first, static_cast<std::size_t>(joints)});
    first += static_cast<std::size_t>(joints);
  }
  return columns;
}

/// One array (rows, joints) for each planned arm. `value(row, column)`.
template <class Value>
py::dict by_arm(const PlanAnswer& answer, std::size_t rows, const Value& value) {
  py::dict arrays;
  const std::vector<Columns> columns = columns_of(answer);
  for (std::size_t arm = 0; arm < answer.arms.size(); ++arm) {
    py::array_t<double> array({static_cast<py::ssize_t>(rows), static_cast<py::ssize_t>(columns[arm].count)});
    auto cells = array.mutable_unchecked<2>();
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t joint = 0; joint < columns[arm].count; ++joint) {
        cells(static_cast<py::ssize_t>(row), static_cast<py::ssize_t>(joint)) = value(row, columns[arm].first + joint);
      }
    }
    arrays[py::str(answer.arms[arm])] = array;
  }
  return arrays;
}

py::dict path_of(const PlanAnswer& answer) {
  const auto& path = answer.plan.path;
  return by_arm(answer, path.size(), [&](std::size_t row, std::size_t column) { return path[row][column]; });
}

/// Times, and positions and velocities by arm.
py::tuple trajectory_of(const PlanAnswer& answer, double period) {
  if (!(period > 0.0) || !std::isfinite(period)) {
    throw InvalidArgument("period = " + config::number_text(period) + " must be a finite number above 0 [s]");
  }
  std::vector<double> times;
  std::vector<planner::TrajectoryPoint> points;
  if (!answer.trajectory.empty()) {
    const double duration = answer.trajectory.duration();
    constexpr double kMostSamples = 1e6;
    if (duration / period > kMostSamples) {
      throw InvalidArgument("period = " + config::number_text(period) + " must give at most a million samples of " +
                            config::number_text(duration) + " s");
    }
    for (std::size_t i = 0; times.empty() || times.back() < duration; ++i) {
      times.push_back(std::min(static_cast<double>(i) * period, duration));
      points.push_back(answer.trajectory.at(times.back()));
    }
  }
  const auto q = [&](std::size_t row, std::size_t column) { return points[row].q[static_cast<Eigen::Index>(column)]; };
  const auto qd = [&](std::size_t row, std::size_t column) {
    return points[row].qd[static_cast<Eigen::Index>(column)];
  };
  return py::make_tuple(array_of(times), by_arm(answer, points.size(), q), by_arm(answer, points.size(), qd));
}

/// "<hecaton.PlanAnswer solved: north, west; 7 points, 3.2 s, length 2.41, clearance 0.034 m>"
std::string representation(const PlanAnswer& answer) {
  std::string text = "<hecaton.PlanAnswer " + name_of(answer.plan.status) + ": ";
  if (!answer.plan.solved()) return text + answer.plan.reason + ">";
  for (std::size_t i = 0; i < answer.arms.size(); ++i) text += (i > 0 ? ", " : "") + answer.arms[i];
  const auto rounded = [](double value) {
    std::array<char, 32> digits{};
    const int size = std::snprintf(digits.data(), digits.size(), "%.3g", value);
    return std::string(digits.data(), static_cast<std::size_t>(size));
  };
  const double duration = answer.trajectory.empty() ? 0.0 : answer.trajectory.duration();
  return text + "; " + std::to_string(answer.plan.path.size()) + " points, " + rounded(duration) + " s, length " +
         rounded(answer.plan.length) + ", clearance " + rounded(answer.clearance) + " m>";
}

py::dict limits_of(const planner::JointLimits& limits) {
  py::dict arrays;
  arrays["lower"] = array_of_joints(limits.lower);
  arrays["upper"] = array_of_joints(limits.upper);
  arrays["velocity"] = array_of_joints(limits.velocity);
  arrays["acceleration"] = array_of_joints(limits.acceleration);
  return arrays;
}

py::dict link_poses(const CellModel& model, const std::string& arm, const std::vector<double>& q) {
  const planner::Kinematics kinematics = model.forward(arm, q);
  py::dict poses;
  const auto& links = model.arm(arm).arm.model->links;
  for (std::size_t i = 0; i < links.size(); ++i) poses[py::str(links[i].name)] = to_public(kinematics.X_WL[i]);
  return poses;
}

py::dict report_of(const planner::Cell& cell, const planner::BatchReport& report) {
  py::dict values;
  values["tasks"] = report.tasks;
  values["reached"] = report.reached;
  values["blocked"] = report.blocked;
  values["timed_out"] = report.timed_out;
  values["not_drawn"] = report.not_drawn;
  values["contacts"] = report.contacts;
  values["duration"] = report.duration;
  values["reach_times"] = array_of(report.reach_times);
  values["smallest"] = report.has_smallest
                           ? py::object(py::make_tuple(report.smallest.a, report.smallest.b, report.smallest.distance))
                           : py::object(py::none());
  py::list missed;
  for (const planner::MissedTask& task : report.missed) {
    missed.append(py::make_tuple(task.episode, cell.arms[task.arm].arm.name, task.reason));
  }
  values["missed"] = missed;
  return values;
}

void bind_kinematics(py::class_<CellModel, Shared>& model) {
  model
      .def(
          "forward",
          [](const CellModel& self, const std::string& arm, const std::vector<double>& q) {
            return to_public(self.forward(arm, q).X_WT);
          },
          py::arg("arm"), py::arg("q"))
      .def("links", &link_poses, py::arg("arm"), py::arg("q"))
      .def(
          "jacobian",
          [](const CellModel& self, const std::string& arm, const std::vector<double>& q) {
            const planner::FrameJacobian J = self.jacobian(arm, q);
            py::array_t<double> array({static_cast<py::ssize_t>(J.rows()), static_cast<py::ssize_t>(J.cols())});
            auto cells = array.mutable_unchecked<2>();
            for (Eigen::Index row = 0; row < J.rows(); ++row) {
              for (Eigen::Index column = 0; column < J.cols(); ++column) cells(row, column) = J(row, column);
            }
            return array;
          },
          py::arg("arm"), py::arg("q"))
      .def(
          "inverse",
          [](const Shared& self, const std::string& arm, const Pose& pose, std::optional<std::vector<double>> start,
             FreeRotation free_rotation, double position_tolerance, double orientation_tolerance, bool collision_free,
             int seeds) -> py::object {
            InverseQuery query;
            query.start = std::move(start);
            query.free_rotation = static_cast<planner::FreeRotation>(free_rotation);
            query.position_tolerance = position_tolerance;
            query.orientation_tolerance = orientation_tolerance;
            query.collision_free = collision_free;
            query.seeds = seeds;
            const auto q = run_interruptibly(std::stop_token(), [&](const std::stop_token& stop) {
              return self->inverse(arm, from_public(pose), query, stop);
            });
            return q ? py::object(array_of_joints(*q)) : py::object(py::none());
          },
          py::arg("arm"), py::arg("pose"), py::arg("start"), py::arg("free_rotation"), py::arg("position_tolerance"),
          py::arg("orientation_tolerance"), py::arg("collision_free"), py::arg("seeds"))
      .def(
          "nearest",
          [](const CellModel& self, const Positions& positions) {
            const auto nearest = self.nearest(positions);
            return py::make_tuple(nearest.a, nearest.b, nearest.distance);
          },
          py::arg("positions"));
}

void bind_plans(py::class_<CellModel, Shared>& model) {
  model
      .def(
          "plan",
          [](const Shared& self, Positions goal, Positions start, std::optional<std::string> method, std::uint64_t seed,
             double budget, double clearance) {
            const PlanQuery query{std::move(goal), std::move(start), std::move(method), seed, budget, clearance};
            return run_interruptibly(std::stop_token(),
                                     [&](const std::stop_token& stop) { return self->plan(query, stop); });
          },
          py::arg("goal"), py::arg("start"), py::arg("method"), py::arg("seed"), py::arg("budget"),
          py::arg("clearance"))
      .def(
          "simulate",
          [](const Shared& self, int tasks, std::uint64_t seed, int threads) {
            const planner::BatchReport report = run_interruptibly(std::stop_token(), [&](const std::stop_token& stop) {
              return self->simulate(tasks, seed, threads, stop);
            });
            return report_of(self->cell(), report);
          },
          py::arg("tasks"), py::arg("seed"), py::arg("threads"));
}

}  // namespace

void bind_offline(py::module_& module) {
  py::class_<PlanAnswer>(module, "PlanAnswer", "The answer of the global planner.")
      .def_readonly("arms", &PlanAnswer::arms, "planned arms, in the order of the cell file")
      .def_property_readonly(
          "status", [](const PlanAnswer& answer) { return name_of(answer.plan.status); },
          "solved, start_invalid, goal_invalid, budget_ended or stuck")
      .def_property_readonly(
          "reason", [](const PlanAnswer& answer) { return answer.plan.reason; }, "one sentence if not solved")
      .def_property_readonly("path", &path_of, "an array (points, joints) for each planned arm [rad | m]")
      .def_property_readonly(
          "length", [](const PlanAnswer& answer) { return answer.plan.length; }, "in joint space [rad | m]")
      .def_property_readonly(
          "duration",
          [](const PlanAnswer& answer) { return answer.trajectory.empty() ? 0.0 : answer.trajectory.duration(); },
          "of the trajectory along the path [s]")
      .def_readonly("clearance", &PlanAnswer::clearance, "smallest distance on the path, without links of one arm [m]")
      .def(
          "trajectory", [](const PlanAnswer& answer, const Number& period) { return trajectory_of(answer, period); },
          py::arg("period") = Number{0.01},
          "Times (T,), and for each planned arm positions and velocities, arrays (T, joints).")
      .def("__bool__", [](const PlanAnswer& answer) { return answer.plan.solved(); })
      .def("__repr__", &representation);

  py::class_<CellModel, Shared> model(module, "CellModel", "A loaded cell file.");
  model
      .def_static(
          "load",
          [](const std::string& path) {
            return run_interruptibly(std::stop_token(),
                                     [&](const std::stop_token&) { return std::make_shared<CellModel>(path); });
          },
          py::arg("path"))
      .def_property_readonly("name", [](const CellModel& self) { return self.cell().name; })
      .def_property_readonly("arms", [](const CellModel& self) { return planner::names_of(self.cell()); })
      .def_property_readonly("obstacles",
                             [](const CellModel& self) {
                               std::vector<std::string> names;
                               for (const auto& obstacle : self.cell().scene.obstacles) names.push_back(obstacle.name);
                               return names;
                             })
      .def("check",
           [](const Shared& self) {
             const auto findings =
                 run_interruptibly(std::stop_token(), [&](const std::stop_token&) { return self->check(); });
             py::list list;
             for (const config::Finding& finding : findings) {
               list.append(py::make_tuple(config::name_of(finding.severity), finding.sentence));
             }
             return list;
           })
      .def(
          "joint_names",
          [](const CellModel& self, const std::string& arm) { return self.arm(arm).arm.model->joint_names; },
          py::arg("arm"))
      .def(
          "limits", [](const CellModel& self, const std::string& arm) { return limits_of(self.arm(arm).arm.limits); },
          py::arg("arm"))
      .def(
          "poses",
          [](const CellModel& self, const std::string& arm) {
            py::dict poses;
            for (const auto& [name, q] : self.arm(arm).arm.named) poses[py::str(name)] = array_of_joints(q);
            return poses;
          },
          py::arg("arm"))
      .def(
          "start", [](const CellModel& self, const std::string& arm) { return array_of_joints(self.start(arm)); },
          py::arg("arm"));
  bind_kinematics(model);
  bind_plans(model);
}

}  // namespace hecaton::python
