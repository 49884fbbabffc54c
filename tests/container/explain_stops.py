"""Stops arms of a live, recorded cell for causes that a seed draws, and compares what `hecaton explain` says with each cause.

usage: explain_stops.py --programs DIR --cell FILE [--stops 50] [--seed 1] [--only CAUSE …] [--timeout-scale 1] [--record FILE.mcap]

The cell is that of three_hosts.yaml, without its obstacles, on hosts that are network namespaces. The time of each stop is that of its
injection or of its fault; the reason that the cell shows then is not looked at. A stop that the cell does not come to, as on a busy
machine, is caused again. Ctrl-C and a failure end the run with the verdict on the stops so far. Exit codes: 0 all are right; 1 some are
not, or the run failed; 77 this machine has no hosts."""
import argparse
import collections
import json
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "chaos"))
import cell_copy  # noqa: E402
import cell_document  # noqa: E402
import ending  # noqa: E402
import namespaces  # noqa: E402
from hosts import CannotRun  # noqa: E402
from live_cell import TIMEOUT, LiveCell, runs, unix_ms  # noqa: E402

SKIPPED = 77
TIME_OUT = 4  # exit code of hecaton
EDITS = 10  # largest number of tries
TRIES = 3  # of each stop
FAILURES = (AssertionError, LookupError, TypeError, OSError, RuntimeError, subprocess.SubprocessError)  # of a try: a cell that lacks
# a state, a process that ended
CENTRE = ("0", "0", "0.75")  # [m] within reach of all arms
STANDS = 1e-3  # [rad/s] of the fastest joint
NEARER = 0.01  # [rad] between joint positions
CAUSE = re.compile(r"\[(\w+)(?:, ([^\]]*))?\]\.$")
BINDING = re.compile(r" and (\S+) bound its motion")


class Stop:
    """begin() causes the stop of `arm`, and end() ends its cause. `other`: another arm."""

    def __init__(self, cell, arm, other):
        self.cell, self.arm, self.other = cell, arm, other
        self.host = self.pid = None  # of what began

    def begin(self):
        raise NotImplementedError

    def end(self):
        pass

    def causes(self):
        """The right answers: (kind, beginning of the subject)."""
        raise NotImplementedError

    def at(self):
        """Waits until the arm is stopped; returns a time within the stop [ms, wall clock]."""
        return self.cell.wait_until_it_stands(self.arm)


class Order(Stop):
    command, kind, whole = "hold", "hold_ordered", False

    def begin(self):
        self.cell.set_out(self.arm)
        self.cell.ask(self.command, *([] if self.whole else [self.arm]))

    def end(self):
        self.cell.ask("resume", *([] if self.whole else [self.arm]))

    def causes(self):
        return [(self.kind, "")]


class HoldOfCell(Order):
    whole = True


class StopOrder(Order):
    command, kind = "stop", "stop_ordered"


class StopOfCell(StopOrder):
    whole = True


class OfNode(Stop):
    """Something happens to the process of a node while the arm moves."""

    role = "driver"
    kinds = ("held_by_fault", "process_died")

    def node(self):
        return "world" if self.role == "world" else f"{self.role}/{self.arm}"

    def begin(self):
        self.cell.set_out(self.arm)
        self.known = self.cell.faults()
        self.pid, self.host = self.cell.pid(self.node()), self.cell.host_of(self.node())
        self.cell.hosts.signal(self.host, self.pid, signal.SIGKILL)

    def at(self):
        """The middle of the fault: the agent has restarted the process by then."""
        fault = self.cell.wait_until_over(self.cell.wait_for("a fault", lambda status: next(
            (fault for fault in status["faults"] if fault["id"] not in self.known and fault["subject"] == self.node()), None)))
        return fault["since_unix_ms"] + 500.0 * fault["duration_s"]

    def causes(self):
        return [(kind, self.node()) for kind in self.kinds]


class DriverDies(OfNode):
    pass


class PlannerDies(OfNode):
    role = "planner"


class WorldDies(OfNode):
    role = "world"


class DriverHangs(OfNode):
    kinds = ("held_by_fault", "node_silent")

    def begin(self):
        self.cell.set_out(self.arm)
        self.known = self.cell.faults()
        self.pid, self.host = self.cell.pid(self.node()), self.cell.host_of(self.node())
        self.cell.hosts.signal(self.host, self.pid, signal.SIGSTOP)

    def at(self):
        self.cell.wait_for_fault("node_silent", self.node(), self.known)
        return unix_ms()

    def end(self):
        if self.pid is None:
            return
        try:
            self.cell.hosts.signal(self.host, self.pid, signal.SIGCONT)
        except ProcessLookupError:
            pass  # its agent has killed it for its silence


class PlannerHangs(DriverHangs):
    role = "planner"


class WorldHangs(DriverHangs):
    role = "world"


class HostLost(Stop):
    def begin(self):
        self.cell.set_out(self.arm)
        self.known = self.cell.faults()
        self.host = self.cell.host_of(f"driver/{self.arm}")
        self.cell.hosts.disconnect(self.host)

    def at(self):
        self.cell.wait_for_fault("host_lost", self.host, self.known)
        return unix_ms()

    def end(self):
        if self.host is not None:
            self.cell.hosts.connect(self.host)

    def causes(self):
        return [("held_by_fault", self.host), ("host_lost", self.host)]


class Observed(Stop):
    """Its device is left to others."""

    def begin(self):
        self.cell.set_out(self.arm)
        self.cell.ask("device", self.arm, "observe")

    def end(self):
        self.cell.ask("device", self.arm, "command")

    def causes(self):
        return [("observed", self.arm)]


class OfGoal(Stop):
    """The end of its goal is why it stands: nothing else may hold it, as a machine that stands still does."""

    def at(self):
        return self.cell.wait_until_it_stands(self.arm, lambda status: runs(status) and self.cell.entry(status, self.arm)["state"]["mode"] == "running")


class Unreachable(OfGoal):
    goal, kind = ("--position", "5", "0", "0.5"), "goal_unreachable"

    def begin(self):
        self.cell.refused(self.arm, *self.goal)

    def causes(self):
        return [(self.kind, "")]


class OutsideLimits(Unreachable):
    goal, kind = ("--joints", "0", "-1.9", "99", "0", "0.6", "0"), "goal_outside_limits"


class InCollision(Unreachable):
    goal, kind = ("--position", *CENTRE), "goal_in_collision"

    def begin(self):
        self.cell.edit("add", "ball", "--sphere", "0.1", "--pose", *CENTRE, "0", "0", "0")
        super().begin()

    def end(self):
        self.cell.edit("remove", "ball")


class TimeLimit(OfGoal):
    def begin(self):
        self.cell.ask("goal", self.arm, "--position", *CENTRE, "--time-limit", "300ms")
        self.cell.wait_for("the time limit", lambda status: self.cell.entry(status, self.arm)["goal"]["state"] == "timed_out")

    def causes(self):
        return [("time_limit", "")]


class NoGoal(OfGoal):
    def begin(self):
        self.cell.reach(self.arm, "ready")

    def causes(self):
        return [("no_goal", "")]


class InTheWay(Stop):
    """A body keeps the arm from its goal. The arm may go on to search a way."""

    REST = 24  # statuses: six seconds

    def at(self):
        """The goal goes on, and the arm has come no nearer to it for a while."""
        nearest, since = float("inf"), 0
        last = None

        def late(status):
            nonlocal nearest, since, last
            if status is last:
                return False
            last = status
            goal = self.cell.entry(status, self.arm)["goal"]
            away = goal["distance_to_goal"]
            nearest, since = (away, 0) if away < nearest - NEARER else (nearest, since + 1)
            return since > self.REST
        self.cell.wait_for(f"arm {self.arm} comes no nearer", late)
        return unix_ms()


class ObstacleInTheWay(InTheWay):
    def begin(self):
        """The goal is accepted before the obstacle comes, and the arm sets out after it."""
        self.cell.ask("hold", self.arm)
        self.cell.ask("goal", self.arm, "--position", *CENTRE)
        self.cell.edit("add", "ball", "--sphere", "0.1", "--pose", *CENTRE, "0", "0", "0")
        self.cell.ask("resume", self.arm)
        self.cell.wait_until_it_moves(self.arm)

    def end(self):
        self.cell.edit("remove", "ball")

    def causes(self):
        return [("path_blocked", "ball")]


class ArmInTheWay(InTheWay):
    def begin(self):
        self.cell.reach_position(self.other, CENTRE)
        self.cell.ask("hold", self.other)
        self.cell.ask("goal", self.arm, "--position", *CENTRE)
        self.cell.wait_until_it_moves(self.arm)

    def end(self):
        self.cell.ask("resume", self.other)
        self.cell.reach(self.other, "home")

    def causes(self):
        return [("path_blocked", f"{self.other}/")]


CAUSES = {"hold": Order, "hold of the cell": HoldOfCell, "stop": StopOrder, "stop of the cell": StopOfCell, "driver dies": DriverDies,
          "planner dies": PlannerDies, "world dies": WorldDies, "driver hangs": DriverHangs, "planner hangs": PlannerHangs,
          "world hangs": WorldHangs, "host lost": HostLost, "observed": Observed, "unreachable goal": Unreachable,
          "goal outside limits": OutsideLimits, "goal in collision": InCollision, "time limit": TimeLimit, "no goal": NoGoal,
          "obstacle in the way": ObstacleInTheWay, "arm in the way": ArmInTheWay}


class Cell(LiveCell):
    """With what the stops need."""

    def ask(self, *words):
        return super().ask(*words, "--connect-timeout", f"{TIMEOUT}s")

    def edit(self, *words):
        """Edits obstacles. A request that the world misses, because it finds the client later than the client the world, is repeated."""
        for _ in range(EDITS):
            edited = self._ask("obstacle", *words, "--connect-timeout", "5s", stderr=subprocess.STDOUT)
            said = edited.communicate()[0]
            if edited.returncode != TIME_OUT:
                break
        if edited.returncode != 0:
            raise AssertionError(f"hecaton obstacle {' '.join(words)}: exit code {edited.returncode}: {said}")

    def recover(self):
        """After a failed try: no order and no obstacle of it remains. What is not there is refused, which is fine."""
        orders = [("resume",), *(("resume", arm["name"]) for arm in self.plan()["arms"]), ("obstacle", "remove", "ball")]
        orders += [("device", arm["name"], "command") for arm in self.plan()["arms"]]
        for words in orders:
            self._ask(*words, stderr=subprocess.STDOUT).communicate()

    def entry(self, status, arm):
        return next(entry for entry in status["arms"] if entry["name"] == arm)

    def host_of(self, node):
        return next(entry["host"] for entry in self.status()["nodes"] if entry["node"] == node)

    def reach(self, arm, pose):
        self.wait_for_goal(self.goal(arm, pose))

    def reach_position(self, arm, position):
        self.ask("goal", arm, "--position", *position, "--wait")

    def set_out(self, arm):
        self.ask("goal", arm, "--named", "ready")
        self.wait_until_it_moves(arm)

    def refused(self, arm, *goal):
        asked = self._ask("goal", arm, *goal, stderr=subprocess.STDOUT)
        said = asked.communicate()[0]
        if asked.returncode != 1:
            raise AssertionError(f"goal {goal} was not refused: {said}")

    def wait_until_it_stands(self, arm, healthy=lambda status: True):
        """Its joints rest, in a healthy cell, in four statuses one after the other: for a second."""
        rests = []

        def stands(status):
            fastest = max(map(abs, self.entry(status, arm)["state"]["qd"]))
            if not rests or rests[-1][0] is not status:
                rests.append((status, fastest < STANDS and healthy(status)))
            return len(rests) > 4 and all(rest for _, rest in rests[-4:])
        self.wait_for(f"arm {arm} stands", stands)
        return unix_ms()

    def wait_for_status(self):
        """The next one: what happens after it is later than all times before it."""
        last = self.status()
        self.wait_for("a status", lambda status: status is not last)


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--cell", type=pathlib.Path, required=True)
    parser.add_argument("--stops", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", choices=CAUSES, default=list(CAUSES))
    parser.add_argument("--timeout-scale", type=int, default=1)
    parser.add_argument("--record", type=pathlib.Path)
    return parser.parse_args()


def drawn(rng, arms, options):
    """The causes in a random order, all equally often, with two arms for each."""
    names = [options.only[i % len(options.only)] for i in range(options.stops)]
    rng.shuffle(names)
    return [(name, *rng.sample(arms, 2)) for name in names]


def explained(hecaton, recording, arm, at):
    """What `hecaton explain` says, and the (kind, subject) of its sentences about the stop, the goal, and the body in the way."""
    done = subprocess.run([hecaton, "explain", recording, "--arm", arm, "--at", f"{at:.3f}", "-o", "json"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        return [done.stderr], []
    sentences = json.loads(done.stdout)["sentences"]
    about = [sentence for sentence in sentences if sentence.startswith((f"{arm} waits for", "Goal "))]
    causes = [(found[1], found[2] or "") for found in map(CAUSE.search, about) if found]
    # At that time, the one that bound it the longest, and the one that did when the arm was nearest to its goal.
    bodies = [found[1] for found in map(BINDING.search, sentences) if found]
    return sentences, causes + [("path_blocked", body) for body in bodies[-1:]]


def judge(stop, causes):
    """An ended goal is why the arm has none; a goal that goes on is no reason while something else stops the arm."""
    wanted = stop.causes()
    first = causes[:1] if causes and causes[0][0] != "no_goal" or wanted[0][0] == "no_goal" else causes
    return any(kind == right and subject.startswith(of) for kind, subject in first for right, of in wanted)


def cause(cell, name, arm, other):
    """Causes one stop, and ends its cause; returns the stop with its time."""
    stop = CAUSES[name](cell, arm, other)
    cell.wait_until_it_runs()
    cell.reach(arm, "home")
    try:
        stop.begin()
        at = stop.at()
        cell.wait_for_status()
    finally:
        stop.end()  # also after a failure: a cause that stays would spoil all later stops
    return name, stop, at


def run(cell, options, arms, stops):
    """Appends the stops that could be caused, with their names and times."""
    for number, (name, arm, other) in enumerate(drawn(random.Random(options.seed), arms, options), 1):
        print(f"{number} of {options.stops}: {name}, {arm}", file=sys.stderr, flush=True)
        for attempt in range(1, TRIES + 1):
            try:
                stops.append(cause(cell, name, arm, other))
                break
            except FAILURES as error:
                print(f"{'NOT TESTED' if attempt == TRIES else 'again'}: {name}, {arm}: {error!r:.2000}", flush=True)
                cell.recover()


def report(stops, hecaton, recording):
    """Prints the figures; returns the number of wrong explanations."""
    info = json.loads(subprocess.run([hecaton, "bag", "info", recording, "-o", "json"], capture_output=True, text=True).stdout)
    counts = collections.defaultdict(lambda: [0, 0])
    for name, stop, at in stops:
        sentences, causes = explained(hecaton, recording, stop.arm, at / 1000.0 - info["first_ns"] * 1e-9)
        right = judge(stop, causes)
        counts[name][0] += right
        counts[name][1] += 1
        if not right:
            print(f"WRONG: {name}, {stop.arm}, expected {stop.causes()}:", *sentences, sep="\n  ")
    for name, (right, of) in sorted(counts.items()):
        print(f"{name:20} {right} of {of} right")
    right, of = (sum(count[i] for count in counts.values()) for i in (0, 1))
    print(f"{right} of {of} stops explained right")
    return of - right


def interrupt(_number):
    raise KeyboardInterrupt


def main():
    options = parse()
    try:
        namespaces.enter()
        ending.Ending(interrupt)
        hosts = namespaces.Namespaces(options.programs.resolve() / "hecaton")
    except CannotRun as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        return SKIPPED
    folder = pathlib.Path(tempfile.mkdtemp(prefix="hecaton-explain-"))
    document = cell_document.read(options.cell.read_bytes())
    cell_copy.make_paths_absolute(document, options.cell.parent.absolute())
    cell_copy.scale_timeouts(document, options.timeout_scale)
    document["obstacles"] = []
    cell_file = folder / "cell.yaml"
    cell_file.write_text(cell_document.write(document), encoding="utf-8")
    hecaton = str(options.programs.resolve() / "hecaton")
    recording = str(options.record or folder / "stops.mcap")
    cell = Cell(hosts, hecaton, cell_file, folder)
    print(f"logs and recording are in {folder}", file=sys.stderr)
    began = time.monotonic()
    stops = []
    try:
        cell.start()
        cell.wait_until_it_runs()
        cell.record(recording)
        try:
            run(cell, options, [arm["name"] for arm in cell.plan()["arms"]], stops)
        except KeyboardInterrupt:
            print("ended before all stops", flush=True)
        said, = cell.end_recordings()
    finally:
        cell.stop()
        hosts.close()
    print(f"{len(stops)} of {options.stops} stops in {time.monotonic() - began:.0f} s; {said.splitlines()[0]}")
    wrong = report(stops, hecaton, recording)
    return 1 if wrong or len(stops) < options.stops else 0


if __name__ == "__main__":
    sys.exit(main())
