"""A cell of three arms on five hosts survives what happens to hosts and processes, as seen from outside.

usage: test_faults.py --programs DIR --cell FILE [--image NAME] [--logs DIR] [--only TEXT]

Hosts are containers of the image where these can be had, otherwise network namespaces. Exit code 77: neither can be had
here; why is on stderr."""
import argparse
import pathlib
import signal
import sys
import tempfile
import time
import unittest

import containers
import namespaces
from hosts import CannotRun
from live_cell import LiveCell, unix_ms

SKIPPED = 77  # as CTest is told
options = None
cell = None


def setUpModule():
    global cell
    hosts = options.hosts
    print(f"hosts are {hosts.kind}; their logs are in {options.logs}", flush=True)
    cell = LiveCell(hosts, options.programs.resolve() / "hecaton", options.cell.resolve(), options.logs)
    began = time.monotonic()
    cell.start()
    cell.wait_until_it_runs()
    print(f"the cell runs after {time.monotonic() - began:.1f} s", flush=True)


def tearDownModule():
    began = time.monotonic()
    codes = cell.stop()
    cell.hosts.close()
    print(f"the cell ended after {time.monotonic() - began:.1f} s", flush=True)
    if any(codes.values()):
        raise AssertionError(f"agents ended with {codes}")


class FaultTest(unittest.TestCase):
    def setUp(self):
        cell.wait_until_it_runs()
        self.known = cell.faults()
        self.began = time.monotonic()

    def tell(self, what, injected=None, fault=None):
        """A line of figures."""
        line = what
        if fault:
            line += f": seen after {fault['since_unix_ms'] - injected} ms as {fault['kind']} of {fault['subject']}"
            line += f", over {fault['duration_s']:.1f} s later"
        print(f"{line}; {time.monotonic() - self.began:.1f} s, {cell.contacts()} contacts", flush=True)

    def expect_no_fault_but(self, *expected):
        ids = {fault["id"] for fault in expected}
        others = [fault for key, fault in cell.faults().items() if key not in self.known and key not in ids]
        self.assertEqual(others, [])

    def expect_all_well(self, *expected):
        cell.wait_until_it_runs()
        self.expect_no_fault_but(*expected)
        self.assertEqual(cell.contacts(), 0)

    def visit(self, *arms):
        """The arms work: to the shared zone and home again."""
        for pose in ("ready", "home"):
            for goal in [cell.goal(arm, pose) for arm in arms]:
                cell.wait_for_goal(goal)

    def lose_and_find(self, what, host, arm, lose, find):
        """A host is lost in the midst of its arm's motion, and found again."""
        others = [other for other in ("north", "west", "east") if other != arm]
        goals = [cell.goal(arm, "ready")]
        cell.wait_until_it_moves(arm)
        injected = unix_ms()
        lose(host)
        try:
            fault = cell.wait_for_fault("agent_lost", host, self.known)
            # Where the lost arm is nobody knows: the others go where it cannot be, or wait.
            for other in others:
                goals.append(cell.goal(other, "ready"))
                cell.wait_until_it_is_there_or_waits(other, goals[-1], arm)
        finally:
            find(host)
        fault = cell.wait_until_over(fault)
        for goal in goals:
            cell.wait_for_goal(goal)
        self.visit(arm, *others)
        self.expect_all_well(fault)
        self.tell(what, injected, fault)

    def test_a_killed_planner_is_started_again_and_its_arm_reaches_its_goal(self):
        goal = cell.goal("north", "ready")
        cell.wait_until_it_moves("north")
        injected = unix_ms()
        cell.hosts.signal("north-pc", cell.pid("planner/north"), signal.SIGKILL)
        fault = cell.wait_for_fault("process_died", "planner/north", self.known)
        self.assertIn("signal 9", fault["seen"])
        self.visit("west", "east")
        cell.wait_for_goal(goal)
        fault = cell.wait_until_over(fault)
        self.visit("north")
        self.expect_all_well(fault)
        self.tell("kill -9 of a planner", injected, fault)

    def test_a_paused_host_is_lost_and_found(self):
        self.lose_and_find("a paused host", "north-pc", "north", cell.hosts.pause, cell.hosts.go_on)

    def test_a_host_without_network_is_lost_and_found(self):
        self.lose_and_find("a pulled cable", "west-pc", "west", cell.hosts.disconnect, cell.hosts.connect)

    def test_a_fifth_of_a_hosts_datagrams_may_be_lost(self):
        cell.hosts.drop("east-pc", "input", per_cent=20)
        self.addCleanup(cell.hosts.drop_no_more, "east-pc", "input")
        self.visit("north", "west", "east")
        self.expect_all_well()
        dropped = cell.hosts.dropped("east-pc", "input")
        self.assertGreater(dropped, 100)
        self.tell(f"20 % loss ({dropped} datagrams)")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="folder of hecaton's programs")
    parser.add_argument("--cell", type=pathlib.Path, required=True, help="cell file")
    parser.add_argument("--image", help="hosts are podman containers of this image; otherwise network namespaces")
    parser.add_argument("--logs", type=pathlib.Path, help="folder for the hosts' logs")
    parser.add_argument("--only", metavar="TEXT", help="tests whose names contain this")
    return parser.parse_args()


def make_hosts():
    """Where they are namespaces this program begins anew in them."""
    hecaton = options.programs.resolve() / "hecaton"
    if options.image and not namespaces.inside():
        try:
            return containers.Containers(options.image, options.cell.resolve().parent)
        except CannotRun as reason:
            print(f"hosts cannot be containers: {reason}", file=sys.stderr, flush=True)
    namespaces.enter()
    return namespaces.Namespaces(hecaton)


if __name__ == "__main__":
    options = parse()
    try:
        options.hosts = make_hosts()
    except CannotRun as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        sys.exit(SKIPPED)
    options.logs = options.logs or pathlib.Path(tempfile.mkdtemp(prefix="hecaton-hosts-"))
    options.logs.mkdir(parents=True, exist_ok=True)
    unittest.main(argv=[sys.argv[0], "-v"] + (["-k", options.only] if options.only else []))
