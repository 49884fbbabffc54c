"""What can go wrong in a cell of several hosts: each injection happens to one victim, lasts, and ends."""
import dataclasses
import random
import signal

# The silence of a node and of a host that the cell file of the chaos run allows [s].
SILENCE = 0.25
LEASE = 1.0


def surely_told(limit):
    """How long a silence must last that no supervisor can miss [s]. It counts in the supervisor's own punctual time: a
    turn of its loop that was late by more than some 10 ms, as they often are where 17 processes share two cores, pardons
    everybody's silence once (Liveness::judge). What ends before may be told, and need not be."""
    return 2 * limit + 0.15


@dataclasses.dataclass
class Expected:
    """What the supervisor must tell of an injection, and of whom it may tell something."""
    kinds: tuple = ()      # one of these, of `subject`; empty: nothing need be told
    subject: str = ""
    victims: tuple = ()    # faults of anybody else are wrong


class Injection:
    """`begin` and `end` are called once each; `duration` [s] lies between."""

    name = ""
    duration = 0.0
    aftermath = 0.0  # [s] after its end in which what it does may only begin to show

    def kind(self):
        """As figures are told of it."""
        return self.name

    def begin(self, cell):
        raise NotImplementedError

    def end(self, cell):
        pass

    def expected(self, cell):
        raise NotImplementedError

    def blinds(self):
        """The supervisor, or its host, is hit: what happens meanwhile need not be told."""
        return False


def host_of(cell, node):
    return next(entry["host"] for entry in cell.status()["nodes"] if entry["node"] == node)


def everybody_on(cell, host):
    """All whose silence the loss of a host explains: its nodes, its arms, itself."""
    nodes = [entry["node"] for entry in cell.status()["nodes"] if entry["host"] == host]
    return (host, f"agent/{host}", *nodes, *(node.split("/")[1] for node in nodes if node.startswith("driver/")))


def is_supervisor(node):
    return node.startswith("supervisor")


class OfNode(Injection):
    def __init__(self, node, host):
        self.node = node
        self.host = host

    def __str__(self):
        return f"{self.name} {self.node}"

    def kind(self):
        return f"{self.name} {self.node.split('/')[0].split('@')[0]}"

    def blinds(self):
        return is_supervisor(self.node)

    def _signal(self, cell, number):
        cell.hosts.signal(self.host, cell.pid(self.node), number)

    def _victims(self):
        return (self.node, self.node.split("/")[1].split("@")[0]) if "/" in self.node else (self.node,)


class Kill(OfNode):
    name = "kill -9"

    def begin(self, cell):
        self._signal(cell, signal.SIGKILL)

    def expected(self, cell):
        return Expected(("process_died",), self.node, self._victims())


class Stop(OfNode):
    """The process stands still and goes on."""
    name = "stop"

    def __init__(self, node, host, duration):
        super().__init__(node, host)
        self.duration = duration

    def begin(self, cell):
        self.pid = cell.pid(self.node)
        cell.hosts.signal(self.host, self.pid, signal.SIGSTOP)

    def end(self, cell):
        cell.hosts.signal(self.host, self.pid, signal.SIGCONT)

    def expected(self, cell):
        long = self.duration > surely_told(SILENCE)
        return Expected(("node_silent",) if long else (), self.node, self._victims())


class OfHost(Injection):
    def __init__(self, host, duration):
        self.host = host
        self.duration = duration
        self.hits_supervisor = False

    def __str__(self):
        return f"{self.name} {self.host}"

    def blinds(self):
        return self.hits_supervisor

    def expected(self, cell):
        victims = everybody_on(cell, self.host)
        self.hits_supervisor = any(is_supervisor(victim) for victim in victims)
        # Who is cut off with the leading supervisor sees everybody else lost.
        return Expected(("agent_lost",) if self.duration > surely_told(LEASE) else (), self.host, victims)


class Cut(OfHost):
    name = "cut"

    def begin(self, cell):
        cell.hosts.disconnect(self.host)

    def end(self, cell):
        cell.hosts.connect(self.host)


class Deafen(OfHost):
    """Nothing reaches the host; what it sends does. When it has heard nobody for the lease of its participants, it drops
    them and falls silent until it has found them again, which may begin when it hears already."""
    name = "deafen"
    aftermath = LEASE + 0.5

    def begin(self, cell):
        cell.hosts.drop(self.host, "input", 100)

    def end(self, cell):
        cell.hosts.drop_no_more(self.host, "input")

    def expected(self, cell):
        # It is heard: nobody need tell anything, but everything on it may complain or be dropped.
        told = super().expected(cell)
        return dataclasses.replace(told, kinds=())


class Mute(OfHost):
    """Nothing leaves the host; it hears the others."""
    name = "mute"

    def begin(self, cell):
        cell.hosts.drop(self.host, "output", 100)

    def end(self, cell):
        cell.hosts.drop_no_more(self.host, "output")


class Lose(OfHost):
    """Some of what reaches the host is lost."""
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

    def expected(self, cell):
        super().expected(cell)
        return Expected()


class Pause(OfHost):
    name = "pause"

    def begin(self, cell):
        cell.hosts.pause(self.host)

    def end(self, cell):
        cell.hosts.go_on(self.host)


class KillAgent(OfHost):
    """The agent dies, and all that it started with it; a service manager starts it anew."""
    name = "kill agent of"

    def begin(self, cell):
        cell.kill_agent(self.host)

    def end(self, cell):
        cell.start_agent(self.host)


class SlowDown(OfHost):
    """Somebody else computes on the host."""
    name = "slow down"

    def begin(self, cell):
        self.hogs = cell.hosts.hog(self.host)

    def end(self, cell):
        for hog in self.hogs:
            hog.kill()
            hog.wait()

    def expected(self, cell):
        super().expected(cell)
        return Expected()


class FillDisk(OfHost):
    """Nothing more can be written where the host's agent keeps what must survive."""
    name = "fill the disk of"

    def begin(self, cell):
        cell.hosts.fill_disk(self.host)

    def end(self, cell):
        cell.hosts.free_disk(self.host)

    def expected(self, cell):
        super().expected(cell)
        return Expected(victims=("world",))


class StepClock(OfHost):
    """Its wall clock jumps, and back: somebody sets it, or it loses and finds its time server."""
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

    def expected(self, cell):
        super().expected(cell)
        return Expected()


KINDS = ("kill", "stop", "cut", "mute", "deafen", "loss", "pause", "agent", "slow", "disk", "clock")


def draw(rng: random.Random, nodes, hosts, only=KINDS, told=False):
    """`nodes`: {node: host} of all services but agents. `told`: what lasts lasts long enough that it must be told."""
    node = rng.choice(sorted(nodes))
    host = rng.choice(sorted(hosts))
    about = lambda low, high: round(rng.uniform(low, high), 3)
    silent = lambda limit, low: about(surely_told(limit) + 0.1 if told else low, 3.0)
    kinds = {
        "kill": (6, lambda: Kill(node, nodes[node])),
        "stop": (4, lambda: Stop(node, nodes[node], silent(SILENCE, 0.05))),
        "cut": (3, lambda: Cut(host, silent(LEASE, 0.1))),
        "mute": (2, lambda: Mute(host, silent(LEASE, 0.1))),
        "deafen": (2, lambda: Deafen(host, about(0.1, 3.0))),
        "loss": (2, lambda: Lose(host, about(0.5, 2.0), rng.randint(1, 30))),
        "pause": (1, lambda: Pause(host, silent(LEASE, 0.1))),
        "agent": (1, lambda: KillAgent(host, silent(LEASE, 0.5) if told else about(0.5, 2.0))),
        "slow": (1, lambda: SlowDown(host, about(0.5, 2.0))),
        "disk": (1, lambda: FillDisk(host, about(0.5, 2.0))),
        "clock": (1, lambda: StepClock(host, about(1.5, 3.0), rng.choice((-1, 1)) * rng.choice((1, 60, 86400)))),
    }
    kind = rng.choices(only, [kinds[kind][0] for kind in only])[0]
    return kinds[kind][1]()
