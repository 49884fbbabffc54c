"""Hosts of a test, each with an address in one network, and the faults that can be injected into them."""
import abc
import subprocess


class CannotRun(Exception):
    """Why this machine does not support these hosts."""


def run(*words, check=True):
    """Runs a command; returns its output. Raises RuntimeError with its error output."""
    done = subprocess.run(words, capture_output=True, text=True)
    if check and done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def drop_rules(hook, per_cent):
    """Rules of nftables that drop this share of datagrams. Kernels without netem support them as well."""
    table, interface = f"drop_{hook}", "iifname" if hook == "input" else "oifname"
    return [rule.split() for rule in (
        f"add table inet {table}",
        f"add chain inet {table} every {{ type filter hook {hook} priority 0 ; }}",
        f"add rule inet {table} every {interface} != lo numgen random mod 1000 <= {10 * per_cent - 1} counter drop")]


class Hosts(abc.ABC):
    """Hosts by name. They end with the program; after close() others can be added."""

    kind = ""  # for the output

    @abc.abstractmethod
    def add(self, name, address):
        """Creates a host in the /24 network of `address`."""

    @abc.abstractmethod
    def start(self, host, arguments, log):
        """Starts `hecaton` with these arguments as what the host is for; a subprocess.Popen whose SIGTERM it gets."""

    @abc.abstractmethod
    def signal(self, host, pid, number):
        """Sends a signal to a process of the host, by its id there."""

    @abc.abstractmethod
    def pause(self, host):
        """Stops all processes of the host."""

    @abc.abstractmethod
    def go_on(self, host):
        pass

    @abc.abstractmethod
    def cut_power(self, host):
        """Kills all processes of the host, also the one of start(); then the host can be started again."""

    @abc.abstractmethod
    def disconnect(self, host):
        """Disconnects the host from the network."""

    @abc.abstractmethod
    def connect(self, host):
        """Connects it again, with the same address."""

    @abc.abstractmethod
    def inside(self, host, words):
        """Runs a tool of this machine in the host's network, and returns its output."""

    @abc.abstractmethod
    def close(self):
        pass

    def drop(self, host, hook, per_cent):
        """Drops this share of the datagrams to (`hook`: input) or from (output) the host, at random."""
        for words in drop_rules(hook, per_cent):
            self.inside(host, ["nft", *words])

    def dropped(self, host, hook):
        """Number of datagrams dropped since drop()."""
        words = self.inside(host, ["nft", "list", "table", "inet", f"drop_{hook}"]).split()
        return int(words[words.index("packets") + 1])

    def drop_no_more(self, host, hook):
        self.inside(host, ["nft", "delete", "table", "inet", f"drop_{hook}"])
