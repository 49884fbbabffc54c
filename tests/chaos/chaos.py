"""Faults at random, from a seed, against a cell whose arms work, on hosts of its own (network namespaces).

Any cell will do that has two named poses for all its arms. A cell without several hosts that have addresses of their own is
spread over some: one for each arm, one for the world, and one for the supervisor; each planner and the supervisor get a standby
if the cell file gives none to anybody. What else differs from the cell file: tests/chaos/cell_copy.py.

Before the first fault all arms go there and back while nothing is done to them: a cell that cannot is not tested, and why is
said. An episode is one to three faults at a time; one with --alone, so that the figures are of each kind of fault, and with --of
of one kind of process. All the time no contact may be seen, and no arm may follow an older term or two planners in one
(terms.py); every fault must be told as what it is, not before it is one, and blamed on who had it, and nothing else (verdicts.py); no supervisor may
take the lead from another to which nothing is done; after each episode the cell must run again and every goal be reached. With
--soak nothing is done to the cell, and every fault that it tells is a false one. Obstacles stand still: an arm whose driver is
dead cannot make way. The first finding ends it, with --findings N the Nth, but what is unsafe always does."""
import collections
import heapq
import itertools
import json
import math
import os
import pathlib
import random
import signal
import sys
import tempfile
import time
import traceback

import yaml  # Debian package python3-yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "container"))
import cell_document  # noqa: E402
import command_line  # noqa: E402
import ending  # noqa: E402
import namespaces  # noqa: E402
from bad_input import BadInput  # noqa: E402
from hosts import CannotRun  # noqa: E402
from figures import FiguresByFault, described, figures, log_figures, quantiles  # noqa: E402
from injections import draw, is_supervisor, pairs, together  # noqa: E402
from live_cell import LiveCell, runs, unix_ms  # noqa: E402
from setting import COPY, Setting, check, check_given, require_programs, require_sight  # noqa: E402
from steadiness import STALL, UNSAFE, UNSTEADY, TimerLateness  # noqa: E402
from terms import LogTerms, StatusTerms  # noqa: E402
from verdicts import RETURN, hidden, may_be_told, may_move_the_leadership, pardoned, supervisors_hit  # noqa: E402

SKIPPED = 77
BAD_INPUT = 3
NOTHING_TESTED = 4
DISCARDS = 20  # episodes at most whose findings are put down to a machine that stood still
LATE = 10.0  # [s] within which a fault that must be told is told; or as many leases, if that is longer
SURE_RETURN = 1.0  # [s] for which a supervisor does so (verdicts.RETURN) once it hears a host's processes again
ROUNDED = 20  # [ms] by which a time may be off: each supervisor reckons it anew, and its own absence begins with its last turn
MOVING = 2.0  # [s] before a change of the leadership is seen in which lies why


class Violation(Exception):
    """What must not be. `account`: the key of the report that counts such. `span` [ms, wall clock]: if the machine stood still
    in it, that may be why; None: in the whole episode."""

    def __init__(self, account, what, span=None):
        super().__init__(what)
        self.account = account
        self.span = span


class Unreached(AssertionError):
    """An arm did not go where it should."""


NEVER = (math.inf, -math.inf)
# What a machine that stands still makes of any component.
SILENCES = ("node_silent", "host_lost", "host_isolated", "link_lost", "driver_silent", "world_silent")
UNSAFE_ACCOUNTS = ("contacts", "stale_commands_accepted", "memories_lost")
ACCOUNTS = (*UNSAFE_ACCOUNTS, "wrong_attributions", "false_faults", "missed_faults", "unexplained_failovers")


def say(what):
    """To people: stdout is for data."""
    print(what, file=sys.stderr, flush=True)


class Chaos:
    """`poses`: two, between which all arms go. `ends`: hears who ends this program (ending.Ending)."""

    def __init__(self, cell, arms, poses, limits, options, ends):
        self.cell = cell
        self.arms = arms
        self.poses = poses
        self.limits = limits
        self.ends = ends
        self.only = options.only
        self.alone = options.alone
        self.of = tuple(options.of)
        self.timeout_scale = options.timeout_scale
        # In turn: who is killed ten times in a row within 10 s of life is given up.
        self.turns = itertools.cycle(self.of)
        self.rng = random.Random(options.seed)
        self.lateness = TimerLateness(min(STALL, limits.silence / 2))
        self.faults = 0
        self.known = set()
        self.told = collections.Counter()  # by kind of injection, like the next two; only of what had to be told
        self.detection = collections.defaultdict(list)  # [ms]
        self.recovery = collections.defaultdict(list)   # [s] from the end of the last fault at a time
        self.unwell = 0.0  # when the cell was last seen not to run
        self.findings = options.findings
        self.violations = []
        self.span = self.account = None  # of the last one
        self.accounts = dict.fromkeys(ACCOUNTS, 0)
        self.unfit = None  # why this cell cannot be tested
        self.tasks = 0
        self.reached = 0
        self.supervisor_returned = 0  # [ms, wall clock]
        self.returned_before = 0  # the same when this episode began
        self.ran_again = time.monotonic()  # the leader heard everybody
        self.held = 0       # episodes, or rounds of a soak run
        self.discarded = 0  # episodes
        self.untold = 0  # faults that no supervisor told while one led that was cut off before
        self.machine_stalls = 0  # faults told of processes that stood still with the machine
        self.machine_moves = 0   # of the leadership, for the same reason
        self.began = self.ended = unix_ms()  # the episode
        self.log_terms = LogTerms()
        self.by_fault = FiguresByFault()
        self.status_terms = StatusTerms()
        self.leads = None  # (supervisor, term)
        self.moves = []    # (when it was seen [ms, wall clock], what) of each change of that which was not judged yet
        self.may_move = [math.inf, -math.inf]  # from when to when [ms, wall clock] the leadership may move, lately
        cell.listeners += [self.status_terms.hear, self.hear_leader, self.hear_whether_it_runs]

    def hear_leader(self, status):
        before, self.leads = self.leads, (status["supervisor"], status["term"])
        if before not in (None, self.leads):
            self.moves.append((unix_ms(), f"from {before[0]} (term {before[1]}) to {self.leads[0]} (term {self.leads[1]})"))

    def hear_whether_it_runs(self, status):
        if not runs(status):
            self.unwell = time.monotonic()

    def work_through(self, options):
        if options.soak is None:
            self.run(options.faults, options.duration)
        else:
            self.soak(options.soak)

    def run(self, faults, duration):
        end = time.monotonic() + duration
        while self.faults < faults and time.monotonic() < end and not self.over():
            found = len(self.violations)
            self.episode()
            self.ended = unix_ms()
            if len(self.violations) == found:
                self.held += 1
                continue
            self.go_on_after_finding()

    def go_on_after_finding(self):
        if self.says_nothing() and self.discarded < DISCARDS:
            self.discard()
        if not self.over():
            self.go_on()

    def over(self):
        return bool(self.ends.told) or self.unsafe() or len(self.violations) >= self.findings

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
            self.hear_logs()
            self.moves.clear()
        except AssertionError as error:
            self.findings = 0  # nothing works any more
            # No machine stands still for so long that this would say nothing.
            self.violated("return after that", Violation(None, error, NEVER))

    def soak(self, duration):
        """The arms work, nothing happens to them, nothing may be told."""
        end = time.monotonic() + duration
        self.known = set(self.cell.faults())
        self.began = unix_ms()
        while time.monotonic() < end and not self.over():
            try:
                self.work_undisturbed()
                self.held += 1
            except (AssertionError, Violation) as error:
                self.violated("soak", error)
                self.known = set(self.cell.faults())
                self.ended = unix_ms()

    def settle(self):
        """What comes from now on counts."""
        time.sleep(max(0.0, self.ran_again + SURE_RETURN - time.monotonic()))  # no silence is put down to a return any more
        self.known = set(self.cell.faults())
        self.by_fault.end_episode(None)
        self.began = unix_ms()

    def work_undisturbed(self):
        """All arms go from one pose to the other."""
        self.await_goals(self.give_goals())
        self.check([])

    def wait_until_it_runs(self):
        self.cell.wait_until_it_runs()
        self.ran_again = time.monotonic()
        if self.may_move[1] == math.inf:
            self.may_move[1] = unix_ms() + 1000 * RETURN

    def begin(self):
        """Whether the cell came to run, which is the first that must hold, and its arms work."""
        try:
            self.wait_until_it_runs()
        except AssertionError as error:
            self.violated("start", error)
            return False
        self.learn()
        self.moves.clear()
        return self.goes_to_and_fro()

    def goes_to_and_fro(self):
        """Whether the arms do while nothing is done to them, and faults may begin."""
        while not self.over():
            found = len(self.violations)
            self.go_to_and_fro()
            if self.unfit:
                return False
            if len(self.violations) == found:
                return True
            self.go_on_after_finding()
        return False

    def go_to_and_fro(self):
        """That they cannot is no finding, unless the cell tells of one."""
        self.settle()
        try:
            for _ in self.poses:
                if not self.ends.told:
                    self.work_undisturbed()
        except Unreached as error:
            self.account_for(error)
        except Violation as error:
            self.violated("before the first fault", error)
        self.ended = unix_ms()

    def account_for(self, unreached):
        """It is the cell's doing if nothing went wrong meanwhile."""
        try:
            self.check([])
            self.unfit = f"the arms of this cell cannot go back and forth, without any fault: {unreached}"
        except Violation as error:
            self.violated("before the first fault", error)

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
        for arm, goal in zip(self.arms, goals):
            try:
                self.cell.wait_for_goal(goal)
            except AssertionError as error:
                raise Unreached(f"arm {arm} did not get from {self.poses[1]} to {self.poses[0]}: {error}") from error
            self.reached += 1

    def violated(self, during, error):
        self.violations.append(f"{during}: {error}")
        say(f"found after {self.faults} faults: {self.violations[-1]}")
        self.span = getattr(error, "span", None)
        self.account = getattr(error, "account", None)
        if self.account:
            self.accounts[self.account] += 1

    def episode(self):
        self.settle()
        self.leader = self.cell.status()["supervisor"]
        goals = self.give_goals()
        injections = []
        for _ in range(1 if self.alone else self.rng.choice((1, 1, 1, 2, 2, 3))):
            injection = draw(self.rng, self.victims(next(self.turns)), self.hosts, self.only, self.alone, self.limits)
            if all(together(injection, other) for other in injections):
                injections.append(injection)
        began = time.monotonic()
        try:
            injected = self.inflict(injections)
            inflicted = time.monotonic()
            self.await_told(injections, injected)
            # For what shows later than the cell runs again there is nothing to wait for.
            time.sleep(max(injection.aftermath for injection in injections))
            self.wait_until_it_runs()
            healed = self.ran_again
            self.await_goals(goals)
            self.check(injections)
            self.by_fault.end_episode(injections[0].kind() if len(injections) == 1 else None)
        except (AssertionError, Violation) as error:
            self.violated(f"episode of {', '.join(f'{one} ({one.lasted:.2f} s)' for one in injections)}", error)
            return
        self.faults += len(injections)
        for injection in injections:
            self.recovery[injection.kind()].append(max(0.0, self.unwell - inflicted))
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
                self.let_move(injection)
                injection.begin(self.cell)
                heapq.heappush(agenda, (time.monotonic() - start + injection.duration, index, "end"))
            else:
                injection.end(self.cell)
                injection.lasted = time.monotonic() - began[index]
            if injection.hits(self.nodes):
                self.supervisor_returned = unix_ms()
        return injected

    def let_move(self, injection):
        """Until the cell runs again, and for as long after that as who was cut off may find the others anew."""
        if not may_move_the_leadership(injection, self.nodes):
            return
        now = unix_ms()
        self.may_move = [self.may_move[0] if now <= self.may_move[1] else now, math.inf]

    def await_told(self, injections, injected):
        for index, injection in enumerate(injections):
            wanted = () if hidden(injection, injections, self.nodes, self.leader) else tuple(injection.all_that_must())
            told = [self.await_fault(injections, injection, one, injected[index]) for one in wanted]
            self.told[injection.kind()] += bool(told) and all(told)

    def await_fault(self, injections, injection, wanted, injected):
        """Whether this (kind, subject) was told of one of them; who was cut off before may be excused from it."""
        def told(_status):
            return next((fault for key, fault in self.cell.faults().items() if key not in self.known
                         and wanted in pairs(fault)), None)

        what = f"{injection}: {wanted[0]} of {wanted[1]} is told"
        try:
            fault = self.cell.wait_for(what, told, max(LATE, 10 * self.limits.lease))
        except AssertionError as error:
            if self.newcomer_leads(injections, injected, injection.lasted):
                self.untold += 1
                say(f"nobody told, while the leadership moved to who was cut off before: {what}")
                return False
            span = (injected, injected + 1000 * injection.lasted)
            raise Violation("missed_faults", error, span) from error
        if len(injections) == 1:  # beside others it may be hidden for a while, or told by a clock that jumped
            after = fault["since_unix_ms"] - injected
            if after >= -ROUNDED:
                self.detection[injection.kind()].append(after)
            elif not self.is_the_machines(fault):
                raise self.wrongly_accused(injections, fault, f", {-after} ms before {injection}")
        return True

    def newcomer_leads(self, injections, injected, lasted):
        """A supervisor that was cut off until just before, or that a busy machine kept from hearing the leader: it tells no more
        than what is wrong when it begins to lead, and takes what is silent for returning."""
        by_itself = self.leader not in supervisors_hit(injections, self.nodes)
        return ((by_itself or self.began < self.returned_before + 1000 * RETURN)
                and pardoned([at for at, _ in self.moves], injected, lasted))

    def check(self, injections):
        if self.cell.contacts() != 0:
            raise Violation("contacts", f"{self.cell.contacts()} contacts\n{self.cell.account()}")
        self.check_terms()
        allowed = may_be_told(injections, self.nodes)
        for key, fault in self.cell.faults().items():
            if key in self.known or pairs(fault) & allowed:
                continue
            # What another supervisor told before, in its own account, is history when it comes to light.
            if fault["cleared"] and fault["since_unix_ms"] < self.began:
                continue
            if not self.is_the_machines(fault):
                raise self.wrongly_accused(injections, fault)
        self.check_leadership({injection.host for injection in injections})

    def is_the_machines(self, fault):
        """Silent, it is: where a timer is late by half of what may be silent, a process may be by the whole."""
        told = fault["since_unix_ms"]
        silence = {"node_silent": self.limits.silence, "host_lost": self.limits.lease, "host_isolated": self.limits.lease,
                   "link_lost": self.limits.lease}.get(fault["kind"])
        stood_still = silence and self.lateness.stood_still(told - 2000 * silence, told + 100, silence / 2)
        self.machine_stalls += 1 if stood_still else 0
        return bool(stood_still)

    @staticmethod
    def wrongly_accused(injections, fault, when=""):
        return Violation("wrong_attributions" if injections else "false_faults",
                         f"wrongly accused{when}: {fault['kind']} of {fault['subject']}: {fault['description']}",
                         None if fault["kind"] in SILENCES else NEVER)

    def check_leadership(self, disturbed):
        """Who leads leads on unless something is done to it, to who stands by, or to what they share. `disturbed`: hosts."""
        moves, self.moves = self.moves, []
        for at, what in moves:
            if self.may_move[0] <= at <= self.may_move[1]:
                continue
            since = at - 1000 * MOVING
            # The processes of a cell may get less of a busy machine than our timers do. A supervisor that stands still by itself
            # is no reason: that is what is looked for.
            stalls = [stall for stall in self.cell.lateness.meanwhile(since, at, disturbed) if not is_supervisor(stall[2])]
            if stalls:
                self.machine_moves += 1
                say(f"the leadership moved {what} while {max(stalls, key=lambda stall: stall[1])[2]} stood still, too")
                continue
            raise Violation("unexplained_failovers", f"the leadership moved by itself {what}", (since, at))

    def hear_logs(self):
        """What was told since the last time."""
        for line in self.cell.new_log_lines():
            self.log_terms.hear(line)
            self.by_fault.hear(line)

    def check_terms(self):
        """Here no host loses its memory, so no driver may."""
        self.hear_logs()
        for complaint in self.log_terms.complaints + self.status_terms.complaints:
            raise Violation("stale_commands_accepted", complaint)
        if self.log_terms.forgotten:
            raise Violation("memories_lost", f"drivers began without memory: {', '.join(self.log_terms.forgotten)}")

    def look_for_contacts(self):
        """Whatever failed first may have been because of one."""
        if self.cell.contacts() and not self.accounts["contacts"]:
            self.violated("meanwhile", Violation("contacts", f"{self.cell.contacts()} contacts\n{self.cell.account()}"))

    def check_the_rest(self):
        """What came after the last episode's check, and that there was something to check."""
        try:
            if not self.unsafe():
                self.check_terms()
            untold = self.log_terms.untold(self.arms) if self.held else ()
            if untold:
                raise Violation(None, f"the logs do not tell whom {', '.join(untold)} followed, and by which leases", NEVER)
        except Violation as error:
            self.violated("the end", error)

    def says_nothing(self):
        """What was found may be put down to a machine that stood still meanwhile: never a contact, nor whom an arm follows."""
        since, until = self.span or (self.began, self.ended)
        return bool(self.violations) and not self.unsafe() and self.lateness.stood_still(since, until)

    def unsafe(self):
        return self.cell.contacts() > 0 or any(self.accounts[account] for account in UNSAFE_ACCOUNTS)

    def report(self, cell, seed, ended):
        """`ended`: exit codes of agents that did not end well."""
        return {"faults": self.faults, **self.accounts, "tasks": self.tasks, "reached": self.reached,
                "cell": cell, "seed": seed, "timeout_scale": self.timeout_scale,
                "told": dict(sorted(self.told.items())),
                "detection_ms": {name: quantiles(self.detection[name]) for name in sorted(self.detection)},
                "runs_again_s": {name: quantiles(self.recovery[name]) for name in sorted(self.recovery)},
                **{key: quantiles(values) for key, values in log_figures(self.cell.log_lines()).items()},
                "alone": self.by_fault.report(),
                "timer_lateness_ms": quantiles(self.lateness.late),
                "silent_because_the_machine_stood_still": self.machine_stalls, "discarded_episodes": self.discarded,
                "held_episodes": self.held,
                "leadership_moved_because_the_machine_stood_still": self.machine_moves,
                "untold_while_the_leadership_moved": self.untold, "followed": self.log_terms.followed,
                "replaced_planners_refused": len(self.log_terms.refused),
                "agents_ended_with": ended, "violations": self.violations, "not_tested": self.unfit}

    def summary(self):
        """The report, for people."""
        yield (f"{self.reached} of {self.tasks} goals reached; {self.faults} faults; "
               "so many had to be told and were; those alone after p50, p99, max; ran again after p50, p99, max"
               + (f"; all limits {self.timeout_scale} times as long as the cell file's" if self.timeout_scale > 1 else ""))
        for name in sorted(self.recovery):
            yield (f"{name:22} {len(self.recovery[name]):5} {self.told[name]:5} {figures(self.detection.get(name, ()))}   "
                   f"{figures(self.recovery[name], 's')}")
        yield (f"{'timers are late by':28} {figures(self.lateness.late)}; "
               f"{self.machine_stalls} processes were silent because the machine stood still, "
               f"{self.discarded} episodes say nothing for the same reason")
        yield from described(log_figures(self.cell.log_lines()))
        yield from self.by_fault.summary()
        yield self.log_terms.summary()
        yield from (f"VIOLATION: {violation}" for violation in self.violations)
        if self.unfit:
            yield f"NOT TESTED: {self.unfit}"


def written(report, summary, output):
    """As the data of stdout."""
    if output == "table":
        return "\n".join(summary) + "\n"
    if output == "yaml":
        return yaml.safe_dump(report, sort_keys=False, allow_unicode=True)
    return json.dumps(report, indent=2, ensure_ascii=False) + "\n"


def work(hosts, hecaton, setting, options, ends):
    """Returns the exit code."""
    logs = options.logs or pathlib.Path(tempfile.mkdtemp(prefix="hecaton-chaos-"))
    cell_file = logs / COPY
    cell_file.write_text(cell_document.write(setting.document), encoding="utf-8")
    plan = check(hecaton, cell_file)
    poses = setting.poses(plan)
    say(f"seed {options.seed}; hosts are {hosts.kind}; their logs are in {logs}")
    say(setting.told())
    cell = LiveCell(hosts, hecaton, cell_file, logs)
    chaos = Chaos(cell, [arm["name"] for arm in plan["arms"]], poses, setting.limits, options, ends)
    live(cell, chaos, options)
    chaos.lateness.end()
    ended = {host: code for host, code in cell.stop().items() if code}
    chaos.check_the_rest()
    code = judge(chaos, ended)
    return code if tell(chaos, ended, options) else code or 1


def live(cell, chaos, options):
    """What this program fails in itself takes nothing back of what was found before."""
    try:
        cell.start()
        if chaos.begin():
            chaos.work_through(options)
        chaos.look_for_contacts()
    except Exception as error:
        traceback.print_exc()
        chaos.violated("hecaton-chaos itself", Violation(None, f"{type(error).__name__}: {error}", NEVER))


def tell(chaos, ended, options):
    """Whether it could be told."""
    if ended:
        say(f"agents ended with {ended}")
    try:
        report = chaos.report(str(options.cell), options.seed, ended)
        if options.report:
            options.report.write_text(written(report, (), "json"), encoding="utf-8")
        sys.stdout.write(written(report, chaos.summary(), options.output))
        sys.stdout.flush()
        return True
    except Exception as error:
        say(f"not all could be told: {type(error).__name__}: {error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # or Python fails in it once more, with an exit code of its own
        return False


def judge(chaos, ended):
    """The exit code."""
    if chaos.unsafe():
        return UNSAFE
    if len(chaos.violations) == 1 and not ended and chaos.says_nothing():
        say("the machine stood still meanwhile")
        return UNSTEADY
    if chaos.violations or ended:
        return 1
    return judge_extent(chaos)


def judge_extent(chaos):
    """The exit code where all held that was tested."""
    if chaos.unfit:
        say(f"hecaton-chaos: {chaos.unfit}")
        return UNSTEADY if chaos.lateness.stood_still(chaos.began, chaos.ended) else BAD_INPUT
    if chaos.discarded > chaos.held:
        say(f"only {chaos.held} episodes held and {chaos.discarded} say nothing, for the machine stood still")
        return UNSTEADY
    if not chaos.held:
        say("it was ended before anything was tested")
        return NOTHING_TESTED
    return 0


def say_what_cannot_be(hecaton, options):
    """Before anything starts."""
    require_sight(options)
    require_programs(hecaton.parent)
    plan = check_given(hecaton, options.cell)
    setting = Setting(options)
    setting.poses(plan)
    setting.require_files(options)


def main():
    try:
        ends = ending.Ending() if namespaces.inside() else None
        options = command_line.parse(sys.argv[1:], __doc__)
        hecaton = options.programs.resolve() / "hecaton"
        if not namespaces.inside():
            say_what_cannot_be(hecaton, options)
        namespaces.enter()
        hosts = namespaces.Namespaces(hecaton, own_clocks="clock" in options.only)
        return work(hosts, hecaton, Setting(options), options, ends)
    except BadInput as error:
        say(f"hecaton-chaos: {error}")
        return BAD_INPUT
    except CannotRun as reason:
        say(f"skipped: {reason}")
        return SKIPPED
    except KeyboardInterrupt:  # before there was anything to end
        return ending.exit_code(signal.SIGINT)


if __name__ == "__main__":
    sys.exit(main())
