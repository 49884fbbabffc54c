"""Checks rules S1 to S3 of docs/explanation/0008-arm-leases.md, which planner may move an arm, in logs and statuses of the drivers.

usage: terms.py LOG…         checks the logs of a cell's hosts; exit code 1: a rule is broken
       terms.py --self-test

S1: the terms of the commands that an arm follows never decrease. S2: in each term, one planner moves the arm. S3: after its driver
has received a lease, no command of an older term moves the arm. A driver's checkpoint outlives its process and its agent, but not
its host (0008, "Consequences"): an agent that starts without it restarts the account of its drivers, and logs this. No rule needs a
clock, because hosts' clocks may differ and change: a driver logs in order, and a supervisor receives its states in order."""
import dataclasses
import re
import sys
import unittest

# service="…" and planner="" are quoted when they are empty or have blanks.
EVENT_LINE = re.compile(r' node=(driver|agent)/(\S+) event=(?:"([^"]*)"|(\S+))(.*)')
FIELD = re.compile(r' (\w+)=(?:"((?:[^"\\]|\\.)*)"|(\S*))')

FOLLOWS = ("planner changed", "planner continues")  # another planner; or the same one with another term or process
ARM_LEASE = "arm lease"                # in force at the driver
REFUSED = "command refused"


def fields(text):
    return {name: quoted or plain for name, quoted, plain in FIELD.findall(text)}


@dataclasses.dataclass
class Account:
    """The terms of one arm."""
    newest: int = 0  # newest term that its driver has received
    why: str = ""    # how
    holders: dict = dataclasses.field(default_factory=dict)  # planner, by term

    def follows(self, planner, term):
        return self._older(term, f"followed {planner} in term {term}") or self._hear(planner, term, "followed")

    def has_lease(self, planner, term):
        return self._older(term, f"has a lease of term {term} of {planner}") or self._hear(planner, term, "had a lease of")

    def _older(self, term, what):
        return f"{what} after it {self.why}" if term < self.newest else None

    def _hear(self, planner, term, how):
        if term > self.newest:
            self.newest, self.why = term, f"{how} term {term} of {planner or 'no planner yet'}"
        holder = self.holders.setdefault(term, planner) if planner else planner
        return f"{how} {planner} in term {term}, which is that of {holder}" if holder != planner else None


class LogTerms:
    """Checks the log lines of all hosts; lines of each host in order."""

    def __init__(self):
        self.complaints = []
        self.followed = 0   # number of changes to another planner, term or process
        self.leases = 0
        self.refused = set()  # (arm, planner, term) of late commands
        self.forgotten = []   # arms whose driver started without its checkpoint
        self._arms = {}
        self._logged = {ARM_LEASE: set(), FOLLOWS: set()}  # arms whose driver logged the event
        self._begun = {}  # services that the running agent of a host has started for the first time
        self._anew = set()  # hosts whose running agent is another one and has said nothing of a memory

    def hear(self, line):
        found = EVENT_LINE.search(line)
        if not found:
            return
        role, name, quoted, plain, rest = found.groups()
        (self._read_agent if role == "agent" else self._read_driver)(name, quoted or plain, fields(rest))

    def _read_agent(self, host, event, fields):
        if event == "run resumed":
            self._begun[host] = set()
            self._anew.discard(host)
        if event != "service started" or fields.get("restarts") != "0":
            return
        service = fields["service"]
        begun = self._begun.setdefault(host, set())
        if service in begun:
            begun.clear()
            self._anew.add(host)
        begun.add(service)
        arm = service.removeprefix("driver-")
        # On a busy machine, a driver may log before its agent logs the start; that is not an earlier process.
        if arm != service and host in self._anew and self._arms.pop(arm, None):
            self.forgotten.append(arm)

    def _read_driver(self, arm, event, fields):
        account = self._arms.setdefault(arm, Account())
        complaint = None
        if event in FOLLOWS:
            self.followed += 1
            self._logged[FOLLOWS].add(arm)
            complaint = account.follows(fields["planner"], int(fields["term"]))
        elif event == ARM_LEASE:
            self.leases += 1
            self._logged[ARM_LEASE].add(arm)
            complaint = account.has_lease(fields["planner"], int(fields["term"]))
        elif event == REFUSED and int(fields["term"]) <= account.newest:
            self.refused.add((arm, fields["from"], int(fields["term"])))
        if complaint:
            self.complaints.append(f"arm {arm} {complaint}")

    def without_events(self, arms):
        """Those of the arms whose driver did not log a followed planner and a lease, so that nothing is known of them."""
        return [arm for arm in arms if not all(arm in logged for logged in self._logged.values())]

    def summary(self):
        return (f"{self.followed} changes of planner, term or process under {self.leases} leases; "
                f"{len(self.refused)} replaced planners were refused"
                + (f"; started without checkpoint: {', '.join(self.forgotten)}" if self.forgotten else ""))


class StatusTerms:
    """Checks the drivers in `hecaton status -o json`, independently of their logs."""

    def __init__(self):
        self.complaints = []
        self._last = {}     # by supervisor and arm: each gets a driver's states in order, but with another delay
        self._holders = {}  # planner, by arm and term

    def hear(self, status):
        for arm in status["arms"]:
            if arm["state"]["age_s"] is None:  # no state of its driver yet
                continue
            complaint = self._judge(status["supervisor"], arm["name"], arm["state"])
            if complaint:
                self.complaints.append(f"arm {arm['name']}, in the status of {status['supervisor']}, {complaint}")

    def _judge(self, supervisor, arm, state):
        before = self._last.get((supervisor, arm))
        self._last[supervisor, arm] = state
        term, newest, planner = state["term"], state["newest_term"], state["planner"]
        if term > newest:
            return f"follows term {term} and knows none above {newest}"
        holder = self._holders.setdefault((arm, newest), planner) if planner else planner
        if holder != planner:
            return f"has a lease of {planner} in term {newest}, which is that of {holder}"
        if not before:
            return None
        if newest < before["newest_term"]:
            return f"has a lease of term {newest} after {before['newest_term']}"
        if not term:  # this process has not followed a planner yet
            return None
        if term < before["term"]:
            return f"follows term {term} after {before['term']}"
        # The last command may be older than the lease, but only if no newer one was accepted since.
        same = term == before["term"] and state["command_age_s"] >= before["command_age_s"]
        if term < before["newest_term"] and not same:
            return f"follows term {term}, by a command that it accepted under a lease of term {before['newest_term']}"
        return None


def driver(event, planner, term, arm="west"):
    """A log line of a driver."""
    quoted = event if " " not in event else f'"{event}"'
    return f'time=2026-01-31T12:00:00.000Z level=info node=driver/{arm} event={quoted} planner={planner} term={term} x="a b"'


def agent(event, rest=""):
    return f'time=2026-01-31T12:00:00.000Z level=info node=agent/west-pc event="{event}"{rest}'


def started(service, restarts=0):
    return agent("service started", f" service={service} pid=12 restarts={restarts}")


def status_of(term, newest, planner="A", age=0.01, supervisor="supervisor"):
    """The parts of a status that are checked."""
    state = {"term": term, "newest_term": newest, "planner": planner, "command_age_s": age, "age_s": 0.0}
    return {"supervisor": supervisor, "arms": [{"name": "west", "state": state}]}


class LogTest(unittest.TestCase):
    def complaints(self, *lines):
        terms = LogTerms()
        for line in lines:
            terms.hear(line)
        return terms.complaints

    def assert_found(self, pattern, *lines):
        found = self.complaints(*lines)
        self.assertEqual(len(found), 1, found)
        self.assertRegex(found[0], pattern)

    def test_takeover_and_return_are_allowed(self):
        self.assertEqual(self.complaints(
            driver("planner changed", "A", 5), driver("arm lease", "A", 5), driver("arm lease", "B", 8), driver("planner changed", "B", 8),
            driver("planner continues", "B", 8), driver("planner continues", "B", 10), driver("planner changed", "A", 11)), [])

    def test_finds_older_term(self):
        self.assert_found("followed B in term 8 after it followed term 9 of A",
                          driver("planner changed", "A", 9), driver("planner changed", "B", 8))

    def test_finds_older_term_after_newer_term_of_same_planner(self):
        self.assert_found("followed B in term 8 after it followed term 9 of A",
                          driver("planner changed", "A", 5), driver("planner continues", "A", 9), driver("planner changed", "B", 8))

    def test_finds_command_older_than_lease(self):
        self.assert_found("followed A in term 5 after it had a lease of term 8 of B",
                          driver("arm lease", "B", 8), driver("planner continues", "A", 5))

    def test_finds_two_planners_of_one_term(self):
        self.assert_found("B in term 5, which is that of A", driver("planner changed", "A", 5), driver("planner changed", "B", 5))
        self.assert_found("B in term 5, which is that of A", driver("arm lease", "A", 5), driver("planner changed", "B", 5))

    def test_lease_without_planner_is_of_the_first_one(self):
        self.assertEqual(self.complaints(driver("arm lease", '""', 5), driver("arm lease", "A", 5), driver("planner changed", "A", 5)), [])

    def test_finds_lease_that_goes_back(self):
        self.assert_found("has a lease of term 7 of A after it had a lease of term 8 of B",
                          driver("arm lease", "B", 8), driver("driver started", "", 0), driver("arm lease", "A", 7))

    def test_arms_have_separate_terms(self):
        self.assertEqual(self.complaints(driver("planner changed", "A", 9), driver("planner changed", "C", 5, "east")), [])

    def test_checkpoint_outlives_process_and_agent(self):
        lines = (started("driver-west"), driver("planner changed", "A", 9), started("driver-west", 1))
        self.assert_found("after", *lines, driver("planner changed", "B", 8))
        lines += (agent("run resumed"), started("driver-west"))
        self.assert_found("after", *lines, driver("planner changed", "B", 8))

    def test_driver_that_logs_before_its_agent_keeps_its_checkpoint(self):
        terms = LogTerms()
        for line in driver("driver started", "", 0), driver("arm lease", "A", 5), started("driver-west"), driver("planner changed", "B", 4):
            terms.hear(line)
        self.assertEqual((terms.forgotten, len(terms.complaints)), ([], 1))

    def test_checkpoint_does_not_outlive_host(self):
        terms = LogTerms()
        for line in (started("driver-west"), driver("planner changed", "A", 9), started("driver-west"), driver("planner changed", "B", 8)):
            terms.hear(line)
        self.assertEqual((terms.complaints, terms.forgotten), ([], ["west"]))

    def test_arm_without_log_events_is_reported(self):
        terms = LogTerms()
        for line in driver("planner changed", "A", 9), driver("arm lease", "A", 9), driver("planner changed", "A", 9, "east"):
            terms.hear(line)
        self.assertEqual(terms.without_events(["west", "east", "north"]), ["east", "north"])

    def test_refused_commands_are_counted_by_planner(self):
        terms = LogTerms()
        terms.hear(driver("planner changed", "B", 9))
        for times in (1, 2, 4):
            terms.hear(f'x node=driver/west event="command refused" from=A term=8 refused={times} reason="is older than 9"')
        self.assertEqual(terms.refused, {("west", "A", 8)})


class StatusTest(unittest.TestCase):
    def complaints(self, *statuses):
        terms = StatusTerms()
        for status in statuses:
            terms.hear(status)
        return terms.complaints

    def assert_found(self, pattern, *statuses):
        found = self.complaints(*statuses)
        self.assertEqual(len(found), 1, found)
        self.assertRegex(found[0], pattern)

    def test_takeover_is_allowed(self):
        self.assertEqual(self.complaints(status_of(5, 5), status_of(5, 8, "B", 0.02), status_of(5, 8, "B", 0.3), status_of(8, 8, "B")), [])

    def test_new_driver_has_not_followed_a_planner(self):
        self.assertEqual(self.complaints(status_of(8, 8), status_of(0, 8, age=0.0), status_of(8, 8)), [])

    def test_status_without_driver_state_is_ignored(self):
        silent = status_of(0, 0, "")
        silent["arms"][0]["state"]["age_s"] = None
        self.assertEqual(self.complaints(status_of(8, 8), silent), [])

    def test_delayed_supervisor_gives_no_finding(self):
        self.assertEqual(self.complaints(status_of(8, 8), status_of(5, 5, "B", supervisor="supervisor@beta"), status_of(8, 8)), [])

    def test_finds_terms_that_go_back(self):
        self.assert_found("has a lease of term 7 after 8", status_of(8, 8), status_of(7, 7, "B"))
        self.assert_found("follows term 7 after 8", status_of(8, 9, "B"), status_of(7, 9, "B"))
        self.assert_found("knows none above 7", status_of(8, 7))

    def test_finds_newer_command_of_older_term(self):
        self.assert_found("follows term 5, by a command", status_of(5, 8, "B", 0.2), status_of(5, 8, "B", 0.01))
        self.assert_found("follows term 6, by a command", status_of(5, 8, "B", 0.2), status_of(6, 8, "B", 0.3))

    def test_finds_two_planners_of_one_term(self):
        self.assert_found("has a lease of B in term 5, which is that of A",
                          status_of(5, 5), status_of(5, 5, "B", supervisor="supervisor@beta"))


def main():
    if sys.argv[1:] == ["--self-test"]:
        unittest.main(argv=sys.argv[:1])
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    terms = LogTerms()
    for name in sys.argv[1:]:
        with open(name, errors="replace") as log:
            for line in log:
                terms.hear(line)
    print("\n".join(terms.complaints + [terms.summary()]))
    return 1 if terms.complaints or not terms.followed else 0


if __name__ == "__main__":
    sys.exit(main())
