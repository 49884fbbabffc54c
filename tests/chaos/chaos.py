"""Faults at random, from a seed, against a cell of three arms with standbys on five hosts, while the arms work.

usage: chaos.py --programs DIR --cell FILE [--faults N] [--minutes M] [--quiet MINUTES] [--seed S] [--only KIND…]
                [--of NAME…] [--alone] [--no-standbys] [--findings N] [--logs DIR] [--report FILE]

An episode is one to three faults at a time; one with --alone, so that the figures are of each kind of fault, and with --of
of one kind of process. All the time no contact may be seen, and no arm may follow an older term or two planners in one
(terms.py); every fault must be told as what it is and blamed on who had it, and nothing else (verdicts.py); after each episode
the cell must run again and every goal be reached. With --quiet nothing is done to the cell, and every fault that it tells is a
false one. Obstacles stand still: an arm whose driver is dead cannot make way. The first finding ends it, with --findings N the
Nth, but what is unsafe always does. SIGTERM ends it after the episode under way, with what it found so far. Exit code 0: all of
it held; 1: not, and what did not is in the output; 70: what did not was a contact, an older command or a driver's memory; 75:
not, while the machine itself stood still; 77: no hosts here."""
import argparse
import collections
import heapq
import itertools
import json
import math
import pathlib
import random
import signal
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "container"))
import namespaces  # noqa: E402
from hosts import CannotRun  # noqa: E402
from figures import LOG_FIGURES, figures, log_figures, quantiles  # noqa: E402
from injections import KINDS, LEASE, SILENCE, draw, together  # noqa: E402
from live_cell import LiveCell, standby_text, still_text, unix_ms  # noqa: E402
from steadiness import UNSAFE, UNSTEADY, TimerLateness  # noqa: E402
from terms import LogTerms, StatusTerms  # noqa: E402
from verdicts import hidden, may_be_told, supervisors_hit  # noqa: E402

SKIPPED = 77
ARMS = ("north", "west", "east")
DISCARDS = 20  # episodes at most whose findings are put down to a machine that stood still
LATE = 10.0  # [s] within which a fault that must be told is told
# [s] for which a supervisor puts the silence of a host's processes down to its return: at most, and once it hears them
# again. One that was cut off itself sees every host return.
RETURN = 5.0
SURE_RETURN = 1.0


class Violation(Exception):
    """What must not be. `account`: the key of the report that counts such. `span` [ms, wall clock]: if the machine stood still
    in it, that may be why; None: in the whole episode."""

    def __init__(self, account, what, span=None):
        super().__init__(what)
        self.account = account
        self.span = span


NEVER = (math.inf, -math.inf)
SILENCES = ("node_silent", "agent_lost", "driver_silent", "world_silent")  # what a machine that stands still makes of anybody
UNSAFE_ACCOUNTS = ("contacts", "stale_commands_accepted", "memories_lost")
ACCOUNTS = (*UNSAFE_ACCOUNTS, "wrong_attributions", "false_faults", "missed_faults")


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
        self.told = collections.Counter()  # by kind of injection, like the next two; only of what had to be told
        self.detection = collections.defaultdict(list)  # [ms]
        self.recovery = collections.defaultdict(list)   # [s]
        self.findings = options.findings
        self.violations = []
        self.span = self.account = None  # of the last one
        self.accounts = dict.fromkeys(ACCOUNTS, 0)
        self.told_to_end = False
        self.tasks = 0
        self.reached = 0
        self.supervisor_returned = 0  # [ms, wall clock]
        self.returned_before = 0  # the same when this episode began
        self.ran_again = time.monotonic()  # the leader heard everybody
        self.discarded = 0  # episodes
        self.untold = 0  # faults that no supervisor told while one led that was cut off before
        self.machine_stalls = 0  # faults told of processes that stood still with the machine
        self.began = self.ended = unix_ms()  # the episode
        self.pose = "home"
        self.log_terms = LogTerms()
        self.status_terms = StatusTerms()
        self.led = set()  # (supervisor, term) since this episode began
        cell.listeners += [self.status_terms.hear, self.hear_leader]

    def hear_leader(self, status):
        self.led.add((status["supervisor"], status["term"]))

    def run(self, faults, minutes):
        self.learn()
        end = time.monotonic() + 60.0 * minutes
        while self.faults < faults and time.monotonic() < end and not self.over():
            found = len(self.violations)
            self.episode()
            self.ended = unix_ms()
            if len(self.violations) == found:
                continue
            if self.says_nothing() and self.discarded < DISCARDS:
                self.discard()
            if not self.over():
                self.go_on()

    def over(self):
        return self.told_to_end or self.unsafe() or len(self.violations) >= self.findings

    def discard(self):
        """The episode: what it found is the machine's doing."""
        print(f"says nothing, for the machine stood still: {self.violations.pop()}", flush=True)
        if self.account:
            self.accounts[self.account] -= 1
        self.discarded += 1

    def go_on(self):
        before = self.cell.status()
        try:
            self.cell.wait_for("somebody tells of the cell", lambda status: status is not before)
            self.wait_until_it_runs()
        except AssertionError as error:
            self.findings = 0  # nothing works any more
            self.violated("return after that", error)

    def stay_quiet(self, minutes):
        """The arms work, nothing happens to them, nothing may be told."""
        self.learn()
        end = time.monotonic() + 60.0 * minutes
        self.known = set(self.cell.faults())
        self.began = unix_ms()
        while time.monotonic() < end and not self.over():
            try:
                self.await_goals(self.give_goals())
                self.check([])
            except (AssertionError, Violation) as error:
                self.violated("quiet", error)
                self.known = set(self.cell.faults())
                self.ended = unix_ms()

    def end_early(self, *_):
        """After this episode."""
        self.told_to_end = True

    def wait_until_it_runs(self):
        self.cell.wait_until_it_runs()
        self.ran_again = time.monotonic()

    def learn(self):
        self.wait_until_it_runs()
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
        print(f"found after {self.faults} faults: {self.violations[-1]}", flush=True)
        self.span = getattr(error, "span", None)
        self.account = getattr(error, "account", None)
        if self.account:
            self.accounts[self.account] += 1

    def episode(self):
        time.sleep(max(0.0, self.ran_again + SURE_RETURN - time.monotonic()))  # no silence is put down to a return any more
        self.known = set(self.cell.faults())
        self.began = unix_ms()
        self.led = set()
        status = self.cell.status()
        self.hear_leader(status)
        self.leader = status["supervisor"]
        goals = self.give_goals()
        injections = []
        for _ in range(1 if self.alone else self.rng.choice((1, 1, 1, 2, 2, 3))):
            injection = draw(self.rng, self.victims(next(self.turns)), self.hosts, self.only, self.alone)
            if all(together(injection, other) for other in injections):
                injections.append(injection)
        began = time.monotonic()
        try:
            injected = self.inflict(injections)
            self.await_told(injections, injected)
            # For what shows later than the cell runs again there is nothing to wait for.
            time.sleep(max(injection.aftermath for injection in injections))
            self.wait_until_it_runs()
            healed = self.ran_again
            self.await_goals(goals)
            self.check(injections)
        except (AssertionError, Violation) as error:
            self.violated(f"episode of {', '.join(f'{one} ({one.lasted:.2f} s)' for one in injections)}", error)
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
        began = {}
        self.returned_before = self.supervisor_returned
        start = time.monotonic()
        while agenda:
            at, index, act = heapq.heappop(agenda)
            injection = injections[index]
            time.sleep(max(0.0, start + at - time.monotonic()))
            if act == "begin":
                injected[index] = unix_ms()
                began[index] = time.monotonic()
                injection.begin(self.cell)
                heapq.heappush(agenda, (time.monotonic() - start + injection.duration, index, "end"))
            else:
                injection.end(self.cell)
                injection.lasted = time.monotonic() - began[index]
            if injection.hits(self.nodes):
                self.supervisor_returned = unix_ms()
        return injected

    def await_told(self, injections, injected):
        for index, injection in enumerate(injections):
            wanted = injection.must()
            if not wanted or hidden(injection, injections, self.nodes, self.leader):
                continue

            def told(_status):
                return next((fault for key, fault in self.cell.faults().items() if key not in self.known
                             and (fault["kind"], fault["subject"]) == wanted), None)

            what = f"{injection}: {wanted[0]} of {wanted[1]} is told"
            try:
                fault = self.cell.wait_for(what, told, LATE)
            except AssertionError as error:
                if self.newcomer_leads(injections):
                    self.untold += 1
                    print(f"nobody told, while the leadership moved to who was cut off before: {what}", flush=True)
                    continue
                span = (injected[index], injected[index] + 1000 * injection.lasted)
                raise Violation("missed_faults", error, span) from error
            self.told[injection.kind()] += 1
            if len(injections) == 1:  # beside others it may be hidden for a while, or told by a clock that jumped
                self.detection[injection.kind()].append(fault["since_unix_ms"] - injected[index])

    def newcomer_leads(self, injections):
        """A supervisor that was cut off until just before, or that a busy machine kept from hearing the leader: it tells no more
        than what is wrong when it begins to lead, and takes what is silent for returning."""
        by_itself = self.leader not in supervisors_hit(injections, self.nodes)
        return len(self.led) > 1 and (by_itself or self.began < self.returned_before + 1000 * RETURN)

    def check(self, injections):
        if self.cell.contacts() != 0:
            raise Violation("contacts", f"{self.cell.contacts()} contacts\n{self.cell.account()}")
        self.check_terms()
        allowed = may_be_told(injections, self.nodes)
        for key, fault in self.cell.faults().items():
            if key in self.known or (fault["kind"], fault["subject"]) in allowed:
                continue
            # What another supervisor told before, in its own account, is history when it comes to light.
            if fault["cleared"] and fault["since_unix_ms"] < self.began:
                continue
            # Silent, it is: where a timer is late by half of what may be silent, a process may be by the whole.
            told = fault["since_unix_ms"]
            silence = {"node_silent": SILENCE, "agent_lost": LEASE}.get(fault["kind"])
            if silence and self.lateness.stood_still(told - 2000 * silence, told + 100, silence / 2):
                self.machine_stalls += 1
                continue
            raise Violation("wrong_attributions" if injections else "false_faults",
                            f"wrongly accused: {fault['kind']} of {fault['subject']}: {fault['seen']}",
                            None if fault["kind"] in SILENCES else NEVER)

    def check_terms(self):
        """What the drivers have told since the last time. Here no host loses its memory, so no driver may."""
        for line in self.cell.new_log_lines():
            self.log_terms.hear(line)
        for complaint in self.log_terms.complaints + self.status_terms.complaints:
            raise Violation("stale_commands_accepted", complaint)
        if self.log_terms.forgotten:
            raise Violation("memories_lost", f"drivers began without memory: {', '.join(self.log_terms.forgotten)}")

    def check_the_rest(self):
        """What came after the last episode's check."""
        try:
            if not self.unsafe():
                self.check_terms()
        except Violation as error:
            self.violated("the end", error)

    def says_nothing(self):
        """What was found may be put down to a machine that stood still meanwhile: never a contact, nor whom an arm follows."""
        since, until = self.span or (self.began, self.ended)
        return bool(self.violations) and not self.unsafe() and self.lateness.stood_still(since, until)

    def unsafe(self):
        return any(self.accounts[account] for account in UNSAFE_ACCOUNTS)

    def report(self, seed):
        return {"faults": self.faults, **self.accounts, "tasks": self.tasks, "reached": self.reached, "seed": seed,
                "told": dict(sorted(self.told.items())),
                "detection_ms": {name: quantiles(self.detection[name]) for name in sorted(self.recovery)},
                "runs_again_s": {name: quantiles(self.recovery[name]) for name in sorted(self.recovery)},
                **{key: quantiles(values) for key, values in log_figures(self.cell.log_lines()).items()},
                "timer_lateness_ms": quantiles(self.lateness.late),
                "silent_because_the_machine_stood_still": self.machine_stalls, "discarded_episodes": self.discarded,
                "untold_while_the_leadership_moved": self.untold, "followed": self.log_terms.followed,
                "replaced_planners_refused": len(self.log_terms.refused),
                "violations": self.violations}

    def summary(self):
        print(f"\n{self.reached} of {self.tasks} goals reached; {self.faults} faults; "
              "so many had to be told and were; those alone after p50, p99, max; runs again after p50, p99, max")
        for name in sorted(self.recovery):
            print(f"{name:22} {len(self.recovery[name]):5} {self.told[name]:5} {figures(self.detection[name])}   "
                  f"{figures(self.recovery[name], 's')}")
        print(f"{'timers are late by':28} {figures(self.lateness.late)}; "
              f"{self.machine_stalls} processes were silent because the machine stood still, "
              f"{self.discarded} episodes say nothing for the same reason")
        for key, values in log_figures(self.cell.log_lines()).items():
            _, what, since = LOG_FIGURES[key]
            print(f"{what:22} {len(values):5} {figures(values)} {since}")
        print(self.log_terms.summary())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="folder of hecaton's programs")
    parser.add_argument("--cell", type=pathlib.Path, required=True, help="cell file of five hosts")
    parser.add_argument("--faults", type=int, help="at least so many (30; with --minutes as many as there is time for)")
    parser.add_argument("--minutes", type=float, metavar="M", default=math.inf,
                        help="ends after the episode in which these are over")
    parser.add_argument("--quiet", type=float, metavar="MINUTES", help="no faults: so long nothing may be told")
    parser.add_argument("--seed", type=int, default=1, help="of what happens to whom (1)")
    parser.add_argument("--only", nargs="+", choices=KINDS, default=KINDS, metavar="KIND",
                        help=f"of these kinds ({', '.join(KINDS)})")
    parser.add_argument("--alone", action="store_true", help="one fault at a time, that lasts long enough to be told")
    parser.add_argument("--of", nargs="+", default=[""], metavar="NAME",
                        help="whose processes are killed and stopped: names begin so; of each in turn (driver planner …)")
    parser.add_argument("--no-standbys", action="store_true", help="the cell as its file is, without standbys")
    parser.add_argument("--findings", type=int, default=1, metavar="N", help="how many end it (1)")
    parser.add_argument("--logs", type=pathlib.Path, help="folder for the hosts' logs")
    parser.add_argument("--report", type=pathlib.Path, metavar="FILE", help="also write the figures there, as JSON")
    options = parser.parse_args()
    if options.faults is None:
        options.faults = 30 if options.minutes == math.inf else math.inf
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
    text = still_text if options.no_standbys else standby_text
    cell_file.write_text(text(options.cell.read_text(), options.cell.resolve().parent))
    print(f"seed {options.seed}; hosts are {hosts.kind}; their logs are in {logs}", flush=True)
    cell = LiveCell(hosts, hecaton, cell_file, logs)
    cell.start()
    chaos = Chaos(cell, options)
    signal.signal(signal.SIGTERM, chaos.end_early)
    if options.quiet is None:
        chaos.run(options.faults, options.minutes)
    else:
        chaos.stay_quiet(options.quiet)
    codes = cell.stop()
    chaos.check_the_rest()
    chaos.summary()
    if options.report:
        options.report.write_text(json.dumps(chaos.report(options.seed), indent=2, ensure_ascii=False) + "\n")
    for violation in chaos.violations:
        print(f"VIOLATION: {violation}")
    if any(codes.values()):
        print(f"agents ended with {codes}")
    if chaos.unsafe():
        return UNSAFE
    if len(chaos.violations) == 1 and chaos.says_nothing():
        print("the machine stood still meanwhile")
        return UNSTEADY
    return 1 if chaos.violations or any(codes.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
