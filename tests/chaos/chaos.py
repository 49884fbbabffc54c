"""Faults at random, from a seed, against a cell of three arms with standbys on five hosts, while the arms work.

usage: chaos.py --programs DIR --cell FILE [--faults N | --quiet MINUTES] [--seed S] [--only KIND…] [--of NAME…]
                [--alone] [--no-standbys] [--logs DIR] [--report FILE]

An episode is one to three faults at a time; one with --alone, so that the figures are of each kind of fault, and with --of
of one kind of process. All the time no contact may be seen, and no arm may follow an older term or two planners in one;
every fault must be told and blamed on who had it, and nothing else; after each episode the cell must run again and every
goal be reached. With --quiet nothing is done to the cell, and every fault that it tells is a false one. Obstacles stand still: an arm whose driver is dead cannot
make way. SIGTERM (`pkill -f chaos.py`) ends it after the episode under way, with what it found so far. Exit code 0: all
of it held; 1: not, and what did not is in the output; 70: what did not was a contact or an older command; 75: not, while the
machine itself stood still; 77: no hosts here."""
import argparse
import collections
import heapq
import itertools
import json
import pathlib
import random
import re
import signal
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "container"))
import namespaces  # noqa: E402
from hosts import CannotRun  # noqa: E402
from figures import figures, log_figures, quantiles  # noqa: E402
from injections import KINDS, LEASE, SILENCE, draw  # noqa: E402
from live_cell import LiveCell, still_text, unix_ms  # noqa: E402
from steadiness import UNSAFE, UNSTEADY, TimerLateness  # noqa: E402

SKIPPED = 77
ARMS = ("north", "west", "east")
STANDBYS = {"north-pc": "west-pc", "west-pc": "east-pc", "east-pc": "north-pc", "supervisor-pc": "world-pc"}
DISCARDS = 20  # episodes at most whose findings are put down to a machine that stood still
LATE = 10.0  # [s] within which a fault that must be told is told
RETURN = 3.0  # [s] after a host's return, in which the silence of what runs there is put down to that; a supervisor that
# was cut off itself sees every host return


def cell_text(text, folder, standbys):
    """The cell file with obstacles that stand still, and a standby for every planner and for the supervisor if
    `standbys`."""
    text = still_text(text, folder)
    for host, standby in STANDBYS.items() if standbys else ():
        text, count = re.subn(rf"^( +)host: {host}$", rf"\1host: {host}\n\1standby_host: {standby}", text, flags=re.M)
        if count != 1:
            raise ValueError(f"the cell file has {count} lines 'host: {host}'; 1 is wanted")
    # Roles are not exchanged because a machine that is shared stalls.
    return text.replace("  host_lease: 1s\n", "  host_lease: 1s\n  takeover_lease: 150ms\n")


class Violation(Exception):
    """What must not be. `account`: the key of the report that counts such."""

    def __init__(self, account, what):
        super().__init__(what)
        self.account = account


ACCOUNTS = ("contacts", "stale_commands_accepted", "wrong_attributions", "false_faults", "missed_faults")


class Chaos:
    def __init__(self, cell, options):
        self.cell = cell
        self.only = options.only
        self.alone = options.alone
        self.of = tuple(options.of)
        # In turn: who is killed ten times in a row within 10 s of life is given up.
        self.turns = itertools.cycle(self.of)
        self.rng = random.Random(options.seed)
        self.lateness = TimerLateness()
        self.faults = 0
        self.known = set()
        self.detection = collections.defaultdict(list)  # [ms] by kind of injection
        self.recovery = collections.defaultdict(list)   # [s]
        self.violations = []
        self.accounts = dict.fromkeys(ACCOUNTS, 0)
        self.told_to_end = False
        self.tasks = 0
        self.reached = 0
        self.supervisor_returned = 0  # [ms, wall clock]
        self.returned_before = 0  # the same when this episode began
        self.discarded = 0  # episodes
        self.machine_stalls = 0  # faults told of processes that stood still with the machine
        self.began = self.ended = unix_ms()  # the episode
        self.pose = "home"

    def run(self, faults):
        self.learn()
        while self.faults < faults and not self.violations and not self.told_to_end:
            self.episode()
            self.ended = unix_ms()
            if self.says_nothing() and self.discarded < DISCARDS:
                self.discard()

    def discard(self):
        """The episode: what it found is the machine's doing."""
        print(f"says nothing, for the machine stood still: {self.violations.pop()}", flush=True)
        self.accounts = dict.fromkeys(ACCOUNTS, 0)
        self.discarded += 1
        try:
            self.cell.wait_until_it_runs()
        except AssertionError as error:
            self.violated("return after the machine stood still", error)

    def stay_quiet(self, minutes):
        """The arms work, nothing happens to them, nothing may be told."""
        self.learn()
        end = time.monotonic() + 60.0 * minutes
        self.known = set(self.cell.faults())
        self.began = unix_ms()
        while time.monotonic() < end and not self.violations and not self.told_to_end:
            try:
                self.await_goals(self.give_goals())
                self.check([], [])
            except (AssertionError, Violation) as error:
                self.violated("quiet", error)
                self.ended = unix_ms()

    def end_early(self, *_):
        """After this episode."""
        self.told_to_end = True

    def learn(self):
        self.cell.wait_until_it_runs()
        status = self.cell.status()
        self.nodes = {entry["node"]: entry["host"] for entry in status["nodes"] if not entry["node"].startswith("agent/")}
        self.hosts = {entry["host"] for entry in status["hosts"]}
        for name in self.of:
            if not self.victims(name):
                raise SystemExit(f"--of {name}: no service's name begins so; they are {', '.join(self.nodes)}")

    def victims(self, name):
        """{node: host} of all services whose names begin so."""
        return {node: host for node, host in self.nodes.items() if node.startswith(name)}

    def give_goals(self):
        self.pose = "ready" if self.pose == "home" else "home"
        self.tasks += len(ARMS)
        return [self.cell.goal(arm, self.pose) for arm in ARMS]

    def await_goals(self, goals):
        for goal in goals:
            self.cell.wait_for_goal(goal)
            self.reached += 1

    def violated(self, during, error):
        self.violations.append(f"{during}: {error}")
        if isinstance(error, Violation):
            self.accounts[error.account] += 1

    def episode(self):
        self.known = set(self.cell.faults())
        self.began = unix_ms()
        goals = self.give_goals()
        injections = []
        for _ in range(1 if self.alone else self.rng.choice((1, 1, 1, 2, 2, 3))):
            injection = draw(self.rng, self.victims(next(self.turns)), self.hosts, self.only, self.alone)
            # Of one victim only one thing at a time can be told.
            hosts = [other.host for other in injections]
            if injection.host not in hosts:
                injections.append(injection)
        expected = [injection.expected(self.cell) for injection in injections]
        began = time.monotonic()
        try:
            injected = self.inflict(injections)
            self.await_told(injections, expected, injected)
            # For what shows later than the cell runs again there is nothing to wait for.
            time.sleep(max(injection.aftermath for injection in injections))
            self.cell.wait_until_it_runs()
            healed = time.monotonic()
            self.await_goals(goals)
            self.check(injections, expected)
        except (AssertionError, Violation) as error:
            self.violated(f"episode of {', '.join(map(str, injections))}", error)
            return
        self.faults += len(injections)
        longest = max(injection.duration for injection in injections)
        for injection in injections:
            self.recovery[injection.kind()].append(healed - began - longest)
        print(f"{self.faults}: {', '.join(f'{one} ({one.duration:.1f} s)' for one in injections)}: "
              f"{healed - began:.1f} s, {time.monotonic() - began:.1f} s with the goals", flush=True)

    def inflict(self, injections):
        """Returns when each began [ms, wall clock]. On a busy machine one may take so long to begin that the next begins late:
        it lasts for its time all the same."""
        agenda = [(self.rng.uniform(0.0, 0.5), index, "begin") for index in range(len(injections))]
        heapq.heapify(agenda)
        injected = {}
        self.returned_before = self.supervisor_returned
        start = time.monotonic()
        while agenda:
            at, index, act = heapq.heappop(agenda)
            injection = injections[index]
            time.sleep(max(0.0, start + at - time.monotonic()))
            if act == "begin":
                injected[index] = unix_ms()
                injection.begin(self.cell)
                heapq.heappush(agenda, (time.monotonic() - start + injection.duration, index, "end"))
            else:
                injection.end(self.cell)
            if injection.blinds():
                self.supervisor_returned = unix_ms()
        return injected

    def await_told(self, injections, expected, injected):
        blind = any(injection.blinds() for injection in injections)
        for index, (injection, wanted) in enumerate(zip(injections, expected)):
            if not wanted.kinds or (blind and len(injections) > 1) or self.returns(injection, injected[index]):
                continue

            def told(_status):
                return next((fault for key, fault in self.cell.faults().items() if key not in self.known
                             and fault["kind"] in wanted.kinds and fault["subject"] == wanted.subject), None)

            what = f"{injection}: {' or '.join(wanted.kinds)} of {wanted.subject} is told"
            try:
                fault = self.cell.wait_for(what, told, LATE)
            except AssertionError as error:
                raise Violation("missed_faults", error) from error
            if len(injections) == 1:  # beside others it may be hidden for a while, or told by a clock that jumped
                self.detection[injection.kind()].append(fault["since_unix_ms"] - injected[index])

    def returns(self, injection, at):
        """A process hangs whose host has just come back: that need not be told."""
        if injection.name != "stop":
            return False
        returned = self.returned_before if self.alone else self.supervisor_returned
        return at < returned + 1000 * RETURN or any(
            fault["kind"] == "agent_lost" and fault["subject"] == injection.host
            and fault["since_unix_ms"] + 1000 * (fault["duration_s"] + RETURN) > at
            for fault in self.cell.faults().values())

    def check(self, injections, expected):
        if self.cell.contacts() != 0:
            raise Violation("contacts", f"{self.cell.contacts()} contacts\n{self.cell.account()}")
        victims = {victim for wanted in expected for victim in wanted.victims}
        blind = any(injection.blinds() for injection in injections)
        for key, fault in self.cell.faults().items():
            if key in self.known or fault["subject"] in victims:
                continue
            # What another supervisor told before, in its own account, is history when it comes to light.
            if fault["cleared"] and fault["since_unix_ms"] < self.began:
                continue
            # A supervisor that was itself away or cut off sees others lost, and says of itself that it was away.
            if blind and (fault["subject"].startswith("supervisor") or fault["kind"] in ("agent_lost", "node_silent")):
                continue
            # Silent, it is: where a timer is late by half of what may be silent, a process may be by the whole.
            told = fault["since_unix_ms"]
            silence = {"node_silent": SILENCE, "agent_lost": LEASE}.get(fault["kind"])
            if silence and self.lateness.stood_still(told - 2000 * silence, told + 100, silence / 2):
                self.machine_stalls += 1
                continue
            raise Violation("wrong_attributions" if injections else "false_faults",
                            f"wrongly accused: {fault['kind']} of {fault['subject']}: {fault['seen']}")
        check_terms(self.cell.log_lines())

    def says_nothing(self):
        """What was found may be put down to a machine that stood still: never a contact, nor whom an arm follows."""
        return self.violations and not self.unsafe() and self.lateness.stood_still(self.began, self.ended)

    def unsafe(self):
        return bool(self.accounts["contacts"] or self.accounts["stale_commands_accepted"])

    def report(self, seed):
        gaps, rests = log_figures(self.cell.log_lines())
        return {"faults": self.faults, **self.accounts, "tasks": self.tasks, "reached": self.reached, "seed": seed,
                "detection_ms": {name: quantiles(self.detection[name]) for name in sorted(self.recovery)},
                "runs_again_s": {name: quantiles(self.recovery[name]) for name in sorted(self.recovery)},
                "standby_gap_ms": quantiles(gaps), "arm_stop_ms": quantiles(rests),
                "timer_lateness_ms": quantiles(self.lateness.late),
                "silent_because_the_machine_stood_still": self.machine_stalls, "discarded_episodes": self.discarded,
                "violations": self.violations}

    def summary(self):
        gaps, rests = log_figures(self.cell.log_lines())
        print(f"\n{self.reached} of {self.tasks} goals reached; {self.faults} faults; "
              "told after p50, p99, max; runs again after p50, p99, max")
        for name in sorted(self.recovery):
            print(f"{name:22} {len(self.recovery[name]):5} {figures(self.detection[name])}   "
                  f"{figures(self.recovery[name], 's')}")
        print(f"{'timers are late by':28} {figures(self.lateness.late)}; "
              f"{self.machine_stalls} processes were silent because the machine stood still, "
              f"{self.discarded} episodes say nothing for the same reason")
        print(f"{'commands of a standby':22} {len(gaps):5} {figures(gaps)} after the last of its predecessor")
        print(f"{'arms came to rest':22} {len(rests):5} {figures(rests)} after their last command")


def check_terms(lines):
    """What the drivers logged: each follows terms that never fall, and in a term one planner."""
    newest = {}
    followed = {}
    for line in lines:
        found = re.search(r"node=driver/(\S+) event=follows planner=(\S+) term=(\d+)", line)
        if not found:
            continue
        arm, planner, term = found[1], found[2], int(found[3])
        if term < newest.get(arm, 0):
            raise Violation("stale_commands_accepted", f"arm {arm} followed term {term} after {newest[arm]}")
        newest[arm] = term
        if followed.setdefault((arm, term), planner) != planner:
            raise Violation("stale_commands_accepted",
                            f"arm {arm} followed {followed[arm, term]} and {planner} in term {term}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="folder of hecaton's programs")
    parser.add_argument("--cell", type=pathlib.Path, required=True, help="cell file of five hosts")
    parser.add_argument("--faults", type=int, default=30, help="at least so many (30)")
    parser.add_argument("--quiet", type=float, metavar="MINUTES", help="no faults: so long nothing may be told")
    parser.add_argument("--seed", type=int, default=1, help="of what happens to whom (1)")
    parser.add_argument("--only", nargs="+", choices=KINDS, default=KINDS, metavar="KIND",
                        help=f"of these kinds ({', '.join(KINDS)})")
    parser.add_argument("--alone", action="store_true", help="one fault at a time, that lasts long enough to be told")
    parser.add_argument("--of", nargs="+", default=[""], metavar="NAME",
                        help="whose processes are killed and stopped: names begin so; of each in turn (driver planner …)")
    parser.add_argument("--no-standbys", action="store_true", help="the cell as its file is, without standbys")
    parser.add_argument("--logs", type=pathlib.Path, help="folder for the hosts' logs")
    parser.add_argument("--report", type=pathlib.Path, metavar="FILE", help="also write the figures there, as JSON")
    options = parser.parse_args()
    hecaton = options.programs.resolve() / "hecaton"
    try:
        namespaces.enter()
        hosts = namespaces.Namespaces(hecaton, own_clocks="clock" in options.only)
    except CannotRun as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        return SKIPPED
    logs = options.logs or pathlib.Path(tempfile.mkdtemp(prefix="hecaton-chaos-"))
    logs.mkdir(parents=True, exist_ok=True)
    cell_file = logs / "cell.yaml"
    cell_file.write_text(cell_text(options.cell.read_text(), options.cell.resolve().parent, not options.no_standbys))
    print(f"seed {options.seed}; hosts are {hosts.kind}; their logs are in {logs}", flush=True)
    cell = LiveCell(hosts, hecaton, cell_file, logs)
    cell.start()
    chaos = Chaos(cell, options)
    signal.signal(signal.SIGTERM, chaos.end_early)
    if options.quiet is None:
        chaos.run(options.faults)
    else:
        chaos.stay_quiet(options.quiet)
    codes = cell.stop()
    chaos.summary()
    if options.report:
        options.report.write_text(json.dumps(chaos.report(options.seed), indent=2, ensure_ascii=False) + "\n")
    for violation in chaos.violations:
        print(f"VIOLATION: {violation}")
    if any(codes.values()):
        print(f"agents ended with {codes}")
    if chaos.unsafe():
        return UNSAFE
    if chaos.says_nothing():
        print("the machine stood still meanwhile")
        return UNSTEADY
    return 1 if chaos.violations or any(codes.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
