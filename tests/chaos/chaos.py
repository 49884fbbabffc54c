"""Injects random faults, drawn from a seed, into a live cell on its own hosts (network namespaces).

The cell needs two named poses that all its arms have. A cell without several hosts with own addresses is spread over several: one
for each arm, one for the world and one for the supervisor. If the cell file has no standbys, each planner and the supervisor get
one. tests/chaos/cell_copy.py lists all differences from the cell file.

Before the first fault, all arms move there and back without disturbance. If they cannot, the cell is not tested and the reason is
printed. An episode has one to three faults at a time; with --alone one, so that figures are given by kind of fault. The runner
requires at all times: There is no contact. No arm follows an older term, or two planners of one term (terms.py). Each fault is
reported as what it is, not before it occurs, for the node or host concerned. No other fault is reported (verdicts.py). The leader
changes only because of a fault. After each episode the cell must run again and all goals must be reached. With --soak nothing is injected, and
each reported fault is a false one. Obstacles do not move, because an arm without driver cannot give way. The first finding ends the
run, with --findings the Nth; an unsafe one always does."""
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
from progress import Progress  # noqa: E402
from live_cell import LiveCell, runs, unix_ms  # noqa: E402
from setting import COPY, Setting, check, check_given, require_programs, require_sight  # noqa: E402
from steadiness import STALL, UNSAFE, UNSTEADY, TimerLateness  # noqa: E402
from terms import LogTerms, StatusTerms  # noqa: E402
from verdicts import RETURN, hidden, may_be_reported, may_change_leader, pardoned, supervisors_hit  # noqa: E402

SKIPPED = 77
BAD_INPUT = 3
NOTHING_TESTED = 4
DISCARDS = 20  # largest number of episodes discarded because the machine stalled
LATE = 10.0  # [s] within which a fault must be reported; or 10 host leases, if that is longer
SURE_RETURN = 1.0  # [s] after which no silence counts as part of a return (verdicts.RETURN)
ROUNDED = 20  # [ms] error of a reported time: each supervisor estimates it, its own absence from its last loop
MOVING = 2.0  # [s] before an observed change of leader in which its cause lies


class Violation(Exception):
    """A finding. `account`: the key of the report that counts it. `span` [ms, wall clock]: a stall of the machine in it may be the
    cause; None: in the whole episode."""

    def __init__(self, account, what, span=None):
        super().__init__(what)
        self.account = account
        self.span = span


class Unreached(AssertionError):
    """An arm did not reach its goal."""


NEVER = (math.inf, -math.inf)
# Faults that a stall of the machine can cause.
SILENCES = ("node_silent", "host_lost", "host_isolated", "link_lost", "driver_silent", "world_silent")
UNSAFE_ACCOUNTS = ("contacts", "stale_commands_accepted", "checkpoints_lost")
ACCOUNTS = (*UNSAFE_ACCOUNTS, "wrong_attributions", "false_faults", "missed_faults", "unexplained_failovers")


progress = Progress()


def say(what):
    """Prints a message to stderr; stdout is for data."""
    progress.clear()
    print(what, file=sys.stderr, flush=True)


def one_leads(status):
    """True if one supervisor leads and each other one stands by."""
    states = {node["node"]: node["state"] for node in status["nodes"] if is_supervisor(node["node"])}
    leader = states.pop(status["supervisor"], None)
    return leader == "running" and all(state == "standby" for state in states.values())


def nothing_done(options):
    """(done, asked, unit) before the run."""
    if options.soak is not None:
        return 0, options.soak, "s"
    return (0, options.duration, "s") if math.isinf(options.faults) else (0, options.faults, "faults")


class Chaos:
    """`poses`: the two poses between which all arms move. `ends`: signals that end the program (ending.Ending)."""

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
        self.calm = options.calm
        # In turn: the agent gives up a process that dies ten times in a row within 10 s of its start.
        self.turns = itertools.cycle(self.of)
        self.rng = random.Random(options.seed)
        self.lateness = TimerLateness(min(STALL, limits.silence / 2))
        self.faults = 0
        self.known = set()
        self.told = collections.Counter()  # by kind of injection, like the next two; only faults that had to be reported
        self.detection = collections.defaultdict(list)  # [ms]
        self.recovery = collections.defaultdict(list)   # [s] from the end of the episode's last fault
        self.unwell = 0.0  # when the cell was last observed not to run
        self.findings = options.findings
        self.violations = []
        self.span = self.account = None  # of the last violation
        self.accounts = dict.fromkeys(ACCOUNTS, 0)
        self.unfit = None  # reason why the cell cannot be tested
        self.extent = nothing_done(options)  # done, asked, unit
        self.tasks = 0
        self.reached = 0
        self.supervisor_returned = 0  # [ms, wall clock]
        self.returned_before = 0  # the same at the start of the episode
        self.ran_again = time.monotonic()  # when the leader last received all nodes
        self.passed = 0     # episodes, or rounds of a soak run
        self.discarded = 0  # episodes
        self.unreported = 0  # faults that were not reported during a change to a leader that was cut off before
        self.machine_stalls = 0  # reported faults of processes that stalled with the machine
        self.machine_moves = 0   # changes of leader for the same reason
        self.began = self.ended = unix_ms()  # the episode
        self.log_terms = LogTerms()
        self.by_fault = FiguresByFault()
        self.status_terms = StatusTerms()
        self.leads = None  # (supervisor, term)
        self.moves = []    # (time [ms, wall clock], text) of each change of leader that was not checked yet
        self.may_move = [math.inf, -math.inf]  # [ms, wall clock] the last interval in which the leader may change
        cell.listeners += [self.status_terms.hear, self.note_leader, self.note_whether_it_runs]

    def note_leader(self, status):
        before, self.leads = self.leads, (status["supervisor"], status["term"])
        if before not in (None, self.leads):
            self.moves.append((unix_ms(), f"from {before[0]} (term {before[1]}) to {self.leads[0]} (term {self.leads[1]})"))

    def note_whether_it_runs(self, status):
        if not runs(status):
            self.unwell = time.monotonic()

    def run_all(self, options):
        if options.soak is None:
            self.run(options.faults, options.duration)
        else:
            self.soak(options.soak)

    def run(self, faults, duration):
        began = time.monotonic()
        progress.restart()
        while self.note_extent(faults, duration, began) and not self.over():
            found = len(self.violations)
            self.episode()
            self.ended = unix_ms()
            if len(self.violations) == found:
                self.passed += 1
                self.work_calmly()
                continue
            self.continue_after_finding()

    def work_calmly(self):
        until = time.monotonic() + self.calm
        while time.monotonic() < until and not self.over():
            self.settle()
            try:
                self.work_undisturbed()
            except (AssertionError, Violation) as error:
                self.violated("between two episodes", error)
                self.ended = unix_ms()
                return self.continue_after_finding()

    def note_extent(self, faults, duration, began):
        """True while the run is not complete."""
        spent = time.monotonic() - began
        by_time = spent / duration > self.faults / faults
        self.extent = (min(round(spent, 1), duration), duration, "s") if by_time else (self.faults, faults, "faults")
        progress.show("chaos", *self.extent)
        return self.faults < faults and spent < duration

    def interrupted(self):
        """The member `interrupted` of the report: the signal, and how much of the run is done. None without a signal, and for a
        complete run."""
        done, asked, unit = self.extent
        if not self.ends.received or done >= asked:
            return None
        return {"signal": signal.Signals(self.ends.received).name, "done": done, "asked": asked, "unit": unit}

    def continue_after_finding(self):
        if self.caused_by_stall() and self.discarded < DISCARDS:
            self.discard()
        if not self.over():
            self.recover()

    def over(self):
        return bool(self.ends.received) or self.unsafe() or len(self.violations) >= self.findings

    def discard(self):
        """Discards the episode: a stall of the machine may have caused its finding."""
        say(f"discarded, because the machine stalled: {self.violations.pop()}")
        if self.account:
            self.accounts[self.account] -= 1
        self.discarded += 1

    def recover(self):
        before = self.cell.status()
        try:
            self.cell.wait_for("a status of the cell arrives", lambda status: status is not before)
            self.wait_until_it_runs()
            self.hear_logs()
            self.moves.clear()
        except AssertionError as error:
            self.findings = 0  # ends the run
            # No stall of the machine lasts so long.
            self.violated("recovery after a finding", Violation(None, error, NEVER))

    def soak(self, duration):
        """The arms work without disturbance; no fault may be reported."""
        began = time.monotonic()
        self.known = set(self.cell.faults())
        self.began = unix_ms()
        progress.restart()
        while self.note_extent(math.inf, duration, began) and not self.over():
            try:
                self.work_undisturbed()
                self.passed += 1
            except (AssertionError, Violation) as error:
                self.violated("soak", error)
                self.known = set(self.cell.faults())
                self.ended = unix_ms()

    def settle(self):
        """Starts an episode: faults reported from now on count."""
        time.sleep(max(0.0, self.ran_again + SURE_RETURN - time.monotonic()))
        self.known = set(self.cell.faults())
        self.by_fault.end_episode(None)
        self.began = unix_ms()

    def work_undisturbed(self):
        """Moves all arms from one pose to the other."""
        self.await_goals(self.give_goals())
        self.check([])

    def wait_until_it_runs(self):
        self.cell.wait_until_it_runs()
        self.ran_again = time.monotonic()
        if self.may_move[1] == math.inf:
            self.may_move[1] = unix_ms() + 1000 * RETURN

    def begin(self):
        """True if the cell runs and its arms move back and forth."""
        try:
            self.wait_until_it_runs()
            # At the start, each supervisor may lead before it hears the other.
            self.cell.wait_for("one supervisor leads", one_leads)
        except AssertionError as error:
            self.violated("start", error)
            return False
        self.learn()
        self.moves.clear()
        return self.can_move_back_and_forth()

    def can_move_back_and_forth(self):
        """True if the arms move back and forth without disturbance."""
        while not self.over():
            found = len(self.violations)
            self.move_back_and_forth()
            if self.unfit:
                return False
            if len(self.violations) == found:
                return True
            self.continue_after_finding()
        return False

    def move_back_and_forth(self):
        """An unreached goal is a finding only if the cell reports a fault."""
        self.settle()
        try:
            for _ in self.poses:
                if not self.ends.received:
                    self.work_undisturbed()
        except Unreached as error:
            self.explain(error)
        except Violation as error:
            self.violated("before the first fault", error)
        self.ended = unix_ms()

    def explain(self, unreached):
        """The cell is unfit if it reports no fault."""
        try:
            self.check([])
            self.unfit = f"the arms of this cell cannot move back and forth without faults: {unreached}"
        except Violation as error:
            self.violated("before the first fault", error)

    def learn(self):
        status = self.cell.status()
        self.nodes = {entry["node"]: entry["host"] for entry in status["nodes"] if not entry["node"].startswith("agent/")}
        self.hosts = {entry["host"] for entry in status["hosts"]}

    def victims(self, name):
        """{node: host} of all services whose names begin with `name`."""
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
                raise Unreached(f"arm {arm} did not reach {self.poses[0]} from {self.poses[1]}: {error}") from error
            self.reached += 1

    def violated(self, during, error):
        self.violations.append(f"{during}: {error}")
        say(f"finding after {self.faults} faults: {self.violations[-1]}")
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
            injected = self.inject(injections)
            ended_at = time.monotonic()
            self.await_reports(injections, injected)
            # Effects after this time cannot be awaited.
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
            self.recovery[injection.kind()].append(max(0.0, self.unwell - ended_at))
        say(f"{self.faults}: {', '.join(f'{one} ({one.duration:.1f} s)' for one in injections)}: "
            f"{healed - began:.1f} s, {time.monotonic() - began:.1f} s with the goals")

    def inject(self, injections):
        """Returns the start of each [ms, wall clock]. On a busy machine an injection may start late; it still lasts for its time."""
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
                self.allow_leader_change(injection)
                injection.begin(self.cell)
                heapq.heappush(agenda, (time.monotonic() - start + injection.duration, index, "end"))
            else:
                injection.end(self.cell)
                injection.lasted = time.monotonic() - began[index]
            if injection.hits(self.nodes):
                self.supervisor_returned = unix_ms()
        return injected

    def allow_leader_change(self, injection):
        """Allows changes of leader until the cell runs again, and for RETURN after that."""
        if not may_change_leader(injection, self.nodes):
            return
        now = unix_ms()
        self.may_move = [self.may_move[0] if now <= self.may_move[1] else now, math.inf]

    def await_reports(self, injections, injected):
        for index, injection in enumerate(injections):
            wanted = () if hidden(injection, injections, self.nodes, self.leader) else tuple(injection.required_reports())
            told = [self.await_fault(injections, injection, one, injected[index]) for one in wanted]
            self.told[injection.kind()] += bool(told) and all(told)

    def await_fault(self, injections, injection, wanted, injected):
        """True if this (kind, subject) was reported; False if a leader that was cut off before may have missed it."""
        def told(_status):
            return next((fault for key, fault in self.cell.faults().items() if key not in self.known
                         and wanted in pairs(fault)), None)

        what = f"{injection}: {wanted[0]} of {wanted[1]} is reported"
        try:
            fault = self.cell.wait_for(what, told, max(LATE, 10 * self.limits.lease))
        except AssertionError as error:
            if self.newcomer_leads(injections, injected, injection.lasted):
                self.unreported += 1
                say(f"not reported, during a change to a leader that was cut off before: {what}")
                return False
            span = (injected, injected + 1000 * injection.lasted)
            raise Violation("missed_faults", error, span) from error
        if len(injections) == 1:  # with others, it may be hidden for a while, or a clock may have jumped
            after = fault["since_unix_ms"] - injected
            if after >= -ROUNDED:
                self.detection[injection.kind()].append(after)
            elif not self.is_machine_stall(fault):
                raise self.wrong_fault(injections, fault, f", {-after} ms before {injection}")
        return True

    def newcomer_leads(self, injections, injected, lasted):
        """A new leader that was cut off until just before, or that did not hear the leader on a busy machine. It reports only faults
        that last when it begins to lead, and takes silent nodes for returning ones."""
        by_itself = self.leader not in supervisors_hit(injections, self.nodes)
        return ((by_itself or self.began < self.returned_before + 1000 * RETURN)
                and pardoned([at for at, _ in self.moves], injected, lasted))

    def check(self, injections):
        if self.cell.contacts() != 0:
            raise Violation("contacts", f"{self.cell.contacts()} contacts\n{self.cell.account()}")
        self.check_terms()
        allowed = may_be_reported(injections, self.nodes)
        for key, fault in self.cell.faults().items():
            if key in self.known or pairs(fault) & allowed:
                continue
            # A fault that another supervisor had reported before, on its side, becomes visible late.
            if fault["cleared"] and fault["since_unix_ms"] < self.began:
                continue
            if not self.is_machine_stall(fault):
                raise self.wrong_fault(injections, fault)
        self.check_leadership({injection.host for injection in injections})

    def is_machine_stall(self, fault):
        """True if a silence was caused by the machine: a timer was late by half of the limit, so a process may be by all of it."""
        since = fault["since_unix_ms"]
        silence = {"node_silent": self.limits.silence, "host_lost": self.limits.lease, "host_isolated": self.limits.lease,
                   "link_lost": self.limits.lease}.get(fault["kind"])
        stood_still = silence and self.lateness.stood_still(since - 2000 * silence, since + 100, silence / 2)
        self.machine_stalls += 1 if stood_still else 0
        return bool(stood_still)

    @staticmethod
    def wrong_fault(injections, fault, when=""):
        return Violation("wrong_attributions" if injections else "false_faults",
                         f"wrong fault{when}: {fault['kind']} of {fault['subject']}: {fault['description']}",
                         None if fault["kind"] in SILENCES else NEVER)

    def check_leadership(self, disturbed):
        """The leader must stay unless a fault hits a supervisor or a resource that they share. `disturbed`: hosts."""
        moves, self.moves = self.moves, []
        for at, what in moves:
            if self.may_move[0] <= at <= self.may_move[1]:
                continue
            since = at - 1000 * MOVING
            # Processes of the cell may stall although this program's timers do not. A stall of a supervisor alone is a finding.
            stalls = [stall for stall in self.cell.lateness.meanwhile(since, at, disturbed) if not is_supervisor(stall[2])]
            if stalls:
                self.machine_moves += 1
                say(f"leader changed {what} while {max(stalls, key=lambda stall: stall[1])[2]} stalled as well")
                continue
            raise Violation("unexplained_failovers", f"leader changed without cause {what}", (since, at))

    def hear_logs(self):
        """Reads new log lines."""
        for line in self.cell.new_log_lines():
            self.log_terms.hear(line)
            self.by_fault.hear(line)

    def check_terms(self):
        """Checks terms. No host restarts here, so no driver may lose its checkpoint."""
        self.hear_logs()
        for complaint in self.log_terms.complaints + self.status_terms.complaints:
            raise Violation("stale_commands_accepted", complaint)
        if self.log_terms.forgotten:
            raise Violation("checkpoints_lost", f"drivers started without their checkpoint: {', '.join(self.log_terms.forgotten)}")

    def look_for_contacts(self):
        """A contact may be the cause of the first finding."""
        if self.cell.contacts() and not self.accounts["contacts"]:
            self.violated("during the run", Violation("contacts", f"{self.cell.contacts()} contacts\n{self.cell.account()}"))

    def check_the_rest(self):
        """Checks log lines after the last episode, and that the logs contain the required events."""
        try:
            if not self.unsafe():
                self.check_terms()
            unreported = self.log_terms.without_events(self.arms) if self.passed else ()
            if unreported:
                raise Violation(None, f"the logs do not show which planner {', '.join(unreported)} followed, and by which leases",
                                NEVER)
        except Violation as error:
            self.violated("end of the run", error)

    def caused_by_stall(self):
        """True if a stall of the machine may be the cause of the finding; never of an unsafe one."""
        since, until = self.span or (self.began, self.ended)
        return bool(self.violations) and not self.unsafe() and self.lateness.stood_still(since, until)

    def unsafe(self):
        return self.cell.contacts() > 0 or any(self.accounts[account] for account in UNSAFE_ACCOUNTS)

    def report(self, cell, seed, ended):
        """`ended`: exit codes of agents that failed."""
        return {"faults": self.faults, **self.accounts, "tasks": self.tasks, "reached": self.reached,
                "cell": cell, "seed": seed, "timeout_scale": self.timeout_scale,
                "reported": dict(sorted(self.told.items())),
                "detection_ms": {name: quantiles(self.detection[name]) for name in sorted(self.detection)},
                "recovery_s": {name: quantiles(self.recovery[name]) for name in sorted(self.recovery)},
                **{key: quantiles(values) for key, values in log_figures(self.cell.log_lines()).items()},
                "alone": self.by_fault.report(),
                "timer_lateness_ms": quantiles(self.lateness.late),
                "faults_of_machine_stalls": self.machine_stalls, "discarded_episodes": self.discarded,
                "passed_episodes": self.passed,
                "leader_changes_of_machine_stalls": self.machine_moves,
                "unreported_during_leader_changes": self.unreported, "followed": self.log_terms.followed,
                "replaced_planners_refused": len(self.log_terms.refused),
                "agents_ended_with": ended, "violations": self.violations, "not_tested": self.unfit,
                "interrupted": self.interrupted()}

    def summary(self):
        """The report as text."""
        yield (f"{self.reached} of {self.tasks} goals reached; {self.faults} faults; "
               "columns: injected, reported, detection of single faults p50, p99, max, recovery p50, p99, max"
               + (f"; all time-outs of the cell file times {self.timeout_scale}" if self.timeout_scale > 1 else ""))
        for name in sorted(self.recovery):
            yield (f"{name:22} {len(self.recovery[name]):5} {self.told[name]:5} {figures(self.detection.get(name, ()))}   "
                   f"{figures(self.recovery[name], 's')}")
        yield (f"{'timer lateness':28} {figures(self.lateness.late)}; "
               f"{self.machine_stalls} faults and "
               f"{self.discarded} discarded episodes were caused by stalls of the machine")
        yield from described(log_figures(self.cell.log_lines()))
        yield from self.by_fault.summary()
        yield self.log_terms.summary()
        yield from (f"VIOLATION: {violation}" for violation in self.violations)
        if self.unfit:
            yield f"NOT TESTED: {self.unfit}"
        if cut := self.interrupted():
            yield f"interrupted by {cut['signal']}: {cut['done']:g} of {cut['asked']:g} {cut['unit']} done"


def written(report, summary, output):
    """The text for stdout."""
    if output == "table":
        return "\n".join(summary) + "\n"
    if output == "yaml":
        return yaml.safe_dump(report, sort_keys=False, allow_unicode=True)
    return json.dumps(report, indent=2, ensure_ascii=False) + "\n"


def work(hosts, hecaton, setting, options, ends):
    """Returns the exit code."""
    logs = options.logs or pathlib.Path(tempfile.mkdtemp(prefix="hecaton-chaos-"))
    if options.keys:
        setting.lock(hecaton, logs.absolute())
    cell_file = logs / COPY
    cell_file.write_text(cell_document.write(setting.document), encoding="utf-8")
    plan = check(hecaton, cell_file)
    poses = setting.poses(plan)
    say(f"seed {options.seed}; hosts are {hosts.kind}; their logs are in {logs}")
    say(setting.text())
    cell = LiveCell(hosts, hecaton, cell_file, logs)
    chaos = Chaos(cell, [arm["name"] for arm in plan["arms"]], poses, setting.limits, options, ends)
    run_cell(cell, chaos, options)
    chaos.lateness.end()
    for said in cell.end_recordings():
        say(said)
    ended = {host: code for host, code in cell.stop().items() if code}
    chaos.check_the_rest()
    code = judge(chaos, ended)
    return code if print_report(chaos, ended, options) else code or 1


def run_cell(cell, chaos, options):
    """An error of this program keeps the findings so far."""
    try:
        cell.start()
        for file in filter(None, (options.record, options.second_record)):
            cell.record(file)
        if chaos.begin():
            chaos.run_all(options)
        chaos.look_for_contacts()
    except Exception as error:
        traceback.print_exc()
        chaos.violated("hecaton-chaos itself", Violation(None, f"{type(error).__name__}: {error}", NEVER))


def print_report(chaos, ended, options):
    """Prints the report. Returns False if it cannot be written."""
    if ended:
        say(f"agents ended with {ended}")
    try:
        report = chaos.report(str(options.cell), options.seed, ended)
        if options.report:
            options.report.write_text(written(report, (), "json"), encoding="utf-8", errors="backslashreplace")
        sys.stdout.write(written(report, chaos.summary(), options.output))
        sys.stdout.flush()
        return True
    except Exception as error:
        say(f"the report cannot be written: {type(error).__name__}: {error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # otherwise Python fails again at exit, with another code
        return False


def judge(chaos, ended):
    """The exit code."""
    if chaos.unsafe():
        return UNSAFE
    if len(chaos.violations) == 1 and not ended and chaos.caused_by_stall():
        say("the machine stalled meanwhile")
        return UNSTEADY
    if chaos.violations or ended:
        return 1
    return judge_extent(chaos)


def judge_extent(chaos):
    """The exit code without findings."""
    if chaos.unfit:
        say(f"hecaton-chaos: {chaos.unfit}")
        return UNSTEADY if chaos.lateness.stood_still(chaos.began, chaos.ended) else BAD_INPUT
    if chaos.interrupted():
        say("interrupted: the report has what was done so far")
        return ending.exit_code(chaos.ends.received)
    if chaos.discarded > chaos.passed:
        say(f"only {chaos.passed} episodes passed; {chaos.discarded} were discarded because the machine stalled")
        return UNSTEADY
    if not chaos.passed:
        say("ended before the first episode")
        return NOTHING_TESTED
    return 0


def require_valid_input(hecaton, options):
    """Rejects bad input before anything starts."""
    require_sight(options)
    require_programs(hecaton.parent)
    plan = check_given(hecaton, options.cell)
    setting = Setting(options)
    setting.poses(plan)
    setting.require_files(options)


def main():
    for stream in sys.stdout, sys.stderr:  # names of files may hold bytes that are no UTF-8
        stream.reconfigure(encoding="utf-8", errors="backslashreplace")
    try:
        ends = ending.Ending() if namespaces.inside() else None
        options = command_line.parse(sys.argv[1:], __doc__)
        hecaton = options.programs.resolve() / "hecaton"
        if not namespaces.inside():
            require_valid_input(hecaton, options)
        namespaces.enter()
        hosts = namespaces.Namespaces(hecaton, own_clocks="clock" in options.only)
        return work(hosts, hecaton, Setting(options), options, ends)
    except BadInput as error:
        say(f"hecaton-chaos: {error}")
        return BAD_INPUT
    except CannotRun as reason:
        say(f"skipped: {reason}")
        return SKIPPED
    except KeyboardInterrupt:  # before the cell was started
        return ending.exit_code(signal.SIGINT)


if __name__ == "__main__":
    sys.exit(main())
