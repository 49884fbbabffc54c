"""The package `hecaton` against a running cell."""

import asyncio
import gc
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import hecaton
from live_cell import BIN, LiveCell, gripper_cell

LONG = 120  # of a goal on a slow machine [s]


def program(text, case, *arguments):
    """A Python program that connects to the cell; the caller has to wait for it."""
    environment = dict(os.environ, HECATON_DOMAIN=str(case.domain.number))
    return subprocess.Popen([sys.executable, "-c", text, str(case.file), *arguments], env=environment,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def resident():
    """Resident memory of this process [kB]."""
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


class Gripper(LiveCell):
    @classmethod
    def cell_file(cls, folder):
        return gripper_cell(folder)

    def test_closes_on_what_is_between_the_fingers_and_releases_it(self):
        north = self.cell.arm("north")
        north.tool.open()
        self.assertTrue(north.go_to("crate").wait(LONG))
        north.tool.close(force=20)
        state = north.tool.state()
        self.assertTrue(state.has_gripper)
        self.assertEqual(state.holding, "crate")
        self.assertAlmostEqual(state.width, 0.04, delta=2e-3)
        self.assertEqual([each.name for each in self.cell.world.obstacles() if each.attached_to == "north"], ["crate"])
        north.tool.open(width=0.09)
        self.assertIsNone(north.tool.state().holding)
        with self.assertRaises(hecaton.Rejected) as raised:
            north.tool.open(width=0.5)
        self.assertEqual((raised.exception.kind, raised.exception.subject), ("invalid_value", "width"))
        with self.assertRaises(hecaton.InvalidArgument):
            north.tool.close(force=-1)

    def test_reads_sets_and_awaits_signals(self):
        io = self.cell.arm("north").io
        io.set("lamp", 1)
        self.assertTrue(io.wait("lamp", 1, timeout=LONG))
        self.assertEqual(io.get("lamp"), 1.0)
        self.assertFalse(io.wait("part", 1, timeout=0.2))
        io.set("pressure", 2.7)
        self.assertTrue(io.wait("pressure", above=2.5, timeout=LONG))
        self.assertFalse(io.wait("pressure", below=2.5, timeout=0.2))
        for order in (lambda: io.get("horn"), lambda: io.set("horn", 1), lambda: io.wait("horn", 1)):
            with self.assertRaises(hecaton.Rejected) as raised:
                order()
            self.assertEqual((raised.exception.kind, raised.exception.subject), ("unknown_name", "horn"))
        for wrong in ({}, {"value": 1, "above": 0}):
            with self.assertRaises(hecaton.InvalidArgument):
                io.wait("lamp", **wrong)

    def test_places_a_joint_without_a_gripper(self):
        south = self.cell.arm("south")
        south.posture({"grip": 0.02})
        with self.assertRaises(hecaton.Rejected) as raised:
            south.posture({"grip": 0.2})
        self.assertEqual(raised.exception.subject, "grip")
        with self.assertRaises(hecaton.Unreachable):
            south.tool.state(timeout=1)


class Goals(LiveCell):
    def tearDown(self):
        self.cell.resume()
        self.home()

    def test_reaches_named_pose_joints_and_tool_pose(self):
        north = self.cell.arm("north")
        self.assertTrue(north.go_to("ready").wait(LONG))
        q = north.state().q
        self.assertEqual(q.shape, (6,))
        self.assertEqual(q.dtype, np.float64)
        target = q + np.array([0.1, 0, 0, 0, 0, 0])
        outcome = north.go_to(target, time_limit=60).wait(LONG)
        self.assertEqual(outcome.kind, "reached")
        np.testing.assert_allclose(outcome.progress.q_goal, target, atol=1e-9)
        np.testing.assert_allclose(north.state().q, target, atol=0.02)
        tool = hecaton.load(self.file).arm("north").forward(q)
        outcome = north.go_to(tool, position_tolerance=0.002).wait(LONG)
        self.assertLess(outcome.progress.tool_error.position, 0.002)

    def test_rejected_goal_raises_with_kind_and_subject(self):
        with self.assertRaises(hecaton.GoalFailed) as raised:
            self.cell.arm("north").go_to("nowhere").wait(LONG)
        self.assertEqual(raised.exception.kind, "unknown_name")
        self.assertEqual(raised.exception.outcome.kind, "rejected")
        with self.assertRaises(hecaton.GoalFailed) as raised:
            self.cell.arm("north").go_to([9.0, -1.9, 2.6, 0, 0.6, 0]).wait(LONG)
        self.assertEqual(raised.exception.kind, "goal_outside_limits")
        self.assertNotEqual(raised.exception.subject, "")
        self.assertFalse(self.cell.arm("north").go_to("nowhere").wait(LONG, check=False))

    def test_goal_in_collision_raises_that_kind(self):
        ready = self.cell.arm("north").go_to("ready").wait(LONG).progress.q_goal
        tool = hecaton.load(self.file).arm("north").forward(ready)
        self.home()
        self.cell.world.add("block", hecaton.Sphere(0.08), hecaton.Pose(tool.position))
        try:
            with self.assertRaises(hecaton.GoalFailed) as raised:
                self.cell.arm("north").go_to("ready").wait(LONG)
            self.assertEqual((raised.exception.kind, raised.exception.subject), ("goal_in_collision", "block"))
        finally:
            self.cell.world.remove("block")

    def test_wait_without_time_raises_wait_timeout_and_goal_continues(self):
        goal = self.cell.arm("north").go_to("ready")
        with self.assertRaises(hecaton.WaitTimeout):
            goal.wait(0)
        self.assertTrue(goal.wait(LONG))

    def test_cancelled_and_replaced_goals_say_so(self):
        first = self.cell.arm("north").go_to("ready")
        second = self.cell.arm("north").go_to("ready")
        self.assertEqual(first.wait(LONG, check=False).kind, "replaced")
        second.cancel()
        with self.assertRaises(hecaton.GoalFailed) as raised:
            second.wait(LONG)
        self.assertEqual(raised.exception.kind, "goal_cancelled")

    def test_callback_and_iterator_end_with_the_last_progress(self):
        seen, ended = [], threading.Event()

        def note(progress):
            seen.append(progress.state)
            if progress.ended:
                ended.set()

        goal = self.cell.arm("north").go_to("ready", time_limit=LONG)
        goal.on_progress(note)
        states = [progress.state for progress in goal.updates()]
        self.assertEqual(states[-1], "reached")
        self.assertTrue(ended.wait(LONG))
        self.assertEqual(seen[-1], "reached")

    def test_gather_awaits_three_arms(self):
        async def all_ready():
            arms = self.cell.arms()
            return await asyncio.gather(*(arm.go_to("ready", time_limit=LONG) for arm in arms))

        outcomes = asyncio.run(all_ready())
        self.assertEqual([outcome.kind for outcome in outcomes], ["reached"] * 3)
        self.assertEqual([outcome.progress.arm for outcome in outcomes], ["north", "west", "east"])

    def test_await_raises_for_rejected_goal_and_iterates(self):
        async def run():
            with self.assertRaises(hecaton.GoalFailed) as raised:
                await asyncio.wait_for(self.cell.arm("west").go_to("nowhere"), LONG)
            self.assertEqual(raised.exception.kind, "unknown_name")
            with self.assertRaises(hecaton.WaitTimeout):
                await self.cell.arm("west").go_to("ready").ended(0)
            return [progress.state async for progress in self.cell.arm("north").go_to("ready", time_limit=LONG)]

        self.assertEqual(asyncio.run(run())[-1], "reached")

    def planned(self, arm, pose, period=0.1):
        """Times, positions and velocities of a planned trajectory from where the arms are to a pose."""
        start = {each.name: each.state().q for each in self.cell.arms()}
        plan = hecaton.load(self.file).plan({arm: pose}, start)
        self.assertTrue(plan, plan.reason)
        times, positions, velocities = plan.trajectory(period)
        return times, positions[arm], velocities[arm]

    def test_follows_a_planned_trajectory_in_its_time(self):
        north = self.cell.arm("north")
        times, positions, velocities = self.planned("north", "ready")
        times *= 2.0  # slower, so that other arms and limits do not matter
        begun = time.monotonic()
        goal = north.follow(times, positions, velocities / 2.0, path_tolerance=0.2, time_limit=LONG)
        progress = [each for each in goal.updates()]
        took = time.monotonic() - begun
        self.assertEqual(progress[-1].state, "reached")
        self.assertGreaterEqual(took, times[-1])
        self.assertLess(took, times[-1] + 2.0)
        at = [each.trajectory_time for each in progress if each.trajectory_time is not None]
        self.assertEqual(at, sorted(at))
        self.assertGreater(len(set(at)), 5)
        self.assertAlmostEqual(max(each.trajectory_rate for each in progress), 1.0, delta=0.05)
        np.testing.assert_allclose(north.state().q, positions[-1], atol=0.02)
        self.assertIsNone(north.go_to("ready").wait(LONG).progress.trajectory_time)

    def test_gather_awaits_trajectories_of_two_arms(self):
        async def both():
            goals = []
            for name in ("north", "west"):
                arm = self.cell.arm(name)
                q = arm.state().q
                ramp = [q, q + np.array([0.1, 0, 0, 0, 0, 0])]
                goals.append(arm.follow([0, 1], ramp, time_limit=LONG))  # lists do as well
            return await asyncio.gather(*goals)

        self.assertEqual([outcome.kind for outcome in asyncio.run(both())], ["reached"] * 2)

    def test_trajectory_is_cancelled_rejected_and_replaced(self):
        north = self.cell.arm("north")
        q = north.state().q
        far = q + np.array([0.4, 0, 0, 0, 0, 0])
        goal = north.follow([0, 20], [q, far])
        self.assertTrue(any((each.trajectory_time or 0.0) > 0.2 for each in goal.updates()))
        goal.cancel()
        self.assertEqual(goal.wait(LONG, check=False).kind, "cancelled")
        q = north.state().q
        first = north.follow([0, 20], [q, far])
        self.assertTrue(north.follow([1], [q]).wait(LONG))  # begins where the arm is
        self.assertEqual(first.wait(LONG, check=False).kind, "replaced")
        with self.assertRaises(hecaton.GoalFailed) as raised:
            north.follow([0, 20], [q + 0.2, far]).wait(LONG)
        self.assertEqual(raised.exception.kind, "goal_malformed")
        self.assertIn("begins 0.2", str(raised.exception))

    def test_wrong_trajectories_are_one_sentence(self):
        north, two = self.cell.arm("north"), np.zeros((2, 6))
        for sentence, call in (
                ("times has the shape (3,), but must have the shape (2,)", lambda: north.follow([0, 1, 2], two)),
                ("times[1] = 1.0 must be above times[0] = 1.0 [s]", lambda: north.follow([1, 1], two)),
                ("times[0] = -1.0 must be 0 or above [s]", lambda: north.follow([-1, 1], two)),
                ("times = 'soon' must be a number for each point [s]", lambda: north.follow("soon", two)),
                ("positions has the shape (2,), but must have a row for each point and a column for each joint",
                 lambda: north.follow([0, 1], [0, 1])),
                ("positions[1][0] = nan must be a finite number", lambda: north.follow([0, 1], [[0], [np.nan]])),
                ("velocities has the shape (6,), but must have the shape (2, 6)",
                 lambda: north.follow([0, 1], two, np.zeros(6))),
                ("path_tolerance has the shape (2,), but must have the shape (6,)",
                 lambda: north.follow([0, 1], two, path_tolerance=[1, 1])),
                ("path_tolerance[0] = -1.0 must be 0 (none) or above [rad | m]",
                 lambda: north.follow([0, 1], two, path_tolerance=-1))):
            with self.assertRaises(hecaton.InvalidArgument) as raised:
                call()
            self.assertEqual(str(raised.exception), sentence)

    def test_hold_keeps_the_goal_and_resume_continues_it(self):
        self.cell.hold()
        self.assertEqual(self.cell.status().mode, "hold")
        goal = self.cell.arm("north").go_to("ready")
        self.assertFalse(goal.wait(1, check=False).ended)
        self.cell.resume()
        self.assertTrue(goal.wait(LONG))
        self.cell.arm("north").stop()
        self.assertIn("north", self.cell.status().stopped_arms)
        self.cell.arm("north").resume()
        self.assertEqual(self.cell.status().stopped_arms, [])

    def test_set_speed_slows_the_cell_and_arms(self):
        self.addCleanup(self.cell.set_speed, 1.0)
        self.addCleanup(self.cell.arm("north").set_speed, 1.0)
        self.cell.set_speed(0.5)
        self.cell.arm("north").set_speed(0.3)
        status = self.cell.status()
        self.assertEqual(status.speed, 0.5)
        self.assertEqual({arm.name: arm.speed for arm in status.arms}["north"], 0.3)
        self.cell.set_speed(0.2, ["north"])
        self.assertTrue(self.cell.arm("north").go_to("home").wait(LONG))
        for bad in (0.0, 0.001, 30, float("nan")):
            with self.assertRaises(hecaton.InvalidArgument):
                self.cell.set_speed(bad)
        self.assertEqual(self.cell.status().speed, 0.5)

    def test_save_recordings_orders_the_recorders(self):
        with self.assertRaises(hecaton.Unreachable):
            self.cell.save_recordings(timeout=0.2)
        with tempfile.TemporaryDirectory() as folder, subprocess.Popen(
                [BIN / "hecaton", "record", self.file, "-o", f"{folder}/run.mcap", "--keep", "10s", "--domain",
                 str(self.domain.number)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as recorder:
            self.assertIn("recording cell", recorder.stderr.readline())
            saved = self.cell.save_recordings(timeout=LONG)
            recorder.send_signal(signal.SIGINT)
            recorder.communicate()
        self.assertEqual(len(saved), 1)
        self.assertRegex(saved[0].file, r"/run-\d{4}\.mcap$")
        self.assertTrue(saved[0].host)

    def test_empty_selection_is_no_order_for_the_whole_cell(self):
        with self.assertRaises(hecaton.InvalidArgument):
            self.cell.hold([])
        self.assertEqual(self.cell.status().mode, "run")
        with self.assertRaises(hecaton.Rejected) as raised:
            self.cell.hold("south")
        self.assertEqual((raised.exception.kind, raised.exception.subject), ("unknown_name", "south"))


    def test_wrong_arguments_are_one_sentence(self):
        north, world = self.cell.arm("north"), self.cell.world
        no_goal = ("a goal must be the name of a pose, a sequence or one-dimensional array of joint positions, or a "
                   "hecaton.Pose")
        for sentence, call in (
                ("time_limit = 'a' must be a number of seconds, or None for no limit",
                 lambda: north.go_to("home", time_limit="a")),
                ("free_rotation = 'rol' must be none, roll, pitch, yaw or all",
                 lambda: north.go_to("home", free_rotation="rol")),
                ("position_tolerance = nan must be a finite number",
                 lambda: north.go_to("home", position_tolerance=float("nan"))),
                ("timeout = nan must be a number of seconds, or None for no limit", lambda: north.state(float("nan"))),
                ("'post' is followed by a NUL, which ends a text of DDS", lambda: world.remove("post\0er")),
                ("'home' is followed by a NUL, which ends a text of DDS", lambda: north.go_to("home\0")),
                (no_goal, lambda: north.go_to(["0"] * 6)),
                (no_goal, lambda: north.go_to([True] * 6)),
                (no_goal, lambda: north.go_to(np.zeros(6, dtype=complex))),
                ("name = 3 must be a str", lambda: self.cell.arm(3)),
                ("arms = 5 must be a list of names", lambda: self.cell.hold(5)),
                ("shape = 0.1 must be a hecaton.Box, hecaton.Sphere, hecaton.Cylinder, hecaton.Capsule, "
                 "hecaton.ConvexHull or hecaton.Points", lambda: world.add("ball", 0.1, hecaton.Pose())),
                ("pose = (1, 2, 3) must be a hecaton.Pose", lambda: world.move("post", (1, 2, 3))),
                ("callback = 3 must be a function", lambda: self.cell.on_fault(3))):
            with self.assertRaises(hecaton.InvalidArgument) as raised:
                call()
            self.assertEqual(str(raised.exception), sentence)


class Obstacles(LiveCell):
    def test_shapes_appear_move_and_disappear(self):
        world = self.cell.world
        corners = np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)])
        shapes = {"box": hecaton.Box(0.1, 0.2, 0.1), "sphere": hecaton.Sphere(0.1), "post2": hecaton.Cylinder(0.05, 0.3),
                  "capsule": hecaton.Capsule(0.05, 0.2), "hull": hecaton.ConvexHull(corners)}
        for i, (name, shape) in enumerate(shapes.items()):
            world.add(name, shape, hecaton.Pose.xyz(3.0, 0.5 * i, 0.5))
        self.wait_for(lambda states: set(shapes) <= set(states))
        world.move("hull", hecaton.Pose.xyz_rpy(3.0, -2.0, 0.5, 0, 0, 1.0))
        self.wait_for(lambda states: abs(states["hull"].pose.position[1] + 2.0) < 1e-9)
        for name in shapes:
            world.remove(name)
        self.wait_for(lambda states: not set(shapes) & set(states))

    def test_mesh_of_many_vertices_is_accepted(self):
        directions = np.random.default_rng(1).normal(size=(500, 3))
        ball = 0.1 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self.cell.world.add("mesh", hecaton.ConvexHull(ball), hecaton.Pose.xyz(3, 3, 1), timeout=LONG)
        self.wait_for(lambda states: "mesh" in states)
        self.cell.world.remove("mesh", timeout=LONG)

    def test_largest_cloud_of_points_appears_and_must_be_clear_of_the_arms(self):
        world = self.cell.world
        points = np.random.default_rng(1).uniform(-0.5, 0.5, size=(100_000, 3))
        world.add("scan", hecaton.Points(points, 0.01), hecaton.Pose.xyz(4, 4, 1), timeout=LONG)
        self.wait_for(lambda states: "scan" in states)
        north = self.cell.arm("north")
        tool = hecaton.load(self.file).arm("north").forward(north.state().q)
        with self.assertRaises(hecaton.Rejected) as raised:
            world.move("scan", tool, timeout=LONG)
        self.assertIn("must be clear of the arms", str(raised.exception))
        with self.assertRaises(hecaton.Rejected) as raised:
            world.attach("north", "scan", timeout=LONG)
        self.assertIn("points", str(raised.exception))
        self.assertTrue(north.go_to("home").wait(LONG))
        world.remove("scan", timeout=LONG)
        self.wait_for(lambda states: "scan" not in states)
        for bad in (points[:0], np.vstack([points, points[:1]]), [[0, 0, float("nan")]]):
            with self.assertRaises(hecaton.InvalidArgument):
                world.add("scan", hecaton.Points(bad, 0.01), hecaton.Pose.xyz(4, 4, 1))

    def test_replaced_obstacle_is_never_absent(self):
        world = self.cell.world
        edition = world.replace("tray", hecaton.Sphere(0.1), hecaton.Pose.xyz(3, 3, 1), timeout=LONG).edition
        self.assertEqual(world.replace("tray", hecaton.Box(0.1, 0.1, 0.1), hecaton.Pose.xyz(3, 3, 2)).edition, edition + 1)
        self.wait_for(lambda states: abs(states["tray"].pose.position[2] - 2) < 1e-9)
        with self.assertRaises(hecaton.Rejected):
            world.replace("north", hecaton.Sphere(0.1), hecaton.Pose.xyz(3, 3, 3))
        world.remove("tray")

    def test_rejected_edit_raises_and_changes_nothing(self):
        with self.assertRaises(hecaton.Rejected) as raised:
            self.cell.world.add("post", hecaton.Sphere(0.1), hecaton.Pose.xyz(3, 3, 3))
        self.assertEqual((raised.exception.kind, raised.exception.subject), ("name_taken", "post"))
        with self.assertRaises(hecaton.Rejected):
            self.cell.world.remove("missing")
        with self.assertRaises(hecaton.InvalidArgument):
            self.cell.world.add("flat", hecaton.ConvexHull(np.zeros((8, 3))), hecaton.Pose.xyz(3, 3, 3))
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.ConvexHull(np.zeros((8, 2)))

    def test_attached_obstacle_is_carried_and_detached(self):
        tool = hecaton.load(self.file).arm("north").forward(self.cell.arm("north").state().q)
        self.cell.world.add("part", hecaton.Box(0.03, 0.03, 0.03),
                            hecaton.Pose.from_matrix(tool.matrix @ hecaton.Pose.xyz(0, 0, 0.06).matrix))
        self.cell.world.attach("north", "part")
        self.wait_for(lambda states: states["part"].attached_to == "north")
        self.cell.world.detach("north", "part")
        self.wait_for(lambda states: states["part"].attached_to is None)
        self.cell.world.remove("part")

    def wait_for(self, condition):
        """Each state is newer than the last one; a missing state would end the test by its time limit."""
        end = time.monotonic() + 60
        while not condition({state.name: state for state in self.cell.world.obstacles()}):
            self.assertLess(time.monotonic(), end, "the obstacles never became as expected")
            self.cell.status()


class Connections(LiveCell):
    def test_status_names_arms_nodes_and_no_faults(self):
        status = self.cell.status()
        self.assertEqual(status.cell, "three_puma")
        self.assertEqual([arm.name for arm in status.arms], ["north", "west", "east"])
        self.assertTrue(all(node.alive for node in status.nodes))
        self.assertEqual([fault for fault in self.cell.faults() if not fault.cleared], [])

    def test_handles_say_what_they_are_when_printed(self):
        with hecaton.connect(self.file, domain=self.domain.number, timeout=60) as cell:
            goal = cell.arm("north").go_to("home")
            goal.wait(LONG)
            self.assertEqual(repr(goal), f"<hecaton.Goal {goal.id} of arm north: reached>")
            self.assertEqual(repr(cell), "<hecaton.Cell with arms north, west, east>")
            self.assertEqual(repr(cell.world), f"<hecaton.World of {cell!r}>")
            self.assertEqual(repr(cell.arm("west")), "<hecaton.Arm west>")
        self.assertEqual(repr(cell), "<hecaton.Cell (closed)>")
        self.assertEqual(repr(goal), f"<hecaton.Goal {goal.id} of arm north>")

    def test_unreachable_cell_raises(self):
        with self.assertRaises(hecaton.Unreachable) as raised:
            hecaton.connect(domain=self.domain.number + 100 if self.domain.number < 100 else 199, timeout=0.5)
        self.assertEqual(raised.exception.kind, "unreachable")
        with self.assertRaises(hecaton.InvalidArgument):
            hecaton.connect("missing.yaml")

    def test_unknown_arm_raises_with_all_names(self):
        with hecaton.connect(domain=self.domain.number, timeout=60) as by_domain:
            for cell in (self.cell, by_domain):
                with self.assertRaises(hecaton.InvalidArgument) as raised:
                    cell.arm("nort")
                self.assertEqual(str(raised.exception), "'nort' is no arm of the cell; its arms are north, west, east")
                self.assertEqual((raised.exception.kind, raised.exception.subject), ("unknown_name", "nort"))
                self.assertEqual(cell.arm("north").name, "north")

    def test_session_of_the_parent_is_refused_after_fork(self):
        process = program("import hecaton, os, sys, threading\n"
                          "cell = hecaton.connect(sys.argv[1], timeout=60)\n"
                          "goal = cell.arm('north').go_to('home')\n"
                          "goal.on_progress(lambda progress: None)\n"
                          "child = os.fork()\n"
                          "if child == 0:\n"
                          "    for call in (cell.status, lambda: cell.arm('north'), goal.wait, cell.world.obstacles):\n"
                          "        try:\n"
                          "            call()\n"
                          "        except hecaton.Closed as error:\n"
                          "            print(error.kind, 'os.fork()' in str(error), flush=True)\n"
                          "    cell.close()\n"
                          "    del cell, goal\n"
                          "    with hecaton.connect(sys.argv[1], timeout=60) as own:\n"
                          "        print(own.status(60).cell, flush=True)\n"
                          "    sys.exit(3)\n"
                          "_, status = os.waitpid(child, 0)\n"
                          "print(os.waitstatus_to_exitcode(status), cell.status(60).cell, flush=True)\n", self)
        out, err = process.communicate(timeout=100)
        self.assertEqual(out, "forked True\n" * 4 + "three_puma\n3 three_puma\n", err)

    def test_close_ends_waits_of_other_threads(self):
        cell = hecaton.connect(self.file, domain=self.domain.number, timeout=60)
        cell.hold()
        try:
            goal = cell.arm("north").go_to("ready")
            failures = []

            def wait():
                try:
                    goal.wait()
                except hecaton.Closed as error:
                    failures.append(error.kind)

            waits = threading.Thread(target=wait)
            waits.start()
            next(goal.updates())
            cell.close()
            waits.join()
            self.assertEqual(failures, ["closed"])
            with self.assertRaises(hecaton.Closed):
                goal.wait(0)
            with self.assertRaises(hecaton.Closed):
                cell.status()
        finally:
            self.cell.resume()

    def test_ctrl_c_ends_a_wait(self):
        process = program("import hecaton, sys\n"
                          "cell = hecaton.connect(sys.argv[1], timeout=60)\n"
                          "cell.hold()\n"
                          "goal = cell.arm('west').go_to('ready')\n"
                          "try:\n"
                          "    print('waiting', flush=True)\n"
                          "    goal.wait()\n"
                          "except KeyboardInterrupt:\n"
                          "    cell.resume()\n"
                          "    print('interrupted', flush=True)\n", self)
        self.assertEqual(process.stdout.readline(), "waiting\n")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual((out, process.returncode), ("interrupted\n", 0), err)

    def test_ctrl_c_ends_a_request(self):
        process = program("import hecaton, sys\n"
                          "try:\n"
                          "    print('connecting', flush=True)\n"
                          "    hecaton.connect(domain=int(sys.argv[2]), timeout=None)\n"
                          "except KeyboardInterrupt:\n"
                          "    print('interrupted', flush=True)\n", self, "199")
        self.assertEqual(process.stdout.readline(), "connecting\n")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual((out, process.returncode), ("interrupted\n", 0), err)

    def test_interpreter_ends_with_callbacks_and_waiting_threads(self):
        self.addCleanup(self.cell.resume)
        for _ in range(5):
            process = program("import hecaton, sys, threading\n"
                              "cell = hecaton.connect(sys.argv[1], timeout=60)\n"
                              "cell.hold()  # so that no goal ends\n"
                              "goal = cell.arm('east').go_to('ready')\n"
                              "goal.on_progress(lambda progress: None)\n"
                              "cell.on_fault(print)\n"
                              "other = cell.arm('west').go_to('ready')\n"
                              "threading.Thread(target=other.wait, daemon=True).start()\n"
                              "next(goal.updates())\n"
                              "sys.exit(7)\n", self)
            _, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 7, err)
            self.assertNotIn("Fatal", err)


class Endurance(LiveCell):
    def test_two_hundred_goals_lose_no_outcome_and_no_memory(self):
        arms = self.cell.arms()
        poses = [arm.state().q for arm in arms]

        def round_of_goals(i):
            step = 0.02 if i % 2 else -0.02
            goals = [arm.go_to(q + np.array([step, 0, 0, 0, 0, 0])) for arm, q in zip(arms, poses)]
            for goal in goals:
                goal.on_progress(lambda progress: None)
            return [outcome.kind for outcome in self.cell.wait_all(goals, LONG)]

        for i in range(10):
            round_of_goals(i)
        gc.collect()
        before = resident()
        outcomes = [kind for i in range(67) for kind in round_of_goals(i)]
        gc.collect()
        self.assertEqual(outcomes, ["reached"] * 201)
        # 201 goals of 10 kB each would show.
        self.assertLess(resident() - before, 2000)


if __name__ == "__main__":
    unittest.main()
