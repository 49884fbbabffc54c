/// Python classes of the values in <hecaton/types.hpp>.

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <Eigen/Geometry>
#include <hecaton/client.hpp>

#include "services/python/bindings.hpp"
#include "services/python/casters.hpp"
#include "services/runtime/options.hpp"

namespace hecaton::python {
namespace {

/// "Sphere(radius=0.1)"
std::string representation(const py::object& self) {
  std::string text = py::str(py::type::of(self).attr("__name__"));
  std::string separator = "(";
  for (const py::handle name : self.attr("_fields")) {
    text += separator + std::string(py::str(name)) + "=" + std::string(py::repr(self.attr(name)));
    separator = ", ";
  }
  return text + ")";
}

/// Values of one class with equal fields, all of which are numbers or arrays of them.
py::object equal(const py::object& self, const py::object& other) {
  if (!py::type::of(self).is(py::type::of(other))) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
  const py::object array_equal = py::module_::import("numpy").attr("array_equal");
  for (const py::handle name : self.attr("_fields")) {
    if (!array_equal(self.attr(name), other.attr(name)).cast<bool>()) return py::bool_(false);
  }
  return py::bool_(true);
}

/// The same for equal values.
py::ssize_t hash_of(const py::object& self) {
  const py::object as_array = py::module_::import("numpy").attr("asarray");
  py::list parts;
  parts.append(py::type::of(self));
  for (const py::handle name : self.attr("_fields")) {
    // −0 becomes 0.
    parts.append((as_array(self.attr(name), "float64") + py::float_(0.0)).attr("tobytes")());
  }
  return py::hash(py::tuple(parts));
}

/// A class whose objects are constant. Its `_fields` name what its representation shows.
template <class T>
class Value : public py::class_<T> {
 public:
  Value(py::module_& module, const char* name, const char* doc) : py::class_<T>(module, name, doc) {
    this->attr("_fields") = fields_;
    this->def("__repr__", &representation);
  }
  template <class Member>
  Value& field(const char* name, Member T::*member, const char* doc) {
    this->def_readonly(name, member, doc);
    fields_.append(name);
    return *this;
  }
  template <class Get>
  Value& computed(const char* name, Get get, const char* doc) {
    this->def_property_readonly(name, get, doc);
    fields_.append(name);
    return *this;
  }
  /// Objects can be pickled, copied and compared. The constructor takes the fields in their order.
  Value& picklable() {
    this->def("__eq__", &equal);
    this->def("__hash__", &hash_of);
    this->def("__reduce__", [](const py::object& self) {
      py::list values;
      for (const py::handle name : self.attr("_fields")) values.append(self.attr(name));
      return py::make_tuple(py::type::of(self), py::tuple(values));
    });
    return *this;
  }

 private:
  py::list fields_;
};

/// None instead of a cause without a reason.
std::optional<Cause> if_any(const Cause& cause) {
  return cause ? std::optional(cause) : std::nullopt;
}

std::string name_of(OutcomeKind kind) {
  switch (kind) {
    case OutcomeKind::kReached:
      return "reached";
    case OutcomeKind::kRejected:
      return "rejected";
    case OutcomeKind::kCancelled:
      return "cancelled";
    case OutcomeKind::kReplaced:
      return "replaced";
    case OutcomeKind::kTimedOut:
      return "timed_out";
    case OutcomeKind::kBlocked:
      return "blocked";
    case OutcomeKind::kActive:
      return "active";
    case OutcomeKind::kUnanswered:
      return "unanswered";
    case OutcomeKind::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// `numbers` as an array of two dimensions and `columns`. Throws InvalidArgument with `must_be`.
Array matrix_in(const py::object& numbers, py::ssize_t columns, const std::string& must_be) {
  Array matrix = Array::ensure(numbers);
  if (!matrix) PyErr_Clear();
  if (!matrix || matrix.ndim() != 2 || matrix.shape(1) != columns) throw InvalidArgument(must_be);
  return matrix;
}

/// Throws InvalidArgument with the name of a number that is not finite.
void require_finite(std::initializer_list<std::pair<const char*, double>> named) {
  for (const auto& [name, value] : named) {
    if (std::isfinite(value)) continue;
    throw InvalidArgument(std::string(name) + " = " + quoted(py::float_(value)) + " must be a finite number");
  }
}

Pose pose_of_matrix(const py::object& numbers) {
  const Array matrix = matrix_in(numbers, 4, "a pose matrix must have the shape (4, 4)");
  if (matrix.shape(0) != 4) throw InvalidArgument("a pose matrix must have the shape (4, 4)");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> X(matrix.data());
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  constexpr double kTolerance = 1e-6;
  if (!((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < kTolerance && R.determinant() > 0.0)) {
    throw InvalidArgument("the upper left 3 × 3 block of a pose matrix must be a rotation");
  }
  if (!((X.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).norm() < kTolerance)) {
    throw InvalidArgument("the last row of a pose matrix must be 0 0 0 1");
  }
  require_finite({{"matrix[0, 3]", X(0, 3)}, {"matrix[1, 3]", X(1, 3)}, {"matrix[2, 3]", X(2, 3)}});
  const Eigen::Quaterniond rotation(R);
  return {{X(0, 3), X(1, 3), X(2, 3)}, {rotation.w(), rotation.x(), rotation.y(), rotation.z()}};
}

py::array_t<double> matrix_of(const Pose& pose) {
  py::array_t<double> matrix({4, 4});
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> X(matrix.mutable_data());
  X.setIdentity();
  X.topLeftCorner<3, 3>() =
      Eigen::Quaterniond(pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]).toRotationMatrix();
  X.topRightCorner<3, 1>() << pose.position.x, pose.position.y, pose.position.z;
  return matrix;
}

Pose make_pose(const Vector3& position, const py::object& rotation) {
  require_finite({{"position[0]", position.x}, {"position[1]", position.y}, {"position[2]", position.z}});
  const auto numbers = numbers_in(rotation);
  std::array<double, 4> wxyz{};
  double squared = 0.0;
  if (numbers && numbers->size() == wxyz.size()) {
    std::copy(numbers->begin(), numbers->end(), wxyz.begin());
    for (const double number : wxyz) squared += number * number;
  }
  constexpr double kTolerance = 1e-6;
  if (!(std::abs(squared - 1.0) < kTolerance)) {
    throw InvalidArgument("rotation = " + quoted(rotation) + " must be a unit quaternion (w, x, y, z)");
  }
  return {position, wxyz};
}

Pose pose_xyz(const Number& x, const Number& y, const Number& z) {
  require_finite({{"x", x}, {"y", y}, {"z", z}});
  return Pose::xyz(x, y, z);
}

Pose pose_xyz_rpy(const Number& x, const Number& y, const Number& z, const Number& roll, const Number& pitch,
                  const Number& yaw) {
  require_finite({{"x", x}, {"y", y}, {"z", z}, {"roll", roll}, {"pitch", pitch}, {"yaw", yaw}});
  return Pose::xyz_rpy(x, y, z, roll, pitch, yaw);
}

/// `source`: an array, or a mesh whose `vertices` are one, such as that of trimesh.
std::vector<Vector3> points_in(const py::object& source) {
  const py::object numbers = py::hasattr(source, "vertices") ? py::object(source.attr("vertices")) : source;
  const Array points = matrix_in(numbers, 3, "points must be an array of shape (N, 3), or a mesh with such vertices");
  std::vector<Vector3> found;
  const auto rows = points.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) found.push_back({rows(i, 0), rows(i, 1), rows(i, 2)});
  return found;
}

ConvexHull hull_of(const py::object& source) {
  return {points_in(source)};
}
Points cloud_of(const py::object& source, const Number& radius) {
  return {points_in(source), radius};
}

template <class OfPoints>
py::array_t<double> points_of(const OfPoints& shape) {
  py::array_t<double> points({static_cast<py::ssize_t>(shape.points.size()), py::ssize_t{3}});
  auto rows = points.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const Vector3& point = shape.points[static_cast<std::size_t>(i)];
    rows(i, 0) = point.x;
    rows(i, 1) = point.y;
    rows(i, 2) = point.z;
  }
  return points;
}

void bind_pose(py::module_& module) {
  Value<Pose>(module, "Pose", "Pose of a frame, in the frame W of the cell unless stated otherwise.")
      .field("position", &Pose::position, "x, y, z [m], a NumPy array")
      .computed(
          "rotation", [](const Pose& pose) { return array_of(pose.rotation); },
          "unit quaternion w, x, y, z, a NumPy array")
      .picklable()
      .def(py::init(&make_pose), py::arg("position") = Vector3{},
           py::arg("rotation") = py::make_tuple(1.0, 0.0, 0.0, 0.0),
           "A pose from x, y, z [m] and a unit quaternion w, x, y, z.")
      .def_static("xyz", &pose_xyz, py::arg("x"), py::arg("y"), py::arg("z"), "A pose without rotation [m].")
      .def_static("xyz_rpy", &pose_xyz_rpy, py::arg("x"), py::arg("y"), py::arg("z"), py::arg("roll"), py::arg("pitch"),
                  py::arg("yaw"),
                  "Roll, pitch and yaw [rad] are rotations about the fixed axes x, y, z, in this order, as in URDF.")
      .def_static("from_matrix", &pose_of_matrix, py::arg("matrix"), "A pose from a homogeneous 4 × 4 matrix.")
      .def_property_readonly("matrix", &matrix_of, "homogeneous 4 × 4 matrix, a NumPy array");
}

void bind_shapes(py::module_& module) {
  Value<Box>(module, "Box", "A cuboid, centred at the origin of the obstacle.")
      .field("x", &Box::x, "full size along x [m]")
      .field("y", &Box::y, "full size along y [m]")
      .field("z", &Box::z, "full size along z [m]")
      .picklable()
      .def(py::init([](const Number& x, const Number& y, const Number& z) {
             return Box{x, y, z};
           }),
           py::arg("x"), py::arg("y"), py::arg("z"));
  Value<Sphere>(module, "Sphere", "A ball.")
      .field("radius", &Sphere::radius, "[m]")
      .picklable()
      .def(py::init([](const Number& radius) { return Sphere{radius}; }), py::arg("radius"));
  Value<Cylinder>(module, "Cylinder", "A cylinder about z.")
      .field("radius", &Cylinder::radius, "[m]")
      .field("height", &Cylinder::height, "[m]")
      .picklable()
      .def(py::init([](const Number& radius, const Number& height) {
             return Cylinder{radius, height};
           }),
           py::arg("radius"), py::arg("height"));
  Value<Capsule>(module, "Capsule", "A cylinder about z with a half ball at each end.")
      .field("radius", &Capsule::radius, "[m]")
      .field("length", &Capsule::length, "between the centres of the caps [m]")
      .picklable()
      .def(py::init([](const Number& radius, const Number& length) {
             return Capsule{radius, length};
           }),
           py::arg("radius"), py::arg("length"));
  Value<ConvexHull>(module, "ConvexHull",
                    "The convex hull of points. A hull of more than 64 vertices becomes one of 64 that encloses it.")
      .computed("points", &points_of<ConvexHull>, "in the obstacle's frame, shape (N, 3) [m]")
      .picklable()
      .def(py::init(&hull_of), py::arg("points"),
           "The hull of an array of shape (N, 3) [m], or of a mesh with such an array `vertices`, such as one of "
           "trimesh.");
  Value<Points>(module, "Points",
                "Balls of one radius about points, such as a depth camera sees. No arm can carry them, and they cannot "
                "fall.")
      .computed("points", &points_of<Points>, "in the obstacle's frame, shape (N, 3) [m]")
      .field("radius", &Points::radius, "of each ball [m]")
      .picklable()
      .def(py::init(&cloud_of), py::arg("points"), py::arg("radius"),
           "Balls about an array of 1 to 100,000 points, of shape (N, 3) [m]; kept in single precision.");
}

void bind_motions(py::module_& module) {
  Value<Static>(module, "Static", "Stays where it is.").picklable().def(py::init());
  Value<Conveyor>(module, "Conveyor", "Moves along a straight line; repeats from the beginning after `length`.")
      .field("velocity", &Conveyor::velocity, "in W [m/s]")
      .field("length", &Conveyor::length, "[m]")
      .picklable()
      .def(py::init([](const Vector3& velocity, const Number& length) {
             return Conveyor{velocity, length};
           }),
           py::arg("velocity"), py::arg("length"));
  Value<Sine>(module, "Sine", "Sinusoidal motion along a line.")
      .field("amplitude", &Sine::amplitude, "in W [m]")
      .field("period", &Sine::period, "of one oscillation [s]")
      .picklable()
      .def(py::init([](const Vector3& amplitude, Seconds period) {
             return Sine{amplitude, period};
           }),
           py::arg("amplitude"), py::arg("period"));
  Value<Circle>(module, "Circle", "Moves on a circle about an axis along z of W.")
      .field("centre", &Circle::centre, "in W [m]")
      .field("angular_speed", &Circle::angular_speed, "[rad/s]")
      .picklable()
      .def(py::init([](const Vector3& centre, const Number& angular_speed) {
             return Circle{centre, angular_speed};
           }),
           py::arg("centre"), py::arg("angular_speed"));
  Value<Dynamic>(module, "Dynamic", "A rigid body that falls and is pushed.")
      .field("mass", &Dynamic::mass, "[kg]")
      .picklable()
      .def(py::init([](const Number& mass) { return Dynamic{mass}; }), py::arg("mass"));
}

void bind_progress(py::module_& module) {
  Value<Cause>(module, "Cause", "The reason of a state, a fault or a rejection. Programs evaluate kind and subject.")
      .field("kind", &Cause::kind, "a word, such as 'path_blocked'")
      .field("subject", &Cause::subject, "name of a node, host, arm, obstacle, joint or link; empty: none")
      .field("text", &Cause::text, "one sentence for people")
      .def("__str__", [](const Cause& cause) { return cause.text; });
  Value<Binding>(module, "Binding", "The pair of bodies whose distance limits the motion.")
      .field("own", &Binding::own, "'north/forearm'")
      .field("other", &Binding::other, "'west/wrist' or 'pallet'")
      .field("distance", &Binding::distance, "[m]");
  Value<ToolError>(module, "ToolError", "How far the measured tool frame is from a pose goal.")
      .field("position", &ToolError::position, "[m]")
      .field("orientation", &ToolError::orientation, "without the free rotation [rad]");
  Value<NearestPose>(module, "NearestPose",
                     "What the arm can do at the position of a goal rejected for its orientation.")
      .field("pose", &NearestPose::pose, "of the tool frame in W")
      .field("angle", &NearestPose::angle, "from the orientation of the goal, without the free rotation [rad]");
  Value<Progress>(module, "Progress", "Progress of a goal, as the planner of the arm reports it.")
      .field("arm", &Progress::arm, "name in the cell file")
      .field("goal", &Progress::goal, "identifier, unique among the goals of the arm")
      .field("state", &Progress::state,
             "accepted, active, blocked, reached, rejected, cancelled, replaced or timed_out")
      .computed(
          "cause", [](const Progress& progress) { return if_any(progress.cause); },
          "why it is blocked, or why it ended unreached; None: no reason")
      .field("binding", &Progress::binding, "limits the motion now; None: no pair")
      .field("recovery_action", &Progress::recovery_action, "of the planner while the arm is blocked, for people")
      .field("blocked_duration", &Progress::blocked_duration, "since the arm last moved freely [s]")
      .field("distance", &Progress::distance, "from the goal in joint space [rad | m]")
      .field("elapsed", &Progress::elapsed, "since the planner accepted the goal [s]")
      .computed(
          "q_goal", [](const Progress& progress) { return array_of(progress.q_goal); },
          "target joint positions, a NumPy array; empty until they are known; on an active trajectory those of half a "
          "second later [rad | m]")
      .field("planner", &Progress::planner, "node that reports the progress")
      .field("note", &Progress::note, "what the planner changed in the goal, for people; empty: nothing")
      .field("tool_error", &Progress::tool_error, "measured; None: no pose goal, or not measured yet")
      .field("nearest", &Progress::nearest, "with the cause 'goal_orientation'")
      .field("trajectory_time", &Progress::trajectory_time,
             "in its trajectory that the arm has come to [s]; None: it has no trajectory")
      .field("trajectory_rate", &Progress::trajectory_rate,
             "of that time: 1 as the trajectory demands, 0 while the arm waits")
      .field("age", &Progress::age, "since this progress arrived; in a CellStatus 0 [s]")
      .def_property_readonly(
          "ended", [](const Progress& progress) { return is_final(progress.state); }, "the state is the last one");
  Value<Outcome>(module, "Outcome", "How a goal stands at the end of a wait. True if the goal was reached.")
      .computed(
          "kind", [](const Outcome& outcome) { return name_of(outcome.kind); },
          "reached, rejected, cancelled, replaced, timed_out; or blocked, active, unanswered: the goal continues")
      .computed(
          "cause", [](const Outcome& outcome) { return if_any(outcome.cause()); },
          "of the newest progress; None: no reason")
      .field("progress", &Outcome::progress, "the newest; None: no planner has answered")
      .def_property_readonly(
          "ended",
          [](const Outcome& outcome) {
            return outcome.kind != OutcomeKind::kInterrupted && outcome.progress && is_final(outcome.progress->state);
          },
          "the goal has ended")
      .def("__bool__", [](const Outcome& outcome) { return static_cast<bool>(outcome); })
      .def("__str__", &Outcome::text);
}

void bind_states(py::module_& module) {
  Value<ArmState>(module, "ArmState", "The state of an arm as its driver measured it.")
      .field("mode", &ArmState::mode, "of its driver")
      .computed(
          "cause", [](const ArmState& state) { return if_any(state.cause); },
          "why it brakes or does not follow commands; None: no reason")
      .computed(
          "q", [](const ArmState& state) { return array_of(state.q); },
          "joint positions from base to tip, a NumPy array [rad | m]")
      .computed(
          "qd", [](const ArmState& state) { return array_of(state.qd); },
          "joint velocities, a NumPy array [rad/s | m/s]")
      .field("carried", &ArmState::carried, "names of the objects attached to the tool")
      .field("age", &ArmState::age, "since the state was received [s]; in a CellStatus: by the supervisor");
  Value<Signal>(module, "Signal", "A signal of an arm's device.")
      .field("name", &Signal::name, "in the cell file")
      .field("kind", &Signal::kind, "digital_input, digital_output, analog_input or analog_output")
      .field("value", &Signal::value, "as the device reports it; None: it has not reported any");
  Value<ToolState>(module, "ToolState", "Gripper and signals of an arm.")
      .field("has_gripper", &ToolState::has_gripper, "False: the next three mean nothing")
      .field("moving", &ToolState::moving, "the gripper opens or closes")
      .field("width", &ToolState::width, "of its opening [m]; None: not known")
      .computed(
          "holding",
          [](const ToolState& state) {
            return state.holding.empty() ? std::nullopt : std::optional<std::string>(state.holding);
          },
          "obstacle that it holds; None: none")
      .field("signals", &ToolState::signals, "in the order of their names")
      .field("age", &ToolState::age, "since the state was received [s]");
  Value<ObstacleState>(module, "ObstacleState", "The state of an obstacle as the world service publishes it.")
      .field("name", &ObstacleState::name, "unique in the cell")
      .field("pose", &ObstacleState::pose, "in W")
      .field("velocity", &ObstacleState::velocity, "of the frame's origin, in W, a NumPy array [m/s]")
      .field("attached_to", &ObstacleState::attached_to, "arm that carries it; None: no arm")
      .field("age", &ObstacleState::age, "since the state was received [s]");
  Value<Receipt>(module, "Receipt", "The result of an order or an edit that was carried out.")
      .field("edition", &Receipt::edition, "number of edits of the scene so far; 0 for an order")
      .computed(
          "warning", [](const Receipt& receipt) { return if_any(receipt.warning); },
          "set when the process that carried it out would lose it by a restart");
  Value<SavedRecording>(module, "SavedRecording", "What a recorder has saved.")
      .field("host", &SavedRecording::host, "of the recorder: its name in the cell file, else that of the machine")
      .field("file", &SavedRecording::file, "the newest one, on that host");
}

void bind_status(py::module_& module) {
  Value<Fault>(module, "Fault", "A fault that the supervisor has detected.")
      .field("id", &Fault::id, "unique for each occurrence")
      .field("severity", &Fault::severity, "of the fault")
      .field("cause", &Fault::cause, "kind, faulty component, and a sentence")
      .field("cleared", &Fault::cleared, "the cause has ended");
  Value<ContactReport>(module, "ContactReport", "Contacts and separations since the cell was started.")
      .field("contacts", &ContactReport::contacts, "number of contacts that began")
      .field("smallest", &ContactReport::smallest, "the smallest separation; None: no pair was checked");
  Value<ArmStatus>(module, "ArmStatus", "The status of an arm as its supervisor reports it.")
      .field("name", &ArmStatus::name, "in the cell file")
      .field("mode", &ArmStatus::mode, "run, hold or stop: the stricter of cell and arm")
      .field("speed", &ArmStatus::speed, "speed override in force: the lower of the cell's and the arm's own")
      .field("driver_alive", &ArmStatus::driver_alive, "heartbeats of its driver arrive")
      .field("planner_alive", &ArmStatus::planner_alive, "heartbeats of the planner in charge arrive")
      .field("state", &ArmStatus::state, "None: the supervisor has received none")
      .field("goal", &ArmStatus::goal, "the newest; None: none")
      .computed(
          "waiting_for", [](const ArmStatus& status) { return if_any(status.waiting_for); },
          "why the arm waits; None while it moves");
  Value<NodeStatus>(module, "NodeStatus", "The status of a process of the cell.")
      .field("name", &NodeStatus::name, "unique in the cell")
      .field("kind", &NodeStatus::kind, "what it does")
      .field("state", &NodeStatus::state, "as its heartbeats say")
      .field("host", &NodeStatus::host, "on which it runs")
      .field("alive", &NodeStatus::alive, "its heartbeats arrive")
      .computed(
          "cause", [](const NodeStatus& status) { return if_any(status.cause); },
          "why it is degraded or has failed; None: it is not")
      .field("age", &NodeStatus::age, "since the supervisor received its last heartbeat [s]; negative: none received");
  Value<CellStatus>(module, "CellStatus", "The status of a cell as its supervisor reports it.")
      .field("cell", &CellStatus::cell, "name in the cell file")
      .field("mode", &CellStatus::mode, "run, hold or stop")
      .computed(
          "cause", [](const CellStatus& status) { return if_any(status.cause); }, "why the mode is not run")
      .field("speed", &CellStatus::speed, "speed override of the cell, 0.01 to 1")
      .field("held_arms", &CellStatus::held_arms, "by name or by a fault")
      .field("stopped_arms", &CellStatus::stopped_arms, "by name")
      .field("supervisor", &CellStatus::supervisor, "node that leads")
      .field("standby", &CellStatus::standby, "node that is ready to take over; None: none")
      .field("arms", &CellStatus::arms, "all arms of the cell")
      .field("nodes", &CellStatus::nodes, "all processes of the cell")
      .field("faults", &CellStatus::faults, "present faults, then the latest cleared ones")
      .field("contacts", &CellStatus::contacts, "None: the supervisor has received none");
}

template <class Enum>
py::tuple words() {
  py::list words;
  constexpr std::uint32_t kMost = 256;
  for (std::uint32_t i = 0; i < kMost; ++i) {
    const auto word = name_of(static_cast<Enum>(i));
    if (word == "unknown") break;
    words.append(std::string(word));
  }
  return py::tuple(words);
}

}  // namespace

void bind_values(py::module_& module) {
  bind_pose(module);
  bind_shapes(module);
  bind_motions(module);
  bind_progress(module);
  bind_states(module);
  bind_status(module);
  module.attr("CAUSE_KINDS") = words<CauseKind>();
  module.attr("GOAL_STATES") = words<GoalState>();
  module.attr("ARM_MODES") = words<ArmMode>();
  module.attr("CELL_MODES") = words<CellMode>();
  module.attr("FREE_ROTATIONS") = words<FreeRotation>();
  module.attr("NODE_KINDS") = words<NodeKind>();
  module.attr("NODE_STATES") = words<NodeState>();
  module.attr("SEVERITIES") = words<Severity>();
  module.attr("HIGHEST_DOMAIN") = services::kHighestDomain;
}

}  // namespace hecaton::python
