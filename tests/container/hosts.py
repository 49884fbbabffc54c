"""Machines of a test: each with an address of its own on one network, and everything that can go wrong with them."""
import abc
import subprocess


class CannotRun(Exception):
    """Why these machines cannot be had here."""


def run(*words, check=True):
    """The command's output; what it complained about when it failed."""
    done = subprocess.run(words, capture_output=True, text=True)
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


class Hosts(abc.ABC):
    """Hosts by name. They end with the object at the latest."""

    kind = ""  # as the output calls them

    @abc.abstractmethod
    def add(self, name, address):
        """Makes a host in the network of 256 addresses around `address`."""

    @abc.abstractmethod
    def start(self, host, arguments, log):
        """Starts `hecaton` with these arguments as what the host is for; a subprocess.Popen whose SIGTERM it gets."""

    @abc.abstractmethod
    def signal(self, host, pid, number):
        """To a process of the host, by the number that it has there."""

    @abc.abstractmethod
    def pause(self, host):
        """All its processes stand still."""

    @abc.abstractmethod
    def go_on(self, host):
        pass

    @abc.abstractmethod
    def disconnect(self, host):
        """Its cable is pulled."""

    @abc.abstractmethod
    def connect(self, host):
        """With the same address as before."""

    @abc.abstractmethod
    def inside(self, host, words):
        """Runs a tool of this machine in the host's network, and returns its output."""

    @abc.abstractmethod
    def close(self):
        pass

    def lose(self, host, per_cent):
        """So many of the datagrams that reach the host are lost, at random."""
        # nftables, because kernels without netem have it, too.
        for words in (
            "add table inet loss",
            "add chain inet loss input { type filter hook input priority 0 ; }",
            f"add rule inet loss input iifname != lo numgen random mod 100 < {per_cent} counter drop",
        ):
            self.inside(host, ["nft", *words.split()])

    def lost(self, host):
        """Datagrams since lose()."""
        words = self.inside(host, ["nft", "list", "table", "inet", "loss"]).split()
        return int(words[words.index("packets") + 1])

    def lose_no_more(self, host):
        self.inside(host, ["nft", "delete", "table", "inet", "loss"])
