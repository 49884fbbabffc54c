"""Exit codes and findings of hecaton-chaos, with a simulated cell.

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
    """A running cell. Arms reach all goals except `unreached`; there are contacts from goal number `touches` on. `logs`: lines."""

    def __init__(self, unreached=(), touches=None, fails=None,
                 logs=tuple(driver(event, "A", 4, arm) for event in ("arm lease", "planner changed") for arm in ("left", "right"))):
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
        self.listeners[1](self.leader)  # the other listeners take terms, and whether the cell runs

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
    """Timer lateness with a fixed answer."""
    late = ()

    def __init__(self, stood_still=False):
        self.stood_still = lambda since, until, *_: stood_still and since <= until


def chaos_of(cell, ended_by=None, stood_still=False, findings=1):
    options = types.SimpleNamespace(only=["kill"], alone=False, of=[""], seed=1, findings=findings, timeout_scale=1, cell="cell.yaml",
                                    record=None, second_record=None, report=None, output="json", soak=0.02, calm=0.0)
    made = chaos.Chaos(cell, ["left", "right"], ("home", "up"), Limits(), options, types.SimpleNamespace(received=ended_by))
    made.lateness = Machine(stood_still)
    made.ran_again = -1e9  # long ago, so that nothing has to settle
    made.wait_until_it_runs = lambda: None
    return made, options


class ChaosTest(unittest.TestCase):
    def setUp(self):
        self.said = io.StringIO()
        self.enterContext(contextlib.redirect_stderr(self.said))

    def run_soak(self, cell, ended=(), **how):
        """Returns the exit code."""
        made, options = chaos_of(cell, **how)
        chaos.run_cell(cell, made, options)
        made.check_the_rest()
        self.made = made
        return chaos.judge(made, dict(ended))


class ExitCodeTest(ChaosTest):
    def test_run_without_finding_succeeds(self):
        self.assertEqual(self.run_soak(Cell()), 0)
        self.assertGreater(self.made.passed, 0)
        self.assertEqual(self.made.reached, self.made.tasks)

    def test_run_without_episode_does_not_succeed(self):
        made, _ = chaos_of(Cell())
        self.assertEqual(chaos.judge(made, {}), chaos.NOTHING_TESTED)
        self.assertIn("ended before the first episode", self.said.getvalue())

    def test_interrupted_run_reports_what_is_done(self):
        for number, code in (2, 130), (15, 143):
            self.assertEqual(self.run_soak(Cell(), ended_by=number), code)
        report = self.made.report("cell.yaml", 1, {})
        self.assertEqual(report["interrupted"], {"signal": "SIGTERM", "done": 0, "asked": 0.02, "unit": "s"})
        self.assertIn("interrupted by SIGTERM: 0 of 0.02 s done", list(self.made.summary()))

    def test_finding_counts_more_than_the_signal(self):
        made, _ = chaos_of(Cell(), ended_by=2)
        made.violated("an episode", AssertionError("not within 120 s"))
        self.assertEqual(chaos.judge(made, {}), 1)

    def test_signal_at_the_end_of_a_complete_run_changes_nothing(self):
        made, _ = chaos_of(Cell(), ended_by=2)
        made.passed, made.extent = 1, (30, 30, "faults")
        self.assertEqual((chaos.judge(made, {}), made.interrupted()), (0, None))

    def test_logs_without_followed_planner_are_a_finding(self):
        self.assertEqual(self.run_soak(Cell(logs=[driver("planner changed", "A", 4, "left"), driver("arm lease", "A", 4, "left")])), 1)
        self.assertIn("the logs do not show which planner right followed", self.said.getvalue())

    def test_mostly_discarded_run_does_not_succeed(self):
        made, _ = chaos_of(Cell())
        for made.passed, made.discarded, code in (0, 1, UNSTEADY), (1, 2, UNSTEADY), (2, 2, 0):
            self.assertEqual(chaos.judge(made, {}), code)

    def test_failed_agent_is_a_failure(self):
        self.assertEqual(self.run_soak(Cell(), ended={"a-pc": -9}), 1)

    def test_finding_during_a_machine_stall_is_unsteady(self):
        made, _ = chaos_of(Cell(), stood_still=True)
        made.violated("an episode", AssertionError("not within 120 s"))
        self.assertEqual((chaos.judge(made, {}), chaos.judge(made, {"a-pc": -9})), (UNSTEADY, 1))

    def test_contact_is_unsafe_whatever_else_fails(self):
        for touches in 1, 5:  # before the first fault, and later
            self.assertEqual(self.run_soak(Cell(touches=touches), stood_still=True, ended={"a-pc": -9}), UNSAFE)
            self.assertEqual(self.made.accounts["contacts"], 1)
        self.assertEqual(self.run_soak(Cell(touches=0, fails=RuntimeError("ip: no"))), UNSAFE)

    def test_error_of_the_program_is_reported(self):
        self.assertEqual(self.run_soak(Cell(fails=ProcessLookupError("gone")), stood_still=True), 1)
        self.assertIn("hecaton-chaos itself: ProcessLookupError: gone", self.made.violations[0])

    def test_unwritable_report_keeps_the_findings(self):
        made, options = chaos_of(Cell())
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch("os.dup2"):
            options.report = pathlib.Path(folder)
            self.assertFalse(chaos.print_report(made, {}, options))


class BackAndForthTest(ChaosTest):
    def test_unreached_goal_without_fault_is_bad_input(self):
        for pose, other in ("up", "home"), ("home", "up"):
            self.assertEqual(self.run_soak(Cell(unreached=[("right", pose)])), chaos.BAD_INPUT)
            self.assertEqual(self.made.violations, [])
            self.assertIn(f"arm right did not reach {pose} from {other}", self.made.unfit)

    def test_unreached_goal_during_a_stall_is_unsteady(self):
        self.assertEqual(self.run_soak(Cell(unreached=[("right", "up")]), stood_still=True), UNSTEADY)

    def test_unreached_goal_with_a_fault_is_a_finding(self):
        cell = Cell(unreached=[("right", "up")])
        made, options = chaos_of(cell)
        made.settle = lambda: cell.told.update({1: {"kind": "process_died", "subject": "planner/right", "description": "signal 11",
                                                   "cleared": True, "since_unix_ms": unix_ms()}})
        chaos.run_cell(cell, made, options)
        self.assertEqual(chaos.judge(made, {}), 1)
        self.assertIn("process_died of planner/right", made.violations[0])


class ToldTest(ChaosTest):
    def await_reports(self, since, stood_still=False):
        """A stop began at 10 s; a silence is reported since `since` [ms]."""
        told = {"kind": "node_silent", "subject": "world", "description": "no heartbeat", "cleared": False, "since_unix_ms": since}
        cell = Cell()
        cell.wait_for = lambda what, condition, within: condition(None)
        made, _ = chaos_of(cell, stood_still=stood_still)
        made.learn()
        made.leader = "supervisor"
        cell.told[1] = told
        made.await_reports([Stop("world", "b-pc", 2.0)], {0: 10_000})
        return made.detection["stop world"]

    def test_detection_counts_from_the_injection(self):
        self.assertEqual(self.await_reports(10_300), [300])
        self.assertEqual(self.await_reports(9_999), [-1])

    def test_fault_before_the_injection_is_wrong(self):
        with self.assertRaisesRegex(chaos.Violation, "wrong fault, 281 ms before stop world") as found:
            self.await_reports(9_719)
        self.assertEqual(found.exception.account, "wrong_attributions")
        self.assertEqual(self.await_reports(9_719, stood_still=True), [])


class LeadershipTest(ChaosTest):
    def setUp(self):
        super().setUp()
        self.cell = Cell()
        self.chaos, _ = chaos_of(self.cell)
        self.chaos.learn()
        self.cell.tell_leader("supervisor", 4)

    def test_leader_change_without_cause_is_a_finding(self):
        self.cell.tell_leader("supervisor@b-pc", 5)
        with self.assertRaisesRegex(chaos.Violation, r"from supervisor \(term 4\) to supervisor@b-pc \(term 5\)") as found:
            self.chaos.check([])
        self.assertEqual(found.exception.account, "unexplained_failovers")
        self.chaos.check([])  # once

    def test_fault_elsewhere_is_no_cause(self):
        self.chaos.allow_leader_change(Kill("driver/left", "c-pc"))
        self.cell.tell_leader("supervisor@b-pc", 5)
        with self.assertRaises(chaos.Violation):
            self.chaos.check([])

    def test_stall_of_another_process_is_a_cause(self):
        for late, where, found in ("driver/left", "c-pc", False), ("supervisor", "a-pc", True), ("world", "b-pc", True):
            self.cell.lateness.stalls = [(unix_ms(), 200.0, late, where)]
            self.cell.tell_leader("supervisor@b-pc", self.cell.leader["term"] + 1)
            with self.assertRaises(chaos.Violation) if found else contextlib.nullcontext():
                self.chaos.check([Kill("world", "b-pc")])

    def test_fault_of_a_supervisor_is_a_cause_until_after_recovery(self):
        self.chaos.allow_leader_change(Cut("a-pc", 2.0))
        self.cell.tell_leader("supervisor@b-pc", 5)
        chaos.Chaos.wait_until_it_runs(self.chaos)
        self.cell.tell_leader("supervisor", 6)
        self.chaos.check([])
        self.chaos.may_move[1] -= 1000 * chaos.RETURN + 1
        self.cell.tell_leader("supervisor", 8)
        with self.assertRaises(chaos.Violation):
            self.chaos.check([])

    def test_leader_change_pardons_faults_at_that_time_only(self):
        self.chaos.leader = "supervisor"
        now = unix_ms()
        silence = [Cut("c-pc", 2.0)]
        self.assertFalse(self.chaos.newcomer_leads(silence, now, 2.0))
        self.cell.tell_leader("supervisor@b-pc", 5)
        self.assertTrue(self.chaos.newcomer_leads(silence, now - 1000, 2.0))
        self.assertFalse(self.chaos.newcomer_leads(silence, now - 9000, 2.0))
        self.assertFalse(self.chaos.newcomer_leads([*silence, Kill("supervisor", "a-pc")], now - 1000, 2.0))


class OneLeadsTest(unittest.TestCase):
    @staticmethod
    def status(leader, *states):
        return {"supervisor": leader, "nodes": [{"node": node, "state": state} for node, state in states]}

    def test_second_leader_does_not_count_as_standby(self):
        first, second = ("supervisor", "running"), ("supervisor@b", "running")
        self.assertFalse(chaos.one_leads(self.status("supervisor", first, second, ("world", "running"))))
        self.assertTrue(chaos.one_leads(self.status("supervisor", first, ("supervisor@b", "standby"))))
        self.assertTrue(chaos.one_leads(self.status("supervisor", first)))
        self.assertFalse(chaos.one_leads(self.status("supervisor@b", first, ("supervisor@b", "standby"))))


if __name__ == "__main__":
    unittest.main()
