"""Runs the commands of docs/tutorials/three-machines.md, with three containers as machines.

usage: follow_guide.py --guide FILE --unit FILE --image NAME

The commands are those of the document. OTHERWISE lists the commands that are replaced here; the output names them as well. Exit
code 77: containers do not work here."""
import argparse
import collections
import contextlib
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import threading

from containers import Containers
from hosts import CannotRun, run

SKIPPED = 77  # exit code for CTest
TIMEOUT = 120  # [s] far more than needed
DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"  # what the package has in /usr/share/hecaton

OTHERWISE = (
    ("apt-get install ./hecaton…", "the image has been made so"),
    ("scp", "files go by `podman cp`"),
    ("nft", "of this machine, in the network of the container"),
    ("apt-get install chrony, chronyc", "left out: containers have one clock"),
    ("systemctl enable --now", "the unit's ExecStart, with its RuntimeDirectory and Environment; what systemd would start again "
     "this program does. The test `systemd_unit` checks the unit itself"),
    ("/usr/share/hecaton/container/hosts.sh", "that of the sources, with their cells"),
)


class Guide:
    def __init__(self, text):
        self._sections = dict(re.findall(r"^## (\d+)\. .*?\n(.*?)(?=^## |\Z)", text, flags=re.M | re.S))
        rows = re.findall(r"^\| \d \| ([\d.]+) \| `(\S+)` \|", text, flags=re.M)
        self.machines = {name: address for address, name in rows}

    def commands(self, section):
        """The commands of a section, without comments."""
        return [line.split("  #")[0].strip() for line in self._lines(section)]

    def placed_commands(self, section):
        """The commands, each with the machine that its comment gives."""
        names = list(self.machines)
        return [(names[int(re.search(r"  # machine (\d)$", line)[1]) - 1], line.split("  #")[0].strip())
                for line in self._lines(section)]

    def _lines(self, section):
        prose = re.sub(r"^```.*?^```", "", self._sections[str(section)], flags=re.M | re.S)
        return re.findall(r"^ {4}(\S.*)$", prose, flags=re.M)


def start_in(container, command, **streams):
    return subprocess.Popen(["podman", "exec", container, "bash", "-c", command], text=True, **streams)


class Machines:
    """Containers without services."""

    def __init__(self, image, machines):
        Containers(image, "/")  # raises CannotRun if containers do not work
        self._network = f"hecaton-guide-{os.getpid()}"
        self._machines = machines
        network = ".".join(next(iter(machines.values())).split(".")[:3]) + ".0/24"
        run("podman", "network", "create", "--disable-dns", "--subnet", network, self._network)
        for name, address in machines.items():
            run("podman", "run", "--detach", "--rm", "--name", self._container(name), "--hostname", name, "--network",
                self._network, "--ip", address, "--user", "root", "--entrypoint", "sleep", image, "infinity")

    def _container(self, name):
        return f"{self._network}-{name}"

    def named(self, address):
        return next(name for name, own in self._machines.items() if own == address)

    def start(self, name, command, **streams):
        return start_in(self._container(name), command, **streams)

    def type(self, name, command):
        """Runs a command, which must succeed; returns its output."""
        print(f"{name}# {command}", flush=True)
        done = self.start(name, command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        output = done.communicate(timeout=TIMEOUT)[0]
        if done.returncode != 0:
            raise RuntimeError(f"exit code {done.returncode}: {output}")
        return output

    def copy(self, name, source, other, target):
        with tempfile.TemporaryDirectory() as folder:
            run("podman", "cp", f"{self._container(name)}:{source}", folder)
            run("podman", "cp", f"{folder}/{pathlib.PurePath(source).name}", f"{self._container(other)}:{target}")

    def filter(self, name, words):
        """nft, on the machine's network."""
        pid = run("podman", "inspect", "--format", "{{.State.Pid}}", self._container(name)).strip()
        run("nsenter", "--target", pid, "--net", "nft", *words)

    def pull_cable(self, name):
        run("podman", "network", "disconnect", self._network, self._container(name))

    def plug_cable(self, name):
        run("podman", "network", "connect", "--ip", self._machines[name], self._network, self._container(name))

    def close(self):
        run("podman", "rm", "--force", "--ignore", "--time", "5", *map(self._container, self._machines))
        run("podman", "network", "rm", "--force", self._network)


class Service:
    """An agent as systemd runs it from the unit."""

    def __init__(self, unit, machines, name):
        def setting(key):
            return re.search(rf"^{key}=(.*)$", unit, flags=re.M)[1].replace("%i", name).replace("%t", "/run")

        self._begin = lambda command: machines.start(name, command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.line = setting("ExecStart")
        self._command = (f"mkdir -p -m {setting('RuntimeDirectoryMode')} /run/{setting('RuntimeDirectory')}; "
                         f"export {setting('Environment')}; exec {self.line}")
        self._process = self._begin(self._command)

    def has_ended(self):
        return self._process.poll() is not None

    def start_again(self):
        """Restarts it after its death."""
        self._process.wait(timeout=TIMEOUT)
        self._process = self._begin(self._command)


class Watch:
    """The output of `hecaton status --watch`. `start`: starts a command on its machine."""

    def __init__(self, start, environment):
        self._process = start(f"{environment}; exec hecaton status --watch -o json --connect-timeout {TIMEOUT}s",
                              stdout=subprocess.PIPE)
        self._changed = threading.Condition()
        self._status = None
        self._told = 0
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self._process.stdout:
            if not line.endswith("\n"):
                return  # it was ended in the midst
            with self._changed:
                self._status = json.loads(line)
                self._told += 1
                self._changed.notify_all()

    def until(self, what, condition):
        """Waits for a status that meets the condition; returns it."""
        with self._changed:
            before = self._told
            if not self._changed.wait_for(lambda: self._told > before and condition(self._status), TIMEOUT):
                raise RuntimeError(f"{what}: not within {TIMEOUT} s; last: {json.dumps(self._status)}")
            print(f"  {what}", flush=True)
            return self._status

    def close(self):
        self._process.kill()
        self._process.wait()


def refuse_the_rest(machines, name):
    """The input chain of section 3."""
    for words in ("add table inet filter",
                  "add chain inet filter input { type filter hook input priority 0 ; policy drop ; }",
                  "add rule inet filter input iifname lo accept"):
        machines.filter(name, words.split())


def runs(status):
    """With a standby for each planner and the supervisor."""
    states = collections.Counter(node["state"] for node in status["nodes"] if node["alive"])
    return (status["mode"] == "run" and len(status["nodes"]) == 12
            and states == collections.Counter(running=9, standby=3)
            and all(arm["mode"] == "run" for arm in status["arms"]))


def lost(host, status, known):
    """A condition: the fault is reported, and is not one of these ids."""
    return any(fault["kind"] == "host_lost" and fault["subject"] == host and fault["id"] not in known
               for fault in status["faults"])


def planner_of(arm, status):
    return next(entry["planner"] for entry in status["arms"] if entry["name"] == arm)


def install(guide, machines):
    """Section 1, without the parts that the image contains."""
    for name in guide.machines:
        for command in guide.commands(1):
            if not command.startswith("apt-get"):
                machines.type(name, command)


def write_cell(guide, machines):
    """Section 2: on the first machine, and from there to every other machine."""
    first = next(iter(guide.machines))
    for command in guide.commands(2):
        if not command.startswith("scp"):
            said = machines.type(first, command)
            if command.startswith("hecaton") and "this cell can start" not in said:
                raise RuntimeError(f"it says otherwise: {said}")
            continue
        _, _, source, target = shlex.split(command)
        address, folder = re.fullmatch(r"root@([\d.]+):(.+)", target).groups()
        print(f"{first}# {command}", flush=True)
        machines.copy(first, source, machines.named(address), folder)


def open_ports(guide, machines):
    """Section 3."""
    for name in guide.machines:
        refuse_the_rest(machines, name)
        for command in guide.commands(3):
            print(f"{name}# {command}", flush=True)
            machines.filter(name, shlex.split(command)[1:])


def start_agents(guide, unit, machines):
    """Of section 5: what systemd would start. Returns the services by machine, the operator's environment and other commands."""
    services, environment, rest = {}, None, []
    for command in guide.commands(5):
        if command.startswith("systemctl"):
            name = command.split("@")[1]
            services[name] = Service(unit, machines, name)
            print(f"{name}# {command}\n  {services[name].line}", flush=True)
        elif command.startswith("export"):
            environment = command
        else:
            rest.append(command)
    return services, environment, rest


CRATE = "obstacle add crate --box '0.1 0.1 0.1' --pose '0 1.5 0.05 0 0 0'"


def another_world(status):
    """A condition: the world's process is another one than in `status`, for it has done fewer ticks than before."""
    def ticks(status):
        return next(node["ticks"] for node in status["nodes"] if node["node"] == "world")

    newest = ticks(status)

    def condition(now):
        nonlocal newest
        before, newest = newest, ticks(now)
        return newest < before

    return condition


def lose_an_agent(name, service, machines, environment, watch):
    """What people have put into the world outlives the agent of its host, as section 5 says."""
    machines.type(name, f"{environment}; hecaton {CRATE}")
    is_another = another_world(watch.until("it runs with a crate", runs))
    machines.type(name, "kill -9 $(pidof hecaton-agent)")
    service.start_again()
    watch.until("there is another world", is_another)
    watch.until(f"the agent of {name} has come back", runs)
    machines.type(name, f"{environment}; hecaton obstacle remove crate")  # fails if there is none


def take_over(guide, machines, environment, watch):
    """Section 7, but for its last cable."""
    expected = iter((("planner/left@right-pc is in charge", lambda status: planner_of("left", status) == "planner/left@right-pc"),
                     ("supervisor@left-pc leads", lambda status: status["supervisor"] == "supervisor@left-pc")))
    for name, command in guide.placed_commands(7):
        print(machines.type(name, f"{environment}; {command}"))
        if command.startswith("kill"):
            watch.until(*next(expected))
            watch.until("the killed supervisor is standby", runs)


def pull(name, machines, watch, told, condition):
    """Disconnects a machine for a while, until `condition` holds."""
    known = [fault["id"] for fault in watch.until("all is well", runs)["faults"]]
    machines.pull_cable(name)
    watch.until(told, lambda status: lost(name, status, known) and condition(status))
    machines.plug_cable(name)
    watch.until("with the cable it goes on", runs)


def follow(guide, unit, machines):
    first, *_, last = guide.machines
    install(guide, machines)
    write_cell(guide, machines)
    open_ports(guide, machines)
    services, environment, looks = start_agents(guide, unit, machines)

    def watch_on(name):
        return contextlib.closing(Watch(lambda command, **streams: machines.start(name, command, **streams), environment))

    with watch_on(last) as watch:
        watch.until("twelve nodes are there", runs)
        for command in looks:
            print(machines.type(last, f"{environment}; {command}"))
        for command in (*guide.commands(6), "hecaton resume"):
            machines.type(last, f"{environment}; {command}")
        lose_an_agent(last, services[last], machines, environment, watch)
        take_over(guide, machines, environment, watch)
        pull(first, machines, watch, f"the fault is {first}", lambda status: True)  # what the guide ends with
    with watch_on(first) as watch:
        pull(last, machines, watch, f"the fault is {last}, supervisor@left-pc reports it, and the arms are held",
             lambda status: status["supervisor"] == "supervisor@left-pc" and status["mode"] != "run")
    ended = [name for name, service in services.items() if service.has_ended()]
    if ended:
        raise RuntimeError(f"agents have ended: {', '.join(ended)}")


def contain(guide, image):
    """Section 8. What people have put into the world outlives its container, too."""
    up, look, down = [command.replace("/usr/share/hecaton", str(DEPLOY)) for command in guide.commands(8)]
    script, _, cell = shlex.split(up)
    last = list(guide.machines)[-1]
    os.environ["HECATON_IMAGE"] = image

    def typed(command):
        print(f"# {command}", flush=True)
        return run(*shlex.split(command))

    def container(name):
        return f"hecaton-our_cell-{name}"

    # Looked for itself, for podman 4.3 keeps a container's own memory when it starts that again. Docker does not.
    def memory():
        return list(pathlib.Path("/dev/shm").glob(f"hecaton-*-our_cell@{last}"))

    def start(command, **streams):
        return start_in(container(next(iter(guide.machines))), command, **streams)

    try:
        print(typed(up))
        with contextlib.closing(Watch(start, f"export HECATON_CELL={shlex.quote(cell)}")) as watch:
            watch.until("twelve nodes are there", runs)
            print(typed(look))
            typed(f"{script} run {cell} {CRATE}")
            is_another = another_world(watch.until("it runs with a crate", runs))
            if not memory():
                raise RuntimeError("what the run must remember is not in the machine's memory")
            os.kill(int(run("podman", "inspect", "--format", "{{.State.Pid}}", container(last))), signal.SIGKILL)
            watch.until("there is another world", is_another)
            watch.until(f"the container of {last} has come back", runs)
            typed(f"{script} run {cell} obstacle remove crate")  # fails if there is none
    finally:
        typed(down)
    if memory():
        raise RuntimeError(f"the run has not ended; there is {memory()[0]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--guide", type=pathlib.Path, required=True)
    parser.add_argument("--unit", type=pathlib.Path, required=True)
    parser.add_argument("--image", required=True)
    options = parser.parse_args()
    guide = Guide(options.guide.read_text())
    try:
        machines = Machines(options.image, guide.machines)
    except CannotRun as reason:
        print(f"skipped: {reason}", file=sys.stderr)
        return SKIPPED
    for command, instead in OTHERWISE:
        print(f"replaced here: {command}: {instead}", flush=True)
    try:
        follow(guide, options.unit.read_text(), machines)
    finally:
        machines.close()
    contain(guide, options.image)
    print("all commands of the guide work")
    return 0


if __name__ == "__main__":
    sys.exit(main())
