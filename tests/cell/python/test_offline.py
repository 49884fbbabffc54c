"""The package `hecaton` without a network."""

import copy
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

import hecaton
from live_cell import CELLS, THREE_PUMA


class Load(unittest.TestCase):
    def test_names_arms_joints_limits_and_poses(self):
        cell = hecaton.load(THREE_PUMA)
        self.assertEqual(cell.name, "three_puma")
        self.assertEqual([arm.name for arm in cell.arms], ["north", "west", "east"])
        self.assertEqual(cell.obstacles, ["ball", "shuttle", "post"])
        north = cell.arm("north")
        self.assertEqual(len(north.joint_names), 6)
        np.testing.assert_allclose(north.limits.velocity, 1.5)
        np.testing.assert_allclose(north.poses["home"], [0, -1.9, 2.6, 0, 0.6, 0])
        np.testing.assert_allclose(north.start, north.poses["home"])

    def test_invalid_file_raises_with_key(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "cell.yaml"
            file.write_text("name: broken\narms: 3\n")
            with self.assertRaises(hecaton.InvalidArgument) as raised:
                hecaton.load(file)
        self.assertEqual(raised.exception.kind, "invalid_cell_file")
        self.assertIn("arms", str(raised.exception))

    def test_robots_by_name_are_found_beside_the_package(self):
        environment = {name: value for name, value in os.environ.items() if name != "HECATON_ROBOTS"}
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "cell.yaml"
            file.write_text("name: test\narms:\n  - {name: left, robot: ur3e}\n")
            program = "import hecaton, sys; print(len(hecaton.load(sys.argv[1]).arm('left').joint_names))"
            done = subprocess.run([sys.executable, "-c", program, file], cwd=folder, env=environment, capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("6\n", ""))

    def test_check_returns_findings(self):
        findings = hecaton.load(THREE_PUMA).check()
        self.assertFalse([finding for finding in findings if finding.severity == "error"])


class Pickle(unittest.TestCase):
    """What goes to a worker process and back."""

    def test_values_that_a_program_makes_can_be_pickled_and_copied(self):
        pose = hecaton.Pose.xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3)
        values = [pose, hecaton.Box(1, 2, 3), hecaton.Sphere(0.1), hecaton.Cylinder(0.1, 2), hecaton.Capsule(0.1, 2),
                  hecaton.ConvexHull(np.random.default_rng(1).random((9, 3))), hecaton.Points(np.ones((4, 3)), 0.01),
                  hecaton.Static(), hecaton.Conveyor([1, 0, 0], 2), hecaton.Sine([0, 1, 0], 3), hecaton.Circle([0, 0, 1], 0.5),
                  hecaton.Dynamic(2)]
        for value in values:
            for other in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
                self.assertEqual(repr(other), repr(value))
                self.assertIs(type(other), type(value))
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(pose)).matrix, pose.matrix)

    def test_equal_values_are_equal_and_have_one_hash(self):
        self.assertEqual(hecaton.Pose.xyz(1, 2, 3), hecaton.Pose((1, 2, 3)))
        self.assertNotEqual(hecaton.Pose.xyz(1, 2, 3), hecaton.Pose.xyz(1, 2, 4))
        self.assertNotEqual(hecaton.Box(1, 2, 3), (1, 2, 3))
        self.assertNotEqual(hecaton.Sphere(1), hecaton.Dynamic(1))
        self.assertEqual(hecaton.ConvexHull(np.eye(3)), hecaton.ConvexHull(np.eye(3).tolist()))
        self.assertNotEqual(hecaton.ConvexHull(np.eye(3)), hecaton.ConvexHull(np.eye(4, 3)))
        self.assertEqual(len({hecaton.Pose.xyz(0, 2, 3), hecaton.Pose.xyz(-0.0, 2, 3), hecaton.Static(), hecaton.Static()}), 2)

    def test_exceptions_keep_text_kind_and_subject(self):
        for kind in (hecaton.Error, hecaton.Rejected, hecaton.GoalFailed, hecaton.WaitTimeout):
            other = pickle.loads(pickle.dumps(kind("in the way", "goal_in_collision", "post")))
            self.assertIs(type(other), kind)
            self.assertEqual((str(other), other.kind, other.subject), ("in the way", "goal_in_collision", "post"))


class Kinematics(unittest.TestCase):
    def test_turning_the_first_joint_turns_the_tool_about_the_base(self):
        # Both joints of the planar arm turn about z: q1 = π/2 turns (x, y) into (−y, x) about the base.
        arm = hecaton.load(CELLS / "planar_2r.yaml").arms[0]
        base = next(iter(arm.links([0.0, 0.0]).values())).position
        x, y, z = arm.forward([0.0, 0.0]).position - base
        self.assertGreater(np.hypot(x, y), 0.1)
        np.testing.assert_allclose(arm.forward([np.pi / 2, 0.0]).position - base, [-y, x, z], atol=1e-9)

    def test_jacobian_is_the_derivative_of_forward_kinematics(self):
        north = hecaton.load(THREE_PUMA).arm("north")
        q, h = north.poses["ready"], 1e-6
        J = north.jacobian(q)
        self.assertEqual(J.shape, (6, 6))
        for i in range(6):
            step = np.zeros(6)
            step[i] = h
            derivative = (north.forward(q + step).position - north.forward(q - step).position) / (2 * h)
            np.testing.assert_allclose(J[3:, i], derivative, atol=1e-7)

    def test_inverse_kinematics_returns_to_the_pose(self):
        north = hecaton.load(THREE_PUMA).arm("north")
        pose = north.forward("ready")
        q = north.inverse(pose)
        found = north.forward(q)
        np.testing.assert_allclose(found.position, pose.position, atol=2e-4)
        self.assertGreater(abs(found.rotation @ pose.rotation), 1 - 1e-6)
        self.assertTrue(np.all(q >= north.limits.lower) and np.all(q <= north.limits.upper))
        self.assertIsNone(north.inverse(hecaton.Pose.xyz(9, 9, 9)))

    def test_ctrl_c_ends_a_long_search(self):
        program = ("import hecaton, signal, sys\n"
                   "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
                   "arm = hecaton.load(sys.argv[1]).arm('north')\n"
                   "print('searching', flush=True)\n"
                   "try:\n"
                   "    arm.inverse(hecaton.Pose.xyz(9, 9, 9), seeds=2**31 - 1)\n"
                   "except KeyboardInterrupt:\n"
                   "    print('interrupted', flush=True)\n")
        process = subprocess.Popen([sys.executable, "-c", program, str(THREE_PUMA)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.assertEqual(process.stdout.readline(), "searching\n")
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual((out, process.returncode), ("interrupted\n", 0), err)

    def test_wrong_number_of_joints_raises(self):
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.load(THREE_PUMA).arm("north").forward([0.0, 1.0])
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.load(THREE_PUMA).arm("north").forward("nowhere")
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.load(THREE_PUMA).arm("south")

    def test_pose_matrix_round_trip(self):
        pose = hecaton.Pose.xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3)
        again = hecaton.Pose.from_matrix(pose.matrix)
        np.testing.assert_allclose(again.position, [1, 2, 3])
        np.testing.assert_allclose(again.rotation, pose.rotation, atol=1e-12)
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.Pose.from_matrix(2 * np.eye(4))
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.Pose((0, 0, 0), (1, 1, 0, 0))


class Meshes(unittest.TestCase):
    def test_hull_takes_an_array_or_a_mesh(self):
        class Mesh:  # as those of trimesh
            vertices = np.random.default_rng(1).normal(size=(40, 3))
            faces = np.zeros((2, 3), dtype=int)

        np.testing.assert_array_equal(hecaton.ConvexHull(Mesh()).points, Mesh.vertices)
        np.testing.assert_array_equal(hecaton.ConvexHull(Mesh.vertices.tolist()).points, Mesh.vertices)


class Refusals(unittest.TestCase):
    """A wrong argument is one sentence with its name, its value and what is allowed."""

    def setUp(self):
        self.cell = hecaton.load(CELLS / "planar_2r.yaml")
        self.arm = self.cell.arms[0]

    def refused(self, sentence, call, *arguments, **keywords):
        with self.assertRaises(hecaton.InvalidArgument) as raised:
            call(*arguments, **keywords)
        self.assertEqual(str(raised.exception), sentence)

    def test_names_what_is_wrong_in_a_plan(self):
        goal = {self.arm.name: "home"}
        self.refused("budget = 0 must be a number above 0 [s]", self.cell.plan, goal, budget=0)
        self.refused("budget = nan must be a number above 0 [s]", self.cell.plan, goal, budget=float("nan"))
        self.refused("clearance = -1 must be a finite number of at least 0 [m]", self.cell.plan, goal, clearance=-1)
        self.refused("seed = -1 must be a whole number from 0 to 18446744073709551615", self.cell.plan, goal, seed=-1)
        self.refused("method = 3 must be a str", self.cell.plan, goal, method=3)
        self.refused('goal = \'home\' must be a dict of joint positions by arm, such as {"north": "ready"}',
                     self.cell.plan, "home")
        plan = self.cell.plan({self.arm.name: self.arm.start})
        self.refused("period = inf must be a finite number above 0 [s]", plan.trajectory, float("inf"))
        self.refused("period = 0 must be a finite number above 0 [s]", plan.trajectory, 0)
        self.refused("'fine' must be a number", plan.trajectory, "fine")

    def test_names_what_is_wrong_in_a_simulation(self):
        self.refused("tasks = 0 must be a whole number from 1 to 2147483647", self.cell.simulate, 0)
        self.refused("tasks = 2.5 must be a whole number from 1 to 2147483647", self.cell.simulate, 2.5)
        self.refused("threads = 0 must be a whole number from 1 to 2147483647", self.cell.simulate, 1, threads=0)

    def test_names_what_is_wrong_in_kinematics(self):
        must_be = "must be the name of a pose, or a sequence of joint positions"
        self.refused(f"joint positions of arm {self.arm.name} = ['a', 'b'] {must_be}", self.arm.forward, ["a", "b"])
        self.refused(f"joint positions of arm {self.arm.name} = 3 {must_be}", self.arm.forward, 3)
        self.refused("pose = (1, 2, 3) must be a hecaton.Pose", self.arm.inverse, (1, 2, 3))
        self.refused("free_rotation = 'rol' must be none, roll, pitch, yaw or all", self.arm.inverse, hecaton.Pose(),
                     free_rotation="rol")

    def test_names_what_is_wrong_in_a_pose_or_a_shape(self):
        self.refused("'a' must be a number", hecaton.Box, 1, "a", 2)
        self.refused("None must be a number", hecaton.Pose.xyz, 1, 2, None)
        self.refused("'s' must be a number", hecaton.Sine, (0, 0, 1), "s")
        self.refused("(1, 2) must be three numbers, such as [0.1, 0, 0.5]", hecaton.Pose, (1, 2))
        self.refused("rotation = 'x' must be a unit quaternion (w, x, y, z)", hecaton.Pose, rotation="x")
        self.refused("a pose matrix must have the shape (4, 4)", hecaton.Pose.from_matrix, "x")
        self.refused("points must be an array of shape (N, 3), or a mesh with such vertices", hecaton.ConvexHull, None)

    def test_poses_are_finite_and_rigid(self):
        nan, inf = float("nan"), float("inf")
        self.refused("x = nan must be a finite number", hecaton.Pose.xyz, nan, 0, 0)
        self.refused("z = -inf must be a finite number", hecaton.Pose.xyz, 0, 0, -inf)
        self.refused("yaw = nan must be a finite number", hecaton.Pose.xyz_rpy, 0, 0, 0, 0, 0, nan)
        self.refused("position[1] = inf must be a finite number", hecaton.Pose, (0, inf, 0))
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.Pose((0, 0, 0), (nan, 0, 0, 0))
        for row, column, sentence in ((0, 3, "matrix[0, 3] = nan must be a finite number"),
                                      (1, 1, "the upper left 3 × 3 block of a pose matrix must be a rotation"),
                                      (3, 0, "the last row of a pose matrix must be 0 0 0 1")):
            matrix = np.eye(4)
            matrix[row, column] = nan
            self.refused(sentence, hecaton.Pose.from_matrix, matrix)
        matrix = np.eye(4)
        matrix[3, 3] = 2
        self.refused("the last row of a pose matrix must be 0 0 0 1", hecaton.Pose.from_matrix, matrix)

    def test_names_the_allowed_domains(self):
        self.refused("domain = 500 must be a whole number from 0 to 199", hecaton.connect, domain=500)
        self.refused("domain = '42' must be a whole number from 0 to 199", hecaton.connect, domain="42")
        self.refused("timeout = 'long' must be a number of seconds, or None for no limit", hecaton.connect, domain=42,
                     timeout="long")

    def test_unknown_arm_has_kind_and_subject(self):
        with self.assertRaises(hecaton.InvalidArgument) as raised:
            self.cell.arm("nort")
        self.assertEqual((raised.exception.kind, raised.exception.subject), ("unknown_name", "nort"))
        self.assertIn(self.arm.name, str(raised.exception))


class Planning(unittest.TestCase):
    def test_nearest_pair_names_bodies(self):
        cell = hecaton.load(THREE_PUMA)
        nearest = cell.nearest()
        self.assertGreater(nearest.distance, 0)
        self.assertIn("/", nearest.a)

    def test_plan_joins_start_and_goal_within_velocity_limits(self):
        cell = hecaton.load(THREE_PUMA)
        plan = cell.plan({"north": "ready", "west": "ready"})
        self.assertTrue(plan, plan.reason)
        self.assertEqual(plan.arms, ["north", "west"])
        for name in plan.arms:
            arm = cell.arm(name)
            np.testing.assert_allclose(plan.path[name][0], arm.start)
            np.testing.assert_allclose(plan.path[name][-1], arm.poses["ready"])
        times, q, qd = plan.trajectory(0.01)
        self.assertEqual(q["north"].shape, (len(times), 6))
        self.assertLessEqual(np.abs(qd["north"]).max(), 1.5 + 1e-6)
        self.assertAlmostEqual(times[-1], plan.duration)
        self.assertGreater(plan.clearance, 0)

    def test_goal_in_collision_is_no_plan(self):
        cell = hecaton.load(THREE_PUMA)
        plan = cell.plan({"north": np.array([0, 0.9, 0.0, 0, 0, 0])})
        self.assertFalse(plan)
        self.assertEqual(plan.status, "goal_invalid")
        self.assertNotEqual(plan.reason, "")
        with self.assertRaises(hecaton.InvalidArgument):
            cell.plan({"north": "ready"}, method="magic")

    def test_results_say_what_they_are_when_printed(self):
        cell = hecaton.load(THREE_PUMA)
        self.assertEqual(repr(cell), "<hecaton.CellFile three_puma: arms north, west, east; obstacles ball, shuttle, post>")
        self.assertEqual(repr(cell.arm("west")), "<hecaton.ArmModel west: 6 joints; poses home, ready>")
        plan = cell.plan({"north": "ready", "west": "ready"})
        self.assertRegex(repr(plan), rf"^<hecaton\.PlanAnswer solved: north, west; {len(plan.path['north'])} points, "
                                     r"[\d.]+ s, length [\d.]+, clearance [\d.]+ m>$")
        failed = cell.plan({"north": np.array([0, 0.9, 0.0, 0, 0, 0])})
        self.assertEqual(str(failed), f"<hecaton.PlanAnswer goal_invalid: {failed.reason}>")
        report = hecaton.load(CELLS / "planar_2r.yaml").simulate(4)
        self.assertIn(f"reach_times=<{len(report.reach_times)} times>, smallest={report.smallest!r}", repr(report))
        self.assertIn(f"SimulationReport(tasks={report.tasks}, reached={report.reached}, ", repr(report))
        self.assertEqual(repr(hecaton.Pose.xyz(1, 2, 3)),
                         "Pose(position=array([1., 2., 3.]), rotation=array([1., 0., 0., 0.]))")

    def test_simulation_repeats_itself(self):
        cell = hecaton.load(CELLS / "planar_2r.yaml")
        first, second = cell.simulate(4, seed=3), cell.simulate(4, seed=3)
        self.assertGreaterEqual(first.tasks, 4)
        self.assertEqual(first.contacts, 0)
        np.testing.assert_array_equal(first.reach_times, second.reach_times)


if __name__ == "__main__":
    unittest.main()
