"""Hosts as network namespaces on a bridge; only network and processes are separate."""
import errno
import ipaddress
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys

import ending
from hosts import CannotRun, Hosts, drop_rules, run

INSIDE = "HECATON_TEST_IN_NAMESPACES"


def inside():
    """True in a program that enter() has started."""
    return bool(os.environ.get(INSIDE))


def enter():
    """Starts this program again in namespaces of its own, which end, with all that is in them, when it ends.

    Returns in there, where a program that ends by signals (ending.py) hears from now on those that are sent to the one
    outside. Neither root's network nor other tests see any of it."""
    if inside():
        ending.hear_messenger(int(os.environ[INSIDE]))
        return
    for tool, package in (("unshare", "util-linux"), ("setpriv", "util-linux"), ("ip", "iproute2"), ("nft", "nftables")):
        if shutil.which(tool) is None:
            raise CannotRun(f"{tool} is missing (Debian package {package})")
    words = ["unshare", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"]
    if os.geteuid() != 0:
        words += ["--user", "--map-root-user"]
    try:
        run(*words, "true")
    except RuntimeError as error:
        raise CannotRun(f"namespaces are not allowed here: {error}") from error
    messenger = ending.Messenger()
    # It ends with this program, and so do all processes in the namespaces.
    unshare = messenger.start(["setpriv", "--pdeathsig", "KILL", *words, sys.executable, *sys.argv],
                              {**os.environ, INSIDE: str(messenger.ear)})
    code = unshare.wait()
    sys.exit(code if code >= 0 else ending.exit_code(-code))


class Namespaces(Hosts):
    """The operator's machine is the first namespace, with the bridge and the first address of the network."""

    kind = "network namespaces"
    BRIDGE = "cell"
    ELSEWHERE = "elsewhere"  # namespace of the hosts that separate() has moved
    OWN = pathlib.Path("/run")  # ip keeps its list of namespaces there
    DISKS = OWN / "disks"
    DISK = "32m"  # of each host, for temporary files
    CLOCKS = OWN / "clocks"

    def __init__(self, hecaton, own_clocks=False):
        """`own_clocks`: gives each host its own wall clock, for step_clock()."""
        self._hecaton = str(hecaton)
        self._clock_library = pathlib.Path(hecaton).with_name("libhost_clock.so") if own_clocks else None
        if own_clocks and not self._clock_library.exists():
            raise FileNotFoundError(f"{self._clock_library}: is needed for own clocks of hosts")
        try:
            self._make_network()
        except RuntimeError as error:
            raise CannotRun(f"the kernel lacks a feature for hosts: {error}") from error
        self._ports = {}  # the bridge's side of each host's cable

    def _make_network(self):
        run("mount", "-t", "tmpfs", "tmpfs", str(self.OWN))
        run("ip", "link", "add", self.BRIDGE, "type", "bridge")
        run("ip", "link", "set", "lo", "up")
        run("ip", "link", "set", self.BRIDGE, "up")
        run("ip", "link", "add", self.ELSEWHERE, "type", "bridge")
        run("ip", "link", "set", self.ELSEWHERE, "up")
        # Tries all kernel features of add() and drop() first.
        run("ip", "link", "add", "trial0", "type", "veth", "peer", "name", "trial1")
        run("ip", "link", "delete", "trial0")
        for words in (*drop_rules("input", 1), ("delete", "table", "inet", "drop_input")):
            run("nft", *words)

    @classmethod
    def hides(cls, path):
        """True if programs in the namespaces see another folder at this path."""
        return pathlib.Path(path).resolve().is_relative_to(cls.OWN)

    def add(self, name, address):
        network = ipaddress.ip_interface(f"{address}/24").network
        if not self._ports:
            run("ip", "address", "add", f"{network[1]}/24", "dev", self.BRIDGE)
        port = self._ports[name] = f"port{len(self._ports)}"
        run("ip", "netns", "add", name)
        run("ip", "link", "add", port, "type", "veth", "peer", "name", "eth0", "netns", name)
        run("ip", "link", "set", port, "master", self.BRIDGE, "up")
        self.inside(name, ["ip", "address", "add", f"{address}/24", "dev", "eth0"])
        self.inside(name, ["ip", "link", "set", "eth0", "up"])
        self.inside(name, ["ip", "link", "set", "lo", "up"])
        self.CLOCKS.mkdir(exist_ok=True)
        self.step_clock(name, 0)
        disk = self.DISKS / name
        disk.mkdir(parents=True)
        run("mount", "-t", "tmpfs", "-o", f"size={self.DISK}", "tmpfs", str(disk))

    def start(self, host, arguments, log):
        own = {"TMPDIR": str(self.DISKS / host)}
        if self._clock_library:
            own |= {"LD_PRELOAD": str(self._clock_library), "HOST_CLOCK": str(self.CLOCKS / host)}
        return subprocess.Popen(["ip", "netns", "exec", host, self._hecaton, *arguments], stderr=log,
                                env={**os.environ, **own})

    def step_clock(self, host, seconds):
        """Sets the offset of the host's wall clock from this machine's (`host_clock.cpp`)."""
        with open(self.CLOCKS / host, "r+b" if (self.CLOCKS / host).exists() else "wb") as file:
            file.write(struct.pack("=q", seconds * 1_000_000_000))

    def inside(self, host, words):
        return run("ip", "netns", "exec", host, *words)

    def signal(self, host, pid, number):
        os.kill(pid, number)

    def _signal_all(self, host, number):
        for pid in run("ip", "netns", "pids", host).split():
            os.kill(int(pid), number)

    def pause(self, host):
        self._signal_all(host, signal.SIGSTOP)

    def go_on(self, host):
        self._signal_all(host, signal.SIGCONT)

    def cut_power(self, host):
        self._signal_all(host, signal.SIGKILL)

    def disconnect(self, host):
        run("ip", "link", "set", self._ports[host], "down")

    def connect(self, host):
        run("ip", "link", "set", self._ports[host], "up")

    def separate(self, hosts):
        """Separates hosts from all others and from the operator's machine, as a lost link between two switches."""
        for host in hosts:
            run("ip", "link", "set", self._ports[host], "master", self.ELSEWHERE)

    def reunite(self, hosts):
        for host in hosts:
            run("ip", "link", "set", self._ports[host], "master", self.BRIDGE)

    def hog(self, host):
        """Starts one computing process per processor; the caller must end them."""
        return [subprocess.Popen(["ip", "netns", "exec", host, "sh", "-c", "while :; do :; done"])
                for _ in range(os.cpu_count())]

    def fill_disk(self, host):
        with open(self.DISKS / host / "rubbish", "wb", buffering=0) as file:
            try:
                while file.write(bytes(1 << 16)):
                    pass
            except OSError as error:
                if error.errno != errno.ENOSPC:
                    raise

    def free_disk(self, host):
        (self.DISKS / host / "rubbish").unlink()

    def close(self):
        """Removes the hosts. All else ends with the namespaces of enter()."""
        for name, port in self._ports.items():
            run("ip", "link", "delete", port)
            run("ip", "netns", "delete", name)
            run("umount", str(self.DISKS / name))
            (self.DISKS / name).rmdir()
        run("ip", "address", "flush", "dev", self.BRIDGE)
        self._ports = {}
