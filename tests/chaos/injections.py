"""Faults to inject into a cell of several hosts. Each injection has a victim, a duration and an end.

The required and the allowed reports are pairs (kind of fault, subject); any other report is wrong. A fault whose explanation
improved counts as its last one (services/supervisor/fault_list.hpp).

usage: injections.py --self-test"""
import random
import signal
import sys
import unittest

from limits import Limits

FAILOVER = 0.5  # [s] upper bound until another supervisor leads after the death of the leader


STALL = 0.25  # [s] after which a supervisor reports its own stall


def surely_reported(limit):
    """Duration of a silence after which each supervisor must report it [s]. The supervisor measures in stall-compensated time: a
    loop that is late by more than some 10 ms, often with 17 processes on two cores, extends all limits once (Liveness::judge).
    A shorter silence may be reported."""
    return 2 * limit + 0.15


def longest(limit):
    """Longest random duration of a silence [s]; most of the drawn ones must be reported."""
    return max(3.0, surely_reported(limit) + 0.85)


def longest_stop(limit):
    """The same for a process of any kind."""
    return longest(max(limit, STALL))


def is_supervisor(node):
    return node.startswith("supervisor")


def silence_of(node, limits):
    """Silence after which a report is required [s]. A supervisor reports its own silence."""
    return max(limits.silence, STALL) if is_supervisor(node) else limits.silence


def silences(node):
    """Allowed reports for a silent node: of the node, or of its stream if heartbeats return before the states
    (FaultDetector::stream_sight)."""
    pairs = {("node_silent", node)}
    if node == "world":
        pairs.add(("world_silent", node))
    if node.startswith("driver/"):
        pairs.add(("driver_silent", node.removeprefix("driver/")))
    return pairs


def pairs(fault):
    """The (kind, subject) pairs that a reported fault stands for. An isolated host is lost to all other hosts; of a lost link, either end
    may be lost."""
    if fault["kind"] == "link_lost":
        return {("host_lost", host) for host in fault["subject"].split("<->")}
    return {("host_lost" if fault["kind"] == "host_isolated" else fault["kind"], fault["subject"])}


class Injection:
    """begin() and end() are called once each, `duration` [s] apart. `places`: {node: host} of all services."""

    name = ""
    limits = Limits()
    duration = 0.0
    lasted = 0.0     # [s] actual duration; the end may be late
    aftermath = 0.0  # [s] after its end, in which effects may begin

    def kind(self):
        """Name in the report."""
        return self.name

    def begin(self, cell):
        raise NotImplementedError

    def end(self, cell):
        pass

    def must(self):
        """The (kind, subject) that must be reported; None: none."""
        return None

    def required_reports(self):
        """All (kind, subject) that must be reported."""
        return filter(None, [self.must()])

    def may(self, places, blind):
        """What may be reported. `blind`: a supervisor is hit as well, and may have missed messages."""
        raise NotImplementedError

    def hits(self, places):
        """The supervisors that this injection kills, stops or cuts off."""
        return set()


class OfNode(Injection):
    def __init__(self, node, host):
        self.node = node
        self.host = host

    def __str__(self):
        return f"{self.name} {self.node}"

    def kind(self):
        return f"{self.name} {self.node.split('/')[0].split('@')[0]}"

    def hits(self, places):
        return {self.node} if is_supervisor(self.node) else set()

    def _signal(self, cell, number):
        cell.hosts.signal(self.host, cell.pid(self.node), number)


class Kill(OfNode):
    name = "kill -9"

    def begin(self, cell):
        self._signal(cell, signal.SIGKILL)

    def must(self):
        return "process_died", self.node

    def may(self, places, blind):
        # It is also silent until its agent reports the death; that is one fault, unless two supervisors report it.
        return {self.must()} | (silences(self.node) if blind else set())


class Stop(OfNode):
    """Stops a process and continues it."""
    name = "stop"

    def __init__(self, node, host, duration):
        super().__init__(node, host)
        self.duration = duration

    def begin(self, cell):
        self.pid = cell.pid(self.node)
        cell.hosts.signal(self.host, self.pid, signal.SIGSTOP)

    def end(self, cell):
        cell.hosts.signal(self.host, self.pid, signal.SIGCONT)

    def must(self):
        return ("node_silent", self.node) if self.duration > surely_reported(self.limit()) else None

    def limit(self):
        """[s]"""
        return silence_of(self.node, self.limits)

    def may(self, places, blind):
        # A supervisor reports its own absence as its silence. The agent's watchdog waits longer than all of these.
        return silences(self.node)


class OfHost(Injection):
    """By default no report is required or allowed."""

    def __init__(self, host, duration):
        self.host = host
        self.duration = duration

    def __str__(self):
        return f"{self.name} {self.host}"

    def may(self, places, blind):
        return set()

    def nodes(self, places):
        return {node for node, host in places.items() if host == self.host}


class Absence(OfHost):
    """The host is absent for the other hosts."""

    def must(self):
        return ("host_lost", self.host) if self.duration > surely_reported(self.limits.lease) else None

    def may(self, places, blind):
        # Its nodes do not return at the same time.
        nodes = {f"agent/{self.host}", *self.nodes(places)}
        return {("host_lost", self.host)}.union(*map(silences, nodes))

    def hits(self, places):
        return set(filter(is_supervisor, self.nodes(places)))


class OneWay(OfHost):
    """The peers of a host that receives nothing, or is not received, quarantine it; that may begin when both receive each other
    again (services/bus/peer_quarantine.hpp)."""

    @property
    def aftermath(self):
        return self.limits.lease + 0.5


class Separation(Absence):
    """The host's processes continue without the other hosts. A supervisor among them leads, at the latest after a second
    (SupervisorSubscriptions::newest_arrival), and reports its own host as lost, or with two hosts the other one. Its faults are kept
    when the network is whole again (UnreplicatedFaults)."""

    def may(self, places, blind):
        hosts = set(places.values())
        cannot_know = len(hosts) == 2 and self.hits(places) and self.lasted > self.limits.lease / 2
        return super().may(places, blind) | ({("host_lost", host) for host in hosts} if cannot_know else set())


class Cut(Separation):
    name = "cut"

    def begin(self, cell):
        cell.hosts.disconnect(self.host)

    def end(self, cell):
        cell.hosts.connect(self.host)


class Split(Absence):
    """Splits the network: `hosts` reach each other, and so do all other hosts. A supervisor on either side reports the hosts of the other
    side as lost. `supervisors`: hosts of supervisors."""
    name = "split"

    def __init__(self, hosts, others, supervisors, duration):
        super().__init__(None, duration)  # no single host
        self.hosts = sorted(hosts)
        self.lost = sorted({host for side, beyond in ((hosts, others), (others, hosts)) if supervisors & set(side)
                            for host in beyond})

    def __str__(self):
        return f"split off {' and '.join(self.hosts)}"

    def begin(self, cell):
        cell.hosts.separate(self.hosts)

    def end(self, cell):
        cell.hosts.reunite(self.hosts)

    def required_reports(self):
        return [("host_lost", host) for host in self.lost] if self.duration > surely_reported(self.limits.lease) + FAILOVER else []

    def may(self, places, blind):
        nodes = {*(f"agent/{host}" for host in self.lost), *self.nodes(places)}
        return {("host_lost", host) for host in self.lost}.union(*map(silences, nodes))

    def nodes(self, places):
        """Nodes on lost hosts; supervisors only if the split separates them."""
        return {node for node, host in places.items() if host in self.lost}


class Deafen(OneWay, Separation):
    """The host receives nothing, but its messages arrive. After the lease of its participants it drops all peers and is silent until
    it has discovered them again."""
    name = "deafen"

    def begin(self, cell):
        cell.hosts.drop(self.host, "input", 100)

    def end(self, cell):
        cell.hosts.drop_no_more(self.host, "input")

    def must(self):
        return None  # its messages arrive at first


class Mute(OneWay, Separation):
    """The host sends nothing, but receives, until each other host drops it at its own time."""
    name = "mute"

    def begin(self, cell):
        cell.hosts.drop(self.host, "output", 100)

    def end(self, cell):
        cell.hosts.drop_no_more(self.host, "output")


class Lose(OfHost):
    """Loses some packets to the host."""
    name = "loss"

    def __init__(self, host, duration, per_cent):
        super().__init__(host, duration)
        self.per_cent = per_cent

    def __str__(self):
        return f"{self.per_cent} % loss {self.host}"

    def begin(self, cell):
        cell.hosts.drop(self.host, "input", self.per_cent)

    def end(self, cell):
        cell.hosts.drop_no_more(self.host, "input")


class Pause(Absence):
    name = "pause"

    def begin(self, cell):
        cell.hosts.pause(self.host)

    def end(self, cell):
        cell.hosts.go_on(self.host)


class KillAgent(Absence):
    """Kills the agent with all its processes; a service manager restarts it."""
    name = "kill agent of"

    def begin(self, cell):
        cell.kill_agent(self.host)

    def end(self, cell):
        cell.start_agent(self.host)


class SlowDown(OfHost):
    """Loads the processors of the host."""
    name = "slow down"

    def begin(self, cell):
        self.hogs = cell.hosts.hog(self.host)

    def end(self, cell):
        for hog in self.hogs:
            hog.kill()
            hog.wait()


class FillDisk(OfHost):
    """Fills the disk on which the host's agent keeps its checkpoints."""
    name = "fill the disk of"

    def begin(self, cell):
        cell.hosts.fill_disk(self.host)

    def end(self, cell):
        cell.hosts.free_disk(self.host)


class StepClock(OfHost):
    """Sets the host's wall clock, and back, as a user or a time server may."""
    name = "step the clock of"

    def __init__(self, host, duration, seconds):
        super().__init__(host, duration)
        self.seconds = seconds

    def __str__(self):
        return f"step the clock of {self.host} by {self.seconds:+d} s"

    def begin(self, cell):
        cell.hosts.step_clock(self.host, self.seconds)

    def end(self, cell):
        cell.hosts.step_clock(self.host, 0)


def together(one, other):
    """True if both may be injected at the same time, because the required reports are clear."""
    if isinstance(one, Split) or isinstance(other, Split):
        return False
    if one.host != other.host:
        return True
    if isinstance(other, OfNode):
        one, other = other, one
    if isinstance(other, OfNode):
        return one.node != other.node
    return isinstance(one, OfNode) and isinstance(other, (Lose, SlowDown, FillDisk, StepClock))


KINDS = ("kill", "stop", "cut", "split", "mute", "deafen", "loss", "pause", "agent", "slow", "disk", "clock")


FEWEST_TO_SPLIT = 4  # hosts; with fewer, one side would be a single host


def split(rng, nodes, hosts, duration):
    """Splits two hosts from all other hosts."""
    side = rng.sample(sorted(hosts), 2)
    return Split(side, set(hosts) - set(side), {host for node, host in nodes.items() if is_supervisor(node)}, duration)


def draw(rng: random.Random, nodes, hosts, only=KINDS, told=False, limits=Limits()):
    """`nodes`: {node: host} of all services but agents. `told`: draw durations long enough that a report is required."""
    node = rng.choice(sorted(nodes))
    host = rng.choice(sorted(hosts))
    about = lambda low, high: round(rng.uniform(low, high), 3)
    silent = lambda limit, low: about(surely_reported(limit) + 0.1 if told else low, longest(limit))
    lost = lambda low: silent(limits.lease, low)
    kinds = {
        "kill": (6, lambda: Kill(node, nodes[node])),
        "stop": (4, lambda: Stop(node, nodes[node], silent(silence_of(node, limits), 0.05))),
        "cut": (3, lambda: Cut(host, lost(0.1))),
        "split": (1, lambda: split(rng, nodes, hosts, about(surely_reported(limits.lease) + FAILOVER + 0.1 if told else 0.1,
                                                          longest(limits.lease) + FAILOVER))),
        "mute": (2, lambda: Mute(host, lost(0.1))),
        "deafen": (2, lambda: Deafen(host, about(0.1, 3.0))),
        "loss": (2, lambda: Lose(host, about(0.5, 2.0), rng.randint(1, 30))),
        "pause": (1, lambda: Pause(host, lost(0.1))),
        "agent": (1, lambda: KillAgent(host, lost(0.5) if told else about(0.5, 2.0))),
        "slow": (1, lambda: SlowDown(host, about(0.5, 2.0))),
        "disk": (1, lambda: FillDisk(host, about(0.5, 2.0))),
        "clock": (1, lambda: StepClock(host, about(1.5, 3.0), rng.choice((-1, 1)) * rng.choice((1, 60, 86400)))),
    }
    if len(hosts) < FEWEST_TO_SPLIT:
        kinds["split"] = (0, None)
    kind = rng.choices(only, [kinds[kind][0] for kind in only])[0]
    injection = kinds[kind][1]()
    injection.limits = limits
    return injection


class DrawTest(unittest.TestCase):
    NODES = {"supervisor": "a", "driver/north": "b"}

    def drawn(self, limits, told):
        rng = random.Random(1)
        return [draw(rng, self.NODES, {"a", "b"}, ("stop", "cut", "mute", "pause", "agent"), told, limits) for _ in range(300)]

    def test_single_faults_must_be_reported(self):
        for silence in 0.02, 0.25, 5.0:
            for injection in self.drawn(Limits(silence, 6.0), told=True):
                self.assertIsNotNone(injection.must(), f"{injection} for {injection.duration} s")

    def test_stops_have_a_longest_duration(self):
        for silence in 0.02, 0.25, 5.0:
            stops = [one.duration for one in self.drawn(Limits(silence, 6.0), told=False) if isinstance(one, Stop)]
            self.assertLessEqual(max(stops), longest_stop(silence))


class SplitTest(unittest.TestCase):
    PLACES = {"supervisor": "a", "world": "b", "driver/north": "c", "planner/north": "d"}

    def splits(self, *supervisors):
        places = dict(self.PLACES, **{f"supervisor@{host}": host for host in supervisors})
        rng = random.Random(1)
        return places, [draw(rng, places, set("abcde"), ("split",), told=True) for _ in range(50)]

    def test_side_is_lost_to_the_supervisor_on_the_other(self):
        places, splits = self.splits()
        for one in splits:
            beyond = set("abcde") - set(one.hosts) if "a" in one.hosts else set(one.hosts)
            self.assertEqual(set(one.required_reports()), {("host_lost", host) for host in beyond})
            self.assertNotIn(("host_lost", "a"), one.may(places, False))
            self.assertEqual(one.hits(places), set())

    def test_both_sides_are_lost_with_a_supervisor_on_each(self):
        places, splits = self.splits("b")
        apart = [one for one in splits if len({"a", "b"} & set(one.hosts)) == 1]
        self.assertTrue(0 < len(apart) < len(splits))
        for one in apart:
            self.assertEqual({host for _, host in one.required_reports()}, set("abcde"))
            self.assertLessEqual(set(one.required_reports()), one.may(places, False))
            self.assertEqual(one.hits(places), {"supervisor", "supervisor@b"})

    def test_few_hosts_cannot_be_split(self):
        rng = random.Random(1)
        self.assertNotIn("split", [draw(rng, self.PLACES, set("abc")).name for _ in range(200)])


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
