/// Session and NativeGoal as classes of `_hecaton`.

#include <limits>

#include "services/python/bindings.hpp"
#include "services/python/casters.hpp"
#include "services/python/session.hpp"

namespace hecaton::python {
namespace {

using Limit = std::optional<double>;

/// None: no limit.
Seconds limit_of(const Limit& timeout) {
  return timeout ? Seconds(*timeout) : kForever;
}

/// Sends a goal to a named pose, joint positions or a pose of the tool.
NativeGoal send(const std::shared_ptr<Session>& session, const std::string& arm, const py::object& target,
                const GoalOptions& options) {
  if (py::isinstance<py::str>(target)) {
    const auto named = target.cast<std::string>();
    return {session, session->send(arm, [&](const Arm& handle) { return handle.go_to(named, options); })};
  }
  if (py::isinstance<Pose>(target)) {
    const auto pose = target.cast<Pose>();
    return {session, session->send(arm, [&](const Arm& handle) { return handle.go_to(pose, options); })};
  }
  const auto q = numbers_in(target);
  if (!q) {
    throw InvalidArgument(
        "a goal must be the name of a pose, a sequence or one-dimensional array of joint positions, "
        "or a hecaton.Pose");
  }
  return {session, session->send(arm, [&](const Arm& handle) { return handle.go_to(*q, options); })};
}

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A trajectory of arrays with a row for each time. Their shapes and numbers are checked in Python.
Trajectory trajectory_of(const Array& times, const Array& positions, const std::optional<Array>& velocities,
                         const std::optional<Array>& accelerations, const std::optional<Array>& path_tolerance) {
  Trajectory trajectory;
  const auto row = [](const Array& matrix, py::ssize_t i) {
    return std::vector<double>(matrix.data(i, 0), matrix.data(i, 0) + matrix.shape(1));
  };
  for (py::ssize_t i = 0; i < times.size(); ++i) {
    TrajectoryPoint& point = trajectory.points.emplace_back();
    point.time = Seconds(times.at(i));
    point.q = row(positions, i);
    if (velocities) point.qd = row(*velocities, i);
    if (accelerations) point.qdd = row(*accelerations, i);
  }
  if (path_tolerance)
    trajectory.path_tolerance.assign(path_tolerance->data(), path_tolerance->data() + path_tolerance->size());
  return trajectory;
}

enum class Order { kHold, kResume, kStop };

Receipt give(Session& session, Order order, const std::vector<std::string>& arms, const Limit& timeout) {
  return session.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
    switch (order) {
      case Order::kHold:
        return cell.hold(arms, wait);
      case Order::kResume:
        return cell.resume(arms, wait);
      case Order::kStop:
        return cell.stop(arms, wait);
    }
    return Receipt{};
  });
}

void bind_edits(py::class_<Session, std::shared_ptr<Session>>& session) {
  session
      .def(
          "add",
          [](Session& self, const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion,
             const Limit& timeout) {
            return self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              return cell.world().add(name, shape, pose, motion, wait);
            });
          },
          py::arg("name"), py::arg("shape"), py::arg("pose"), py::arg("motion"), py::arg("timeout"))
      .def(
          "replace",
          [](Session& self, const std::string& name, const Shape& shape, const Pose& pose, const Motion& motion,
             const Limit& timeout) {
            return self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              return cell.world().replace(name, shape, pose, motion, wait);
            });
          },
          py::arg("name"), py::arg("shape"), py::arg("pose"), py::arg("motion"), py::arg("timeout"))
      .def(
          "move",
          [](Session& self, const std::string& name, const Pose& pose, const Limit& timeout) {
            return self.call(limit_of(timeout),
                             [&](const Cell& cell, const Wait& wait) { return cell.world().move(name, pose, wait); });
          },
          py::arg("name"), py::arg("pose"), py::arg("timeout"))
      .def(
          "remove",
          [](Session& self, const std::string& name, const Limit& timeout) {
            return self.call(limit_of(timeout),
                             [&](const Cell& cell, const Wait& wait) { return cell.world().remove(name, wait); });
          },
          py::arg("name"), py::arg("timeout"))
      .def(
          "attach",
          [](Session& self, const std::string& arm, const std::string& object, const Limit& timeout) {
            return self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              return cell.world().attach(arm, object, wait);
            });
          },
          py::arg("arm"), py::arg("object"), py::arg("timeout"))
      .def(
          "detach",
          [](Session& self, const std::string& arm, const std::string& object, const Limit& timeout) {
            return self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              return cell.world().detach(arm, object, wait);
            });
          },
          py::arg("arm"), py::arg("object"), py::arg("timeout"))
      .def(
          "obstacles",
          [](Session& self, const Limit& timeout) {
            return self.look(limit_of(timeout),
                             [](const Cell& cell, const Wait& wait) { return cell.world().obstacles(wait); });
          },
          py::arg("timeout"));
}

void bind_tools(py::class_<Session, std::shared_ptr<Session>>& session) {
  session
      .def(
          "tool_state",
          [](Session& self, const std::string& arm, const Limit& timeout) {
            return self.look(limit_of(timeout),
                             [&](const Cell& cell, const Wait& wait) { return cell.arm(arm).tool(wait); });
          },
          py::arg("arm"), py::arg("timeout"))
      .def(
          "grip",
          [](Session& self, const std::string& arm, bool close, std::optional<double> width,
             std::optional<double> force, const Limit& timeout) {
            self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              const GripOptions options{width, force};
              close ? cell.arm(arm).close_gripper(options, wait) : cell.arm(arm).open_gripper(options, wait);
              return Receipt{};
            });
          },
          py::arg("arm"), py::arg("close"), py::arg("width"), py::arg("force"), py::arg("timeout"))
      .def(
          "set_signal",
          [](Session& self, const std::string& arm, const std::string& name, double value, const Limit& timeout) {
            self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              cell.arm(arm).set_signal(name, value, wait);
              return Receipt{};
            });
          },
          py::arg("arm"), py::arg("name"), py::arg("value"), py::arg("timeout"))
      .def(
          "wait_for_signal",
          [](Session& self, const std::string& arm, const std::string& name, double lowest, double highest,
             const Limit& timeout) {
            return self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              return cell.arm(arm).wait_for_signal(name, lowest, highest, wait);
            });
          },
          py::arg("arm"), py::arg("name"), py::arg("lowest"), py::arg("highest"), py::arg("timeout"))
      .def(
          "place_joint",
          [](Session& self, const std::string& arm, const std::string& joint, double position, const Limit& timeout) {
            self.call(limit_of(timeout), [&](const Cell& cell, const Wait& wait) {
              cell.arm(arm).place_joint(joint, position, wait);
              return Receipt{};
            });
          },
          py::arg("arm"), py::arg("joint"), py::arg("position"), py::arg("timeout"));
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<NativeGoal>(module, "NativeGoal", "A sent goal.")
      .def_property_readonly("id", &NativeGoal::id)
      .def(
          "wait",
          [](const NativeGoal& goal, const Limit& timeout) {
            return goal.session().wait(goal.id(), limit_of(timeout));
          },
          py::arg("timeout"))
      .def("progress", [](const NativeGoal& goal) { return goal.session().progress(goal.id()); })
      .def("cancel", [](const NativeGoal& goal) { goal.session().cancel(goal.id()); })
      .def("watch", [](const NativeGoal& goal) { goal.session().watch(goal.id()); });

  py::class_<Session, std::shared_ptr<Session>> session(module, "Session", "A connection to a running cell.");
  session
      .def_static(
          "connect",
          [](std::optional<std::string> cell_file, std::optional<int> domain, const Limit& timeout) {
            return Session::connect({std::move(cell_file), domain}, limit_of(timeout));
          },
          py::arg("cell_file"), py::arg("domain"), py::arg("timeout"))
      .def(
          "require_arm",
          [](Session& self, const std::string& name, const Limit& timeout) {
            self.require_arm(name, limit_of(timeout));
          },
          py::arg("name"), py::arg("timeout"))
      .def(
          "go_to",
          [](const std::shared_ptr<Session>& self, const std::string& arm, const py::object& target,
             const Limit& time_limit, FreeRotation free_rotation, double position_tolerance,
             double orientation_tolerance) {
            GoalOptions options;
            options.time_limit = limit_of(time_limit);
            options.free_rotation = free_rotation;
            options.position_tolerance = position_tolerance;
            options.orientation_tolerance = orientation_tolerance;
            return send(self, arm, target, options);
          },
          py::arg("arm"), py::arg("target"), py::arg("time_limit"), py::arg("free_rotation"),
          py::arg("position_tolerance"), py::arg("orientation_tolerance"))
      .def(
          "follow",
          [](const std::shared_ptr<Session>& self, const std::string& arm, const Array& times, const Array& positions,
             const std::optional<Array>& velocities, const std::optional<Array>& accelerations,
             const std::optional<Array>& path_tolerance, const Limit& time_limit) {
            const Trajectory trajectory = trajectory_of(times, positions, velocities, accelerations, path_tolerance);
            GoalOptions options;
            options.time_limit = limit_of(time_limit);
            return NativeGoal(self,
                              self->send(arm, [&](const Arm& handle) { return handle.follow(trajectory, options); }));
          },
          py::arg("arm"), py::arg("times"), py::arg("positions"), py::arg("velocities"), py::arg("accelerations"),
          py::arg("path_tolerance"), py::arg("time_limit"))
      .def(
          "arm_state",
          [](Session& self, const std::string& arm, const Limit& timeout) {
            return self.look(limit_of(timeout),
                             [&](const Cell& cell, const Wait& wait) { return cell.arm(arm).state(wait); });
          },
          py::arg("arm"), py::arg("timeout"))
      .def(
          "newest_goal",
          [](Session& self, const std::string& arm) {
            return self.look(Seconds::zero(), [&](const Cell& cell, const Wait&) { return cell.arm(arm).goal(); });
          },
          py::arg("arm"))
      .def(
          "status",
          [](Session& self, const Limit& timeout) {
            return self.call(limit_of(timeout), [](const Cell& cell, const Wait& wait) { return cell.status(wait); });
          },
          py::arg("timeout"))
      .def(
          "hold",
          [](Session& self, const std::vector<std::string>& arms, const Limit& timeout) {
            return give(self, Order::kHold, arms, timeout);
          },
          py::arg("arms"), py::arg("timeout"))
      .def(
          "resume",
          [](Session& self, const std::vector<std::string>& arms, const Limit& timeout) {
            return give(self, Order::kResume, arms, timeout);
          },
          py::arg("arms"), py::arg("timeout"))
      .def(
          "stop",
          [](Session& self, const std::vector<std::string>& arms, const Limit& timeout) {
            return give(self, Order::kStop, arms, timeout);
          },
          py::arg("arms"), py::arg("timeout"))
      .def(
          "set_speed",
          [](Session& self, double speed, const std::vector<std::string>& arms, const Limit& timeout) {
            return self.call(limit_of(timeout),
                             [&](const Cell& cell, const Wait& wait) { return cell.set_speed(speed, arms, wait); });
          },
          py::arg("speed"), py::arg("arms"), py::arg("timeout"))
      .def(
          "save_recordings",
          [](Session& self, const Limit& timeout) {
            return self.call(limit_of(timeout),
                             [](const Cell& cell, const Wait& wait) { return cell.save_recordings(wait); });
          },
          py::arg("timeout"))
      .def("faults", &Session::faults)
      .def("watch_faults", &Session::watch_faults)
      .def("next_event", &Session::next_event)
      .def("close", &Session::close)
      .def_property_readonly("closed", &Session::closed)
      .def_property_readonly("arms", &Session::arms);
  bind_edits(session);
  bind_tools(session);
}

}  // namespace hecaton::python
