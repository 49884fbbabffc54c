"""A cell of three arms on five hosts tolerates faults of hosts and processes; observed through `hecaton`.

usage: test_faults.py --programs DIR --cell FILE [--image NAME] [--logs DIR] [--only TEXT]

Hosts are containers of the image if possible, otherwise network namespaces. Exit codes: 77 this machine supports neither; the reason
is on stderr. A test that fails while the machine stalls is repeated, after 15 s without a stall, with longer time-outs
(--timeout-scale); 75 it failed so each time. 70 a contact, or an arm that followed an older command. 130, 143 ended by SIGINT or SIGTERM."""
import argparse
import pathlib
import signal
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "chaos"))
import cell_copy  # noqa: E402
import cell_document  # noqa: E402
import containers  # noqa: E402
import ending  # noqa: E402
import namespaces  # noqa: E402
from hosts import CannotRun  # noqa: E402
from injections import Cut, Kill, Mute, Pause, is_supervisor, pairs  # noqa: E402
from live_cell import LiveCell, unix_ms  # noqa: E402
from steadiness import UNSAFE, UNSTEADY, SpannedResult, TimerLateness, judge_failures  # noqa: E402
from terms import LogTerms, StatusTerms  # noqa: E402
from verdicts import may_be_reported  # noqa: E402

SKIPPED = 77  # exit code for CTest
ARMS = ("north", "west", "east")
options = None
node_stalls = []  # stalls of undisturbed hosts, from NodeLateness
unpardonable = []  # classes with a contact or an arm that followed an older command
ends = None  # ending.Ending
ends_cell = False


class Ended(Exception):
    """A signal ends the program."""


def end_test(number):
    """The running cell; none while it ends."""
    if not ends_cell:
        raise Ended(f"by {signal.Signals(number).name}")


class EndedResult(SpannedResult):
    """Ends the run before the next test; class fixtures are still cleaned up."""

    def addError(self, test, err):
        super().addError(test, err)
        if issubclass(err[0], Ended):
            self.stop()


class CellTest(unittest.TestCase):
    """The tests of a class share a cell."""

    disturbed = ()  # hosts that are paused, or whose processes are killed

    @classmethod
    def cell_file(cls):
        document = read_cell()
        cell_copy.make_paths_absolute(document, options.cell.parent.absolute())
        cell_copy.scale_timeouts(document, options.timeout_scale)
        return written("moving.yaml", document)

    @classmethod
    def setUpClass(cls):
        if ends.received:
            raise Ended
        print(f"{cls.__name__}: hosts are {options.hosts.kind}; their logs are in {options.logs}", flush=True)
        cls.cell = LiveCell(options.hosts, options.programs.resolve() / "hecaton", cls.cell_file(), options.logs)
        cls.addClassCleanup(cls.end_cell)  # also if the cell does not start
        began = time.monotonic()
        cls.cell.start()
        cls.cell.wait_until_it_runs()
        print(f"the cell runs after {time.monotonic() - began:.1f} s", flush=True)

    @classmethod
    def end_cell(cls):
        global ends_cell
        ends_cell = True
        began = time.monotonic()
        codes = cls.cell.stop()
        cls.cell.hosts.close()
        ends_cell = False
        if cls.cell.contacts():
            unpardonable.append(cls)
        print(f"the cell ended after {time.monotonic() - began:.1f} s", flush=True)
        node_stalls.extend(cls.cell.lateness.of_others(cls.disturbed))
        if any(codes.values()):
            raise AssertionError(f"agents ended with {codes}")

    def setUp(self):
        self.cell.wait_until_it_runs()
        self.known = self.cell.faults()
        self.began = time.monotonic()

    def print_figures(self, what, injected=None, fault=None):
        """Prints a line of figures."""
        line = what
        if fault:
            line += f": seen after {fault['since_unix_ms'] - injected} ms as {fault['kind']} of {fault['subject']}"
            line += f", over {fault['duration_s']:.1f} s later"
        print(f"{line}; {time.monotonic() - self.began:.1f} s, {self.cell.contacts()} contacts", flush=True)

    def expect_no_fault_but(self, *expected, may=frozenset()):
        """`may`: (kind, subject) of faults that are allowed but not required."""
        ids = {fault["id"] for fault in expected}
        others = [fault for key, fault in self.cell.faults().items()
                  if key not in self.known and key not in ids and not pairs(fault) & may]
        self.assertEqual(others, [])

    def expect_all_well(self, *expected, may=frozenset()):
        self.cell.wait_until_it_runs()
        self.expect_no_fault_but(*expected, may=may)
        self.assertEqual(self.cell.contacts(), 0)

    def visit(self, *arms):
        """Moves all arms to the shared zone and home again."""
        for pose in ("ready", "home"):
            for goal in [self.cell.goal(arm, pose) for arm in arms]:
                self.cell.wait_for_goal(goal)

    def kill(self, node, host):
        """Sends SIGKILL; returns the time [ms, wall clock]."""
        pid = self.cell.pid(node)
        injected = unix_ms()
        self.cell.hosts.signal(host, pid, signal.SIGKILL)
        return injected

    def lose_and_find(self, what, host, arm, lose, find, may=frozenset()):
        """A host is lost while its arm moves, and returns."""
        others = [other for other in ARMS if other != arm]
        goals = [self.cell.goal(arm, "ready")]
        self.cell.wait_until_it_moves(arm)
        injected = unix_ms()
        lose(host)
        try:
            fault = self.cell.wait_for_fault("host_lost", host, self.known)
            # The position of the lost arm is unknown: other arms move where it cannot be, or wait.
            for other in others:
                goals.append(self.cell.goal(other, "ready"))
                self.cell.wait_until_it_is_there_or_waits(other, goals[-1], arm)
        finally:
            find(host)
        fault = self.cell.wait_until_over(fault)
        for goal in goals:
            self.cell.wait_for_goal(goal)
        self.visit(arm, *others)
        self.expect_all_well(fault, may=may)
        self.print_figures(what, injected, fault)


def read_cell():
    return cell_document.read(options.cell.read_bytes())


def still_copy():
    """The cell with static obstacles, because an arm without driver cannot give way."""
    return cell_copy.copy_of(read_cell(), options.cell.parent.absolute(), options.timeout_scale)


def written(name, document):
    """The copy of the cell file, in the folder of the logs."""
    file = options.logs / name
    file.write_text(cell_document.write(document))
    return file


class FaultTest(CellTest):
    disturbed = ("north-pc", "west-pc", "east-pc", "world-pc", "supervisor-pc")

    @classmethod
    def cell_file(cls):
        return written("still.yaml", still_copy())

    def test_killed_planner_restarts_and_its_arm_reaches_the_goal(self):
        goal = self.cell.goal("north", "ready")
        self.cell.wait_until_it_moves("north")
        injected = self.kill("planner/north", "north-pc")
        fault = self.cell.wait_for_fault("process_died", "planner/north", self.known)
        self.assertIn("signal 9", fault["description"])
        self.visit("west", "east")
        self.cell.wait_for_goal(goal)
        fault = self.cell.wait_until_over(fault)
        self.visit("north")
        self.expect_all_well(fault)
        self.print_figures("kill -9 of a planner", injected, fault)

    def test_killed_driver_restarts_at_the_position_of_its_arm(self):
        goal = self.cell.goal("east", "ready")
        self.cell.wait_until_it_moves("east")
        injected = self.kill("driver/east", "east-pc")
        fault = self.cell.wait_for_fault("process_died", "driver/east", self.known)
        self.assertIn("signal 9", fault["description"])
        fault = self.cell.wait_until_over(fault)
        self.cell.wait_for_goal(goal)
        self.visit("north", "west", "east")
        self.expect_all_well(fault)
        self.print_figures("kill -9 of a driver", injected, fault)

    def test_killed_world_restarts_with_edited_obstacles(self):
        self.cell.ask("obstacle", "add", "crate", "--box", "0.2 0.2 0.2", "--pose", "1.5 1.5 0.1 0 0 0")
        injected = self.kill("world", "world-pc")
        fault = self.cell.wait_for_fault("process_died", "world", self.known)
        fault = self.cell.wait_until_over(fault)
        self.visit("north", "west", "east")
        self.cell.ask("obstacle", "remove", "crate")  # fails if there is none
        self.expect_all_well(fault)
        self.print_figures("kill -9 of the world", injected, fault)

    def test_killed_supervisor_restarts_while_arms_continue(self):
        goals = [self.cell.goal(arm, "ready") for arm in ("north", "west")]
        self.cell.wait_until_it_moves("north")
        injected = self.kill("supervisor", "supervisor-pc")
        for goal in goals:
            self.cell.wait_for_goal(goal)
        fault = self.cell.wait_for_fault("process_died", "supervisor", self.known)  # reported by its successor, from its agent
        self.assertIn("signal 9", fault["description"])
        fault = self.cell.wait_until_over(fault)
        self.visit("north", "west", "east")
        self.expect_all_well(fault)
        self.print_figures("kill -9 of the supervisor", injected, fault)

    def test_host_without_power_is_lost_and_returns(self):
        injected = unix_ms()
        self.cell.cut_power("west-pc")
        try:
            fault = self.cell.wait_for_fault("host_lost", "west-pc", self.known)
            goals = {arm: self.cell.goal(arm, "ready") for arm in ("north", "east")}
            for arm, goal in goals.items():
                self.cell.wait_until_it_is_there_or_waits(arm, goal, "west")
        finally:
            self.cell.start_agent("west-pc")
        fault = self.cell.wait_until_over(fault)
        for goal in goals.values():
            self.cell.wait_for_goal(goal)
        self.visit("north", "west", "east")
        self.expect_all_well(fault)
        self.print_figures("a host without power", injected, fault)

    def test_paused_host_is_lost_and_returns(self):
        self.lose_and_find("a paused host", "north-pc", "north", self.cell.hosts.pause, self.cell.hosts.go_on)

    def test_host_without_network_is_lost_and_returns(self):
        self.lose_and_find("a pulled cable", "west-pc", "west", self.cell.hosts.disconnect, self.cell.hosts.connect)


class StandbyTest(CellTest):
    """With standbys of the supervisor and of all planners. The standby of north's planner is on a host without drivers, so that the
    arm can continue while that host is stopped."""

    disturbed = FaultTest.disturbed

    @classmethod
    def cell_file(cls):
        document = still_copy()
        cell_copy.put_standbys_in_a_ring(document, {"north-pc": "supervisor-pc"})
        return written("standbys.yaml", document)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.places = {node["node"]: node["host"] for node in cls.cell.status()["nodes"] if node["kind"] != "agent"}
        cls.log_terms, cls.status_terms = LogTerms(), StatusTerms()
        cls.cell.listeners.append(cls.status_terms.hear)

    def setUp(self):
        super().setUp()
        self.cell.wait_for("all services have their standbys", all_have_standbys)

    def tearDown(self):
        for line in self.cell.new_log_lines():
            self.log_terms.hear(line)
        complaints = self.log_terms.complaints + self.status_terms.complaints
        if complaints:
            unpardonable.append(type(self))
        self.assertEqual(complaints, [])
        self.assertEqual(self.log_terms.without_events(ARMS), [])  # otherwise nothing was checked

    def put_in_charge(self, planner, arm):
        """Of the arm, by the death of the other one, if that has it. Returns what was done."""
        other = arm_of(self.cell.status(), arm)["planner"]
        if other == planner:
            return []
        self.kill(other, self.places[other])
        self.cell.wait_for(f"{planner} is in charge", lambda status: (
            arm_of(status, arm)["planner"] == planner and all_have_standbys(status)))
        self.cell.wait_until_it_runs()
        return [Kill(other, self.places[other])]

    def let_lead(self, supervisor):
        """Likewise."""
        other = self.cell.status()["supervisor"]
        if other == supervisor:
            return []
        self.kill(other, self.places[other])
        self.cell.wait_for(f"{supervisor} leads", lambda status: (
            status["supervisor"] == supervisor and all_have_standbys(status)))
        self.cell.wait_until_it_runs()
        return [Kill(other, self.places[other])]

    def test_replaced_planner_that_slept_does_not_move_its_arm(self):
        sleeper = "planner/north@supervisor-pc"
        done = self.put_in_charge(sleeper, "north")
        pause = Pause("supervisor-pc", 0.0)
        goal = self.cell.goal("north", "ready")
        self.cell.wait_until_it_moves("north")
        before = arm_of(self.cell.status(), "north")["state"]
        pause.begin(self.cell)
        try:
            self.cell.wait_for("planner/north moves the arm",
                               lambda status: follows(status, "planner/north", before["term"]))
        finally:
            pause.end(self.cell)
        self.cell.wait_for_goal(goal)
        # On a busy machine it may lead again.
        self.cell.wait_for(f"{sleeper} stands by", lambda status: (
            sleeper in (arm_of(status, "north")["standby"], arm_of(status, "north")["planner"])
            and all_have_standbys(status)))
        self.visit(*ARMS)
        self.expect_all_well(may=may_be_reported([*done, pause], self.places))
        after = arm_of(self.cell.status(), "north")["state"]
        self.assertGreater(after["term"], before["term"])
        refused = after["stale_rejected"] - before["stale_rejected"]
        self.print_figures(f"an active planner that slept: {refused} of its commands were refused")

    def test_arms_continue_while_the_leader_is_cut_off(self):
        done = self.let_lead("supervisor") + self.put_in_charge("planner/north", "north")
        before = self.cell.status()
        cut = Cut("supervisor-pc", 0.0)
        goals = [self.cell.goal(arm, "ready") for arm in ARMS]
        self.cell.wait_until_it_moves("north")
        began = time.monotonic()
        injected = unix_ms()
        cut.begin(self.cell)
        try:
            self.cell.wait_for("the other supervisor leads", lambda status: (
                status["supervisor"] == before["standby"] and status["term"] > before["term"]))
            fault = self.cell.wait_for_fault("host_lost", cut.host, self.known)
            for goal in goals:
                self.cell.wait_for_goal(goal)
        finally:
            cut.end(self.cell)
            cut.lasted = time.monotonic() - began
        fault = self.cell.wait_until_over(fault)
        self.cell.wait_for("one supervisor leads, the other stands by", one_leads)
        self.visit(*ARMS)
        self.expect_all_well(fault, may=may_be_reported([*done, cut], self.places))
        self.print_figures("a leader that is cut off", injected, fault)

    def test_muted_host_is_lost_and_returns(self):
        mute = Mute("west-pc", 0.0)
        self.lose_and_find("a host that hears and is not heard", mute.host, "west", lambda _: mute.begin(self.cell),
                           lambda _: mute.end(self.cell), may_be_reported([mute], self.places))


def arm_of(status, name):
    return next(arm for arm in status["arms"] if arm["name"] == name)


def follows(status, planner, term):
    """True if the arm follows this planner with a newer term."""
    state = arm_of(status, planner.split("/")[1])["state"]
    return state["planner"] == planner and state["term"] > term


def one_leads(status):
    states = {node["node"]: node["state"] for node in status["nodes"] if is_supervisor(node["node"])}
    return sorted(states.values()) == ["running", "standby"] and states.get(status["supervisor"]) == "running"


def all_have_standbys(status):
    return one_leads(status) and status["standby"] and all(arm["standby"] for arm in status["arms"])


class LossTest(CellTest):
    """With moving obstacles: loss of datagrams must not cause a contact."""

    def test_cell_tolerates_loss_of_a_fifth_of_the_datagrams(self):
        self.cell.hosts.drop("east-pc", "input", per_cent=20)
        self.addCleanup(self.cell.hosts.drop_no_more, "east-pc", "input")
        self.visit("north", "west", "east")
        self.expect_all_well()
        dropped = self.cell.hosts.dropped("east-pc", "input")
        self.assertGreater(dropped, 100)
        self.print_figures(f"20 % loss ({dropped} datagrams)")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="folder of hecaton's programs")
    parser.add_argument("--cell", type=pathlib.Path, required=True, help="cell file")
    parser.add_argument("--image", help="use podman containers of this image as hosts; otherwise network namespaces")
    parser.add_argument("--logs", type=pathlib.Path, help="folder for the hosts' logs")
    parser.add_argument("--only", metavar="TEXT", help="run only tests whose names contain this")
    parser.add_argument("--timeout-scale", type=int, nargs="+", default=[1, 2, 4, 4], metavar="N",
                        help="factors of the cell's time-outs, one for each run of the tests (1 2 4 4)")
    return parser.parse_args()


def make_hosts():
    """Creates the hosts; restarts this program in namespaces if they are used."""
    if options.image and not namespaces.inside():
        try:
            return containers.Containers(options.image, options.cell.parent.absolute(), make_logs())
        except CannotRun as reason:
            print(f"hosts cannot be containers: {reason}", file=sys.stderr, flush=True)
    namespaces.enter()
    make_logs()
    return namespaces.Namespaces(options.programs.resolve() / "hecaton")


def make_logs():
    options.logs = options.logs or pathlib.Path(tempfile.mkdtemp(prefix="hecaton-hosts-"))
    options.logs.mkdir(parents=True, exist_ok=True)
    options.logs.chmod(0o755)  # users in containers need access
    return options.logs.resolve()


def main():
    global options, ends
    ends = ending.Ending(end_test)
    options = parse()
    try:
        options.hosts = make_hosts()
    except CannotRun as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        return SKIPPED
    except Ended:
        return ending.exit_code(ends.received)
    lateness = TimerLateness()
    rounds = options.timeout_scale
    options.timeout_scale = rounds[0]
    code, suite = run_tests(all_tests(), lateness)
    for options.timeout_scale in rounds[1:]:
        if code != UNSTEADY:
            break
        lateness.wait_until_steady()
        code, suite = run_tests(suite, lateness)
    return code


def all_tests():
    loader = unittest.TestLoader()
    loader.testNamePatterns = [f"*{options.only}*"] if options.only else None
    return loader.loadTestsFromModule(sys.modules[__name__])


def print_last_words(most=40):
    """Prints what processes wrote beside their log lines: causes of aborts, messages of libraries. Logs end with the machine."""
    for log in sorted(options.logs.glob("*.log")):
        words = [line for line in log.read_text(errors="replace").splitlines() if not line.startswith("time=")]
        for line in words[-most:]:
            print(f"{log.stem}: {line}", file=sys.stderr)


def run_tests(suite, lateness):
    """Returns the exit code and the failed tests."""
    try:
        result = unittest.TextTestRunner(resultclass=EndedResult, verbosity=2).run(suite)
    except Ended:  # between two tests
        options.hosts.close()
    if unpardonable:
        return UNSAFE, None
    if ends.received:
        return ending.exit_code(ends.received), None
    if result.wasSuccessful():
        return 0, None
    print_last_words()
    stalls = [(*stall, "a timer", "this machine") for stall in lateness.stalls] + node_stalls
    code = judge_failures(result.failed, stalls)
    if code == UNSTEADY:
        print(f"failed while the machine stalled (time-outs × {options.timeout_scale}); repeated",
              file=sys.stderr)
    return code, unittest.defaultTestLoader.loadTestsFromNames(result.names_of_failed(), sys.modules[__name__])


if __name__ == "__main__":
    sys.exit(main())
