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


def drop_rules(hook, per_cent):
    """Of nftables, because kernels without netem have it, too: so many of the datagrams are lost."""
    table, interface = f"drop_{hook}", "iifname" if hook == "input" else "oifname"
    return [rule.split() for rule in (
        f"add table inet {table}",
        f"add chain inet {table} every {{ type filter hook {hook} priority 0 ; }}",
        f"add rule inet {table} every {interface} != lo numgen random mod 1000 <= {10 * per_cent - 1} counter drop")]


class Hosts(abc.ABC):
    """Hosts by name. They end with the program at the latest; after close() others can be added."""

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
    def cut_power(self, host):
        """All its processes end at once, what start() has returned among them; then it can be started again."""

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

    def drop(self, host, hook, per_cent):
        """So many of the datagrams that reach (`hook`: input) or leave (output) the host are lost, at random."""
        for words in drop_rules(hook, per_cent):
            self.inside(host, ["nft", *words])

    def dropped(self, host, hook):
        """Datagrams since drop()."""
        words = self.inside(host, ["nft", "list", "table", "inet", f"drop_{hook}"]).split()
        return int(words[words.index("packets") + 1])

    def drop_no_more(self, host, hook):
        self.inside(host, ["nft", "delete", "table", "inet", f"drop_{hook}"])
