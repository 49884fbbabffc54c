"""What hecaton-chaos makes of what a cell tells: its exit codes, and what it finds. The cell is none.

usage: test_chaos.py"""
import contextlib
import io
import pathlib
import tempfile
import types
import unittest
import unittest.mock

import chaos
from injections import Cut, Kill, Stop
from limits import Limits
from steadiness import UNSAFE, UNSTEADY, NodeLateness, unix_ms
from terms import driver

PLACES = {"supervisor": "a-pc", "supervisor@b-pc": "b-pc", "world": "b-pc", "driver/left": "c-pc"}


class Cell:
    """Runs; its arms reach every goal but those of `unreached`; touches something at the goal of that number. `logs`: lines."""

    def __init__(self, unreached=(), touches=None, fails=None,
                 logs=tuple(driver(event, "A", 4, arm) for event in ("arm lease", "follows") for arm in ("left", "right"))):
        self.listeners = []
        self.unreached, self.touches, self.fails = unreached, touches, fails
        self.logs = logs
        self.goals = 0
        self.stopped = False
        self.leader = {"supervisor": "supervisor", "term": 4}
        self.told = {}
        self.lateness = NodeLateness()

    def status(self):
        return {**self.leader, "nodes": [{"node": node, "host": host} for node, host in PLACES.items()],
                "hosts": [{"host": host} for host in ("a-pc", "b-pc", "c-pc")]}

    def tell_leader(self, supervisor, term):
        self.leader = {"supervisor": supervisor, "term": term}
        self.listeners[1](self.leader)  # the others hear of terms, and of whether the cell runs

    def start(self):
        if self.fails:
            raise self.fails

    def goal(self, arm, pose):
        self.goals += 1
        return arm, pose, self.goals

    def wait_for_goal(self, goal):
        if goal[2] == self.touches or goal[:2] in self.unreached:
            raise AssertionError("goal not reached")

    def contacts(self):
        return int(self.touches is not None and self.goals >= self.touches)

    def faults(self):
        return self.told

    def account(self):
        return "an account"

    def wait_until_it_runs(self):
        pass

    def wait_for(self, what, condition):
        pass

    def new_log_lines(self):
        lines, self.logs = self.logs, ()
        return lines

    log_lines = new_log_lines


class Machine:
    """Its timers are late, or not."""
    late = ()

    def __init__(self, stood_still=False):
        self.stood_still = lambda since, until, *_: stood_still and since <= until


def chaos_of(cell, ended_by=None, stood_still=False, findings=1):
    options = types.SimpleNamespace(only=["kill"], alone=False, of=[""], seed=1, findings=findings, timeout_scale=1, cell="cell.yaml",
                                    report=None, output="json", soak=0.02)
    made = chaos.Chaos(cell, ["left", "right"], ("home", "up"), Limits(), options, types.SimpleNamespace(told=ended_by))
    made.lateness = Machine(stood_still)
    made.ran_again = -1e9  # long ago: nothing is to settle
    made.wait_until_it_runs = lambda: None
    return made, options


class ChaosTest(unittest.TestCase):
    def setUp(self):
        self.said = io.StringIO()
        self.enterContext(contextlib.redirect_stderr(self.said))

    def run_soak(self, cell, ended=(), **how):
        """Its exit code."""
        made, options = chaos_of(cell, **how)
        chaos.live(cell, made, options)
        made.check_the_rest()
        self.made = made
        return chaos.judge(made, dict(ended))


class ExitCodeTest(ChaosTest):
    def test_what_held_is_success(self):
        self.assertEqual(self.run_soak(Cell()), 0)
        self.assertGreater(self.made.held, 0)
        self.assertEqual(self.made.reached, self.made.tasks)

    def test_nothing_tested_is_none(self):
        self.assertEqual(self.run_soak(Cell(), ended_by=15), chaos.NOTHING_TESTED)
        self.assertIn("before anything was tested", self.said.getvalue())

    def test_neither_are_logs_that_do_not_tell_whom_an_arm_follows(self):
        self.assertEqual(self.run_soak(Cell(logs=[driver("follows", "A", 4, "left"), driver("arm lease", "A", 4, "left")])), 1)
        self.assertIn("the logs do not tell whom right followed", self.said.getvalue())

    def test_neither_is_what_was_discarded_most_of_the_time(self):
        made, _ = chaos_of(Cell())
        for made.held, made.discarded, code in (0, 1, UNSTEADY), (1, 2, UNSTEADY), (2, 2, 0):
            self.assertEqual(chaos.judge(made, {}), code)

    def test_agents_that_do_not_end_well_are_a_failure(self):
        self.assertEqual(self.run_soak(Cell(), ended={"a-pc": -9}), 1)

    def test_a_finding_while_the_machine_stood_still_says_nothing(self):
        made, _ = chaos_of(Cell(), stood_still=True)
        made.violated("an episode", AssertionError("not within 120 s"))
        self.assertEqual((chaos.judge(made, {}), chaos.judge(made, {"a-pc": -9})), (UNSTEADY, 1))

    def test_a_contact_is_one_whatever_else_fails(self):
        for touches in 1, 5:  # before anything is done to the cell, and later
            self.assertEqual(self.run_soak(Cell(touches=touches), stood_still=True, ended={"a-pc": -9}), UNSAFE)
            self.assertEqual(self.made.accounts["contacts"], 1)
        self.assertEqual(self.run_soak(Cell(touches=0, fails=RuntimeError("ip: no"))), UNSAFE)

    def test_what_this_program_fails_in_is_told(self):
        self.assertEqual(self.run_soak(Cell(fails=ProcessLookupError("gone")), stood_still=True), 1)
        self.assertIn("hecaton-chaos itself: ProcessLookupError: gone", self.made.violations[0])

    def test_a_report_that_cannot_be_written_takes_nothing_back(self):
        made, options = chaos_of(Cell())
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch("os.dup2"):
            options.report = pathlib.Path(folder)
            self.assertFalse(chaos.tell(made, {}, options))


class ToAndFroTest(ChaosTest):
    def test_arms_that_cannot_are_no_finding_and_named(self):
        for pose, other in ("up", "home"), ("home", "up"):
            self.assertEqual(self.run_soak(Cell(unreached=[("right", pose)])), chaos.BAD_INPUT)
            self.assertEqual(self.made.violations, [])
            self.assertIn(f"arm right did not get from {other} to {pose}", self.made.unfit)

    def test_while_the_machine_stood_still_that_says_nothing(self):
        self.assertEqual(self.run_soak(Cell(unreached=[("right", "up")]), stood_still=True), UNSTEADY)

    def test_it_is_a_finding_where_the_cell_tells_of_a_fault(self):
        cell = Cell(unreached=[("right", "up")])
        made, options = chaos_of(cell)
        made.settle = lambda: cell.told.update({1: {"kind": "process_died", "subject": "planner/right", "description": "signal 11",
                                                   "cleared": True, "since_unix_ms": unix_ms()}})
        chaos.live(cell, made, options)
        self.assertEqual(chaos.judge(made, {}), 1)
        self.assertIn("process_died of planner/right", made.violations[0])


class ToldTest(ChaosTest):
    def await_told(self, since, stood_still=False):
        """A stop began at 10 s, and a silence was told `since` then [ms]."""
        told = {"kind": "node_silent", "subject": "world", "description": "no heartbeat", "cleared": False, "since_unix_ms": since}
        cell = Cell()
        cell.wait_for = lambda what, condition, within: condition(None)
        made, _ = chaos_of(cell, stood_still=stood_still)
        made.learn()
        made.leader = "supervisor"
        cell.told[1] = told
        made.await_told([Stop("world", "b-pc", 2.0)], {0: 10_000})
        return made.detection["stop world"]

    def test_after_it_began(self):
        self.assertEqual(self.await_told(10_300), [300])
        self.assertEqual(self.await_told(9_999), [-1])

    def test_what_was_told_before_it_began_was_a_false_accusation(self):
        with self.assertRaisesRegex(chaos.Violation, "accused, 281 ms before stop world") as found:
            self.await_told(9_719)
        self.assertEqual(found.exception.account, "wrong_attributions")
        self.assertEqual(self.await_told(9_719, stood_still=True), [])


class LeadershipTest(ChaosTest):
    def setUp(self):
        super().setUp()
        self.cell = Cell()
        self.chaos, _ = chaos_of(self.cell)
        self.chaos.learn()
        self.cell.tell_leader("supervisor", 4)

    def test_it_moves_by_itself(self):
        self.cell.tell_leader("supervisor@b-pc", 5)
        with self.assertRaisesRegex(chaos.Violation, r"from supervisor \(term 4\) to supervisor@b-pc \(term 5\)") as found:
            self.chaos.check([])
        self.assertEqual(found.exception.account, "unexplained_failovers")
        self.chaos.check([])  # once

    def test_what_happens_elsewhere_is_no_reason(self):
        self.chaos.let_move(Kill("driver/left", "c-pc"))
        self.cell.tell_leader("supervisor@b-pc", 5)
        with self.assertRaises(chaos.Violation):
            self.chaos.check([])

    def test_a_process_that_was_late_and_left_alone_is_one_unless_it_is_a_supervisor(self):
        for late, where, found in ("driver/left", "c-pc", False), ("supervisor", "a-pc", True), ("world", "b-pc", True):
            self.cell.lateness.stalls = [(unix_ms(), 200.0, late, where)]
            self.cell.tell_leader("supervisor@b-pc", self.cell.leader["term"] + 1)
            with self.assertRaises(chaos.Violation) if found else contextlib.nullcontext():
                self.chaos.check([Kill("world", "b-pc")])

    def test_what_happens_to_a_supervisor_is_one_until_some_time_after_the_cell_runs_again(self):
        self.chaos.let_move(Cut("a-pc", 2.0))
        self.cell.tell_leader("supervisor@b-pc", 5)
        chaos.Chaos.wait_until_it_runs(self.chaos)
        self.cell.tell_leader("supervisor", 6)
        self.chaos.check([])
        self.chaos.may_move[1] -= 1000 * chaos.RETURN + 1
        self.cell.tell_leader("supervisor", 8)
        with self.assertRaises(chaos.Violation):
            self.chaos.check([])

    def test_it_pardons_what_happened_around_it_and_nothing_else(self):
        self.chaos.leader = "supervisor"
        now = unix_ms()
        silence = [Cut("c-pc", 2.0)]
        self.assertFalse(self.chaos.newcomer_leads(silence, now, 2.0))
        self.cell.tell_leader("supervisor@b-pc", 5)
        self.assertTrue(self.chaos.newcomer_leads(silence, now - 1000, 2.0))
        self.assertFalse(self.chaos.newcomer_leads(silence, now - 9000, 2.0))
        self.assertFalse(self.chaos.newcomer_leads([*silence, Kill("supervisor", "a-pc")], now - 1000, 2.0))


if __name__ == "__main__":
    unittest.main()
