"""Faults at random, from a seed, against a cell whose arms work, on hosts of its own (network namespaces).

Any cell will do that has two named poses for all its arms. A cell without several hosts that have addresses of their own is
spread over some: one for each arm, one for the world, and one for the supervisor; each planner and the supervisor get a standby
if the cell file gives none to anybody. What else differs from the cell file: tests/chaos/cell_copy.py.

An episode is one to three faults at a time; one with --alone, so that the figures are of each kind of fault, and with --of
of one kind of process. All the time no contact may be seen, and no arm may follow an older term or two planners in one
(terms.py); every fault must be told as what it is and blamed on who had it, and nothing else (verdicts.py); after each episode
the cell must run again and every goal be reached. With --quiet nothing is done to the cell, and every fault that it tells is a
false one. Obstacles stand still: an arm whose driver is dead cannot make way. The first finding ends it, with --findings N the
Nth, but what is unsafe always does."""
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

import yaml  # Debian package python3-yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "container"))
import cell_document  # noqa: E402
import command_line  # noqa: E402
import namespaces  # noqa: E402
from bad_input import BadInput  # noqa: E402
from hosts import CannotRun  # noqa: E402
from figures import LOG_FIGURES, figures, log_figures, quantiles  # noqa: E402
from injections import draw, together  # noqa: E402
from live_cell import LiveCell, unix_ms  # noqa: E402
from setting import Setting, check  # noqa: E402
from steadiness import STALL, UNSAFE, UNSTEADY, TimerLateness  # noqa: E402
from terms import LogTerms, StatusTerms  # noqa: E402
from verdicts import hidden, may_be_told, supervisors_hit  # noqa: E402

SKIPPED = 77
BAD_INPUT = 3
DISCARDS = 20  # episodes at most whose findings are put down to a machine that stood still
LATE = 10.0  # [s] within which a fault that must be told is told; or as many leases, if that is longer
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


def say(what):
    """To people: stdout is for data."""
    print(what, file=sys.stderr, flush=True)


class Chaos:
    """`poses`: two, between which all arms go."""

    def __init__(self, cell, arms, poses, limits, options):
        self.cell = cell
        self.arms = arms
        self.poses = poses
        self.limits = limits
        self.only = options.only
        self.alone = options.alone
        self.of = tuple(options.of)
        # In turn: who is killed ten times in a row within 10 s of life is given up.
        self.turns = itertools.cycle(self.of)
        self.rng = random.Random(options.seed)
        self.lateness = TimerLateness(min(STALL, limits.silence / 2))
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
        self.log_terms = LogTerms()
        self.status_terms = StatusTerms()
        self.led = set()  # (supervisor, term) since this episode began
        cell.listeners += [self.status_terms.hear, self.hear_leader]

    def hear_leader(self, status):
        self.led.add((status["supervisor"], status["term"]))

    def work_through(self, options):
        if options.quiet is None:
            self.run(options.faults, options.duration)
        else:
            self.stay_quiet(options.quiet)

    def run(self, faults, duration):
        end = time.monotonic() + duration
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
        say(f"says nothing, for the machine stood still: {self.violations.pop()}")
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

    def stay_quiet(self, duration):
        """The arms work, nothing happens to them, nothing may be told."""
        end = time.monotonic() + duration
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

    def begin(self):
        """Whether the cell came to run, which is the first that must hold."""
        try:
            self.wait_until_it_runs()
        except AssertionError as error:
            self.violated("start", error)
            return False
        self.learn()
        return True

    def learn(self):
        status = self.cell.status()
        self.nodes = {entry["node"]: entry["host"] for entry in status["nodes"] if not entry["node"].startswith("agent/")}
        self.hosts = {entry["host"] for entry in status["hosts"]}

    def victims(self, name):
        """{node: host} of all services whose names begin so."""
        return {node: host for node, host in self.nodes.items() if node.startswith(name)}

    def give_goals(self):
        self.poses = self.poses[::-1]
        self.tasks += len(self.arms)
        return [self.cell.goal(arm, self.poses[0]) for arm in self.arms]

    def await_goals(self, goals):
        for goal in goals:
            self.cell.wait_for_goal(goal)
            self.reached += 1

    def violated(self, during, error):
        self.violations.append(f"{during}: {error}")
        say(f"found after {self.faults} faults: {self.violations[-1]}")
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
            injection = draw(self.rng, self.victims(next(self.turns)), self.hosts, self.only, self.alone, self.limits)
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
        say(f"{self.faults}: {', '.join(f'{one} ({one.duration:.1f} s)' for one in injections)}: "
            f"{healed - began:.1f} s, {time.monotonic() - began:.1f} s with the goals")

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
                fault = self.cell.wait_for(what, told, max(LATE, 10 * self.limits.lease))
            except AssertionError as error:
                if self.newcomer_leads(injections):
                    self.untold += 1
                    say(f"nobody told, while the leadership moved to who was cut off before: {what}")
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
            silence = {"node_silent": self.limits.silence, "agent_lost": self.limits.lease}.get(fault["kind"])
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

    def report(self, cell, seed, ended):
        """`ended`: exit codes of agents that did not end well."""
        return {"faults": self.faults, **self.accounts, "tasks": self.tasks, "reached": self.reached,
                "cell": cell, "seed": seed,
                "told": dict(sorted(self.told.items())),
                "detection_ms": {name: quantiles(self.detection[name]) for name in sorted(self.detection)},
                "runs_again_s": {name: quantiles(self.recovery[name]) for name in sorted(self.recovery)},
                **{key: quantiles(values) for key, values in log_figures(self.cell.log_lines()).items()},
                "timer_lateness_ms": quantiles(self.lateness.late),
                "silent_because_the_machine_stood_still": self.machine_stalls, "discarded_episodes": self.discarded,
                "untold_while_the_leadership_moved": self.untold, "followed": self.log_terms.followed,
                "replaced_planners_refused": len(self.log_terms.refused),
                "agents_ended_with": ended, "violations": self.violations}

    def summary(self):
        """The report, for people."""
        lines = list(self.cell.log_lines())
        yield (f"{self.reached} of {self.tasks} goals reached; {self.faults} faults; "
               "so many had to be told and were; those alone after p50, p99, max; runs again after p50, p99, max")
        for name in sorted(self.recovery):
            yield (f"{name:22} {len(self.recovery[name]):5} {self.told[name]:5} {figures(self.detection.get(name, ()))}   "
                   f"{figures(self.recovery[name], 's')}")
        yield (f"{'timers are late by':28} {figures(self.lateness.late)}; "
               f"{self.machine_stalls} processes were silent because the machine stood still, "
               f"{self.discarded} episodes say nothing for the same reason")
        for key, values in log_figures(lines).items():
            _, what, since = LOG_FIGURES[key]
            yield f"{what:22} {len(values):5} {figures(values)} {since}"
        yield self.log_terms.summary()
        yield from (f"VIOLATION: {violation}" for violation in self.violations)


def written(report, summary, output):
    """As the data of stdout."""
    if output == "table":
        return "\n".join(summary) + "\n"
    if output == "yaml":
        return yaml.safe_dump(report, sort_keys=False, allow_unicode=True)
    return json.dumps(report, indent=2, ensure_ascii=False) + "\n"


def work(hosts, hecaton, setting, options):
    """Returns the exit code."""
    logs = options.logs or pathlib.Path(tempfile.mkdtemp(prefix="hecaton-chaos-"))
    logs.mkdir(parents=True, exist_ok=True)
    cell_file = logs / "cell.yaml"
    cell_file.write_text(cell_document.write(setting.document))
    plan = check(hecaton, cell_file)
    poses = setting.poses(plan)
    say(f"seed {options.seed}; hosts are {hosts.kind}; their logs are in {logs}")
    say(setting.told())
    cell = LiveCell(hosts, hecaton, cell_file, logs)
    chaos = Chaos(cell, [arm["name"] for arm in plan["arms"]], poses, setting.limits, options)
    signal.signal(signal.SIGTERM, chaos.end_early)
    cell.start()
    if chaos.begin():
        chaos.work_through(options)
    ended = {host: code for host, code in cell.stop().items() if code}
    chaos.check_the_rest()
    tell(chaos, ended, options)
    return judge(chaos, ended)


def tell(chaos, ended, options):
    report = chaos.report(str(options.cell), options.seed, ended)
    sys.stdout.write(written(report, chaos.summary(), options.output))
    if options.report:
        options.report.write_text(written(report, (), "json"))
    if ended:
        say(f"agents ended with {ended}")


def judge(chaos, ended):
    """The exit code."""
    if chaos.unsafe():
        return UNSAFE
    if len(chaos.violations) == 1 and chaos.says_nothing():
        say("the machine stood still meanwhile")
        return UNSTEADY
    return 1 if chaos.violations or ended else 0


def main():
    try:
        options = command_line.parse(sys.argv[1:], __doc__)
        hecaton = options.programs.resolve() / "hecaton"
        if not namespaces.inside():  # where the network interface of a cell file may be missing
            plan = check(hecaton, options.cell)
            Setting(options).poses(plan)
        namespaces.enter()
        hosts = namespaces.Namespaces(hecaton, own_clocks="clock" in options.only)
        return work(hosts, hecaton, Setting(options), options)
    except BadInput as error:
        say(f"hecaton-chaos: {error}")
        return BAD_INPUT
    except CannotRun as reason:
        say(f"skipped: {reason}")
        return SKIPPED


if __name__ == "__main__":
    sys.exit(main())
