"""A cell of several hosts, seen from outside: through `hecaton` on the operator's machine.

usage: live_cell.py --self-test"""
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

from steadiness import NodeLateness, unix_ms

TIMEOUT = 120  # [s] far more than needed; ends a test that hangs

LINES = 12  # of a command's output in a failure


class LiveCell:
    def __init__(self, hosts, hecaton, cell_file, logs):
        self.hosts = hosts
        self._hecaton = str(hecaton)
        self._file = str(cell_file)
        self._logs = logs
        self._agents = {}
        self._watch = None
        self._recorders = []
        self._status = None
        self._faults = {}
        self._logs_began = {}  # bytes, by host: start of this cell's lines
        self._logs_heard = {}  # bytes, by host: end of the lines returned by new_log_lines()
        self._contacts = 0
        self.lateness = NodeLateness()
        self.listeners = [self.lateness.hear]  # each is called with every status
        self._changed = threading.Condition()

    def start(self):
        """Creates the hosts of the cell file and starts an agent on each."""
        for host in self.plan()["hosts"]:
            self.hosts.add(host["name"], host["address"])
        for host in self.plan()["hosts"]:
            self.start_agent(host["name"])
        self._watch = self._ask("status", "--watch", "--interval", "250ms", "-o", "json",
                                "--connect-timeout", f"{TIMEOUT}s")
        threading.Thread(target=self._read, daemon=True).start()

    def plan(self):
        return json.loads(subprocess.run([self._hecaton, "check", self._file, "-o", "json"], check=True,
                                         capture_output=True, text=True).stdout)

    def start_agent(self, host):
        with open(self._logs / f"{host}.log", "a") as log:
            self._logs_began.setdefault(host, log.tell())
            self._logs_heard.setdefault(host, log.tell())
            self._agents[host] = self.hosts.start(host, ["agent", self._file, "--host", host], log)

    def kill_agent(self, host):
        """Kills the agent, and with it all its processes."""
        self._agents[host].kill()
        self._agents[host].wait()

    def cut_power(self, host):
        self.hosts.cut_power(host)
        self._agents[host].wait()

    def _ask(self, *words, **streams):
        """Runs hecaton on the operator's machine."""
        return subprocess.Popen([self._hecaton, *words, "--cell", self._file], text=True, stdout=subprocess.PIPE,
                                **streams)

    def _read(self):
        for line in self._watch.stdout:
            with self._changed:
                self._status = json.loads(line)
                self._faults.update({fault["id"]: fault for fault in self._status["faults"]})
                self._contacts = max(self._contacts, contacts_in(self._status))
                for listener in self.listeners:
                    listener(self._status)
                self._changed.notify_all()

    # Observation.

    def wait_for(self, what, condition, timeout=TIMEOUT):
        """Waits until condition(status) is true; returns its value."""
        until = time.monotonic() + timeout
        with self._changed:
            while True:
                found = condition(self._status) if self._status else None
                if found:
                    return found
                if not self._changed.wait(until - time.monotonic()):
                    raise AssertionError(f"{what}: not within {timeout} s; status of the cell:\n{self.account()}")

    def account(self):
        """The text of `hecaton status`."""
        told = self._ask("status", stderr=subprocess.STDOUT)
        return told.communicate()[0]

    def status(self):
        with self._changed:
            return self._status

    def wait_until_it_runs(self):
        self.wait_for("the cell runs", runs)

    def faults(self):
        """All faults so far, by id, in their last state."""
        with self._changed:
            return dict(self._faults)

    def wait_for_fault(self, kind, subject, known):
        """The record of a fault that is not in `known`."""
        return self.wait_for(f"fault {kind} of {subject}", lambda status: next(
            (fault for fault in status["faults"]
             if fault["kind"] == kind and fault["subject"] == subject and fault["id"] not in known), None))

    def wait_until_over(self, fault):
        """The same record once it is cleared."""
        return self.wait_for(f"end of fault {fault['kind']} of {fault['subject']}", lambda status: next(
            (now for now in status["faults"] if now["id"] == fault["id"] and now["cleared"]), None))

    def log_lines(self):
        """The log lines of all hosts, host by host."""
        for host in self._agents:
            with open(self._logs / f"{host}.log", "rb") as log:
                log.seek(self._logs_began[host])
                for line in log:
                    yield line.decode(errors="replace")

    def new_log_lines(self):
        """The log lines since the last call, complete lines only."""
        for host in self._agents:
            with open(self._logs / f"{host}.log", "rb") as log:
                log.seek(self._logs_heard[host])
                for line in log:
                    if not line.endswith(b"\n"):
                        break
                    self._logs_heard[host] += len(line)
                    yield line.decode(errors="replace")

    def contacts(self):
        """The largest number reported: a restarted world may count from 0."""
        return self._contacts

    def pid(self, node):
        """The id of the node's process, as soon as the leader has received it."""
        def heard(status):
            return next((entry["pid"] for entry in status["nodes"] if entry["node"] == node and entry["pid"] > 0), None)

        return self.wait_for(f"{node} has a process", heard)

    # Commands.

    def ask(self, *words):
        """Runs a command of hecaton, which must succeed; returns its output."""
        asked = self._ask(*words, stderr=subprocess.STDOUT)
        said = asked.communicate()[0]
        if asked.returncode != 0:
            raise AssertionError(f"hecaton {' '.join(words)}: exit code {asked.returncode}: {said}")
        return said

    def goal(self, arm, pose):
        """Gives a goal; wait_for_goal() awaits its end."""
        return self._ask("goal", arm, "--named", pose, "--wait", "--time-limit", f"{TIMEOUT}s",
                         "--connect-timeout", f"{TIMEOUT}s", stderr=subprocess.STDOUT)

    def wait_for_goal(self, goal):
        """The goal must be reached without contact; a contact holds the cell."""
        self.wait_for("goal ends", lambda status: goal.poll() is not None or touched(status), 2 * TIMEOUT)
        if goal.poll() is None:
            goal.kill()
        said = goal.communicate()[0].splitlines()
        if goal.returncode != 0:
            raise AssertionError("\n".join([f"goal not reached (exit code {goal.returncode}); last output:",
                                            *said[-LINES:], self.account()]))

    def wait_until_it_moves(self, arm):
        self.wait_for(f"arm {arm} moves", lambda status: any(
            abs(speed) > 0.1 for entry in status["arms"] if entry["name"] == arm for speed in entry["state"]["qd"]))

    def wait_until_it_is_there_or_waits(self, arm, goal, lost):
        """Its goal ends, or it says that it does not know where the other arm is, or leaves room for wherever it may be, be
        it on its way around."""
        def settled(status):
            entry = next(entry for entry in status["arms"] if entry["name"] == arm)
            waits_for = (entry["waiting_for"] or {"text": ""})["text"]
            binding = (entry["goal"] or {}).get("binding") or {}
            unknown = f"ArmState/{lost}" in waits_for or f"arm {lost} was lost" in waits_for
            return goal.poll() is not None or unknown or str(binding.get("other", "")).startswith(f"{lost}/")
        self.wait_for(f"arm {arm} continues or waits for a state of {lost}", settled)

    def record(self, file):
        """Records the cell from the operator's machine until end_recordings(). Several may do so at a time."""
        self._recorders.append(self._ask("record", "-o", str(file), stderr=subprocess.STDOUT))

    def end_recordings(self):
        """Returns what each recorder has said."""
        for recorder in self._recorders:
            recorder.send_signal(signal.SIGINT)
        said = [recorder.communicate()[0].strip() for recorder in self._recorders]
        self._recorders = []
        return said

    def stop(self):
        """Ends the agents and with them all services; returns their exit codes by host. Kills an agent that hangs."""
        if self._watch:
            self._watch.send_signal(signal.SIGTERM)
            ended(self._watch, time.monotonic() + TIMEOUT)
        for agent in self._agents.values():
            agent.send_signal(signal.SIGTERM)
        until = time.monotonic() + TIMEOUT
        return {host: ended(agent, until) for host, agent in self._agents.items()}


def ended(process, until):
    """Ends a process; returns its exit code."""
    try:
        return process.wait(timeout=max(0.0, until - time.monotonic()))
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def contacts_in(status):
    return status["contact_report"]["contacts"] if status["contact_report"] else 0


def touched(status):
    return contacts_in(status) > 0


def runs(status):
    """True if all nodes run and no arm is held."""
    return (status["mode"] == "run"
            and all(arm["mode"] == "run" and arm["driver_alive"] and arm["planner_alive"] for arm in status["arms"])
            and all(node["alive"] for node in status["nodes"])
            and all(host["agent_alive"] for host in status["hosts"])
            and all(fault["cleared"] for fault in status["faults"])
            and status["contact_report"] is not None)


def process_that(obeys):
    """A process that ends or ignores SIGTERM."""
    process = subprocess.Popen(["sh", "-c", f"{'' if obeys else 'trap : TERM;'} echo; while :; do sleep 0.05; done"],
                               stdout=subprocess.PIPE)
    process.stdout.readline()
    return process


class CellTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.logs = pathlib.Path(folder.name)
        self.cell = LiveCell(self, "hecaton", "cell.yaml", self.logs)

    def start(self, host, arguments, log):
        """As in Hosts."""
        return None

    def hear(self, contacts):
        line = json.dumps({"faults": [], "nodes": [], "contact_report": None if contacts is None else {"contacts": contacts}})
        self.cell._watch = unittest.mock.Mock(stdout=[line])
        self.cell._read()

    def test_contacts_survive_a_restart_of_the_world(self):
        for contacts, told in (None, 0), (0, 0), (2, 2), (None, 2), (0, 2):
            self.hear(contacts)
            self.assertEqual(self.cell.contacts(), told)

    def test_hung_agent_is_killed(self):
        for obeys, code in (True, -signal.SIGTERM), (False, -signal.SIGKILL):
            with process_that(obeys) as process:
                process.terminate()
                self.assertEqual(ended(process, time.monotonic() + (10.0 if obeys else 0.3)), code)

    def test_logs_start_with_this_cell(self):
        (self.logs / "a.log").write_text("of another\n")
        self.cell.start_agent("a")
        with open(self.logs / "a.log", "ab") as log:
            log.write(b"caf\xe9\nhalf")
        self.assertEqual(list(self.cell.new_log_lines()), ["caf\ufffd\n"])
        self.cell.start_agent("a")  # again
        self.assertEqual(list(self.cell.log_lines()), ["caf\ufffd\n", "half"])


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
