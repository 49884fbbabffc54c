"""Follows docs/guide/three-machines.md to the letter, with three containers as its machines.

usage: follow_guide.py --guide FILE --unit FILE --image NAME

The commands are taken from the guide as they stand there. Three are done otherwise, for want of what they need: the
image has the package already, installed as the guide says; files go by `podman cp` instead of `scp`; and what systemd
would start is started by the ExecStart line of the unit. Chrony is left out: containers have one clock. Exit code 77: no
containers here."""
import argparse
import contextlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import threading

from containers import Containers
from hosts import CannotRun, run

SKIPPED = 77  # as CTest is told
PATIENCE = 120  # [s] far beyond what any machine needs


class Guide:
    def __init__(self, text):
        self._sections = dict(re.findall(r"^## (\d+)\. .*?\n(.*?)(?=^## |\Z)", text, flags=re.M | re.S))
        rows = re.findall(r"^\| \d \| ([\d.]+) \| `(\S+)` \|", text, flags=re.M)
        self.machines = {name: address for address, name in rows}
        self.cell = re.search(r"^```yaml\n(.*?)^```", text, flags=re.M | re.S)[1]

    def commands(self, section):
        """What is to be typed there, line by line, without remarks."""
        prose = re.sub(r"^```.*?^```", "", self._sections[str(section)], flags=re.M | re.S)
        return [line.split("  #")[0].strip() for line in re.findall(r"^ {4}(\S.*)$", prose, flags=re.M)]


class Machines:
    """Containers that do nothing by themselves."""

    def __init__(self, image, machines):
        Containers(image, "/")  # or says why there can be none
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
        return subprocess.Popen(["podman", "exec", self._container(name), "bash", "-c", command], text=True, **streams)

    def type(self, name, command):
        """Its output; it must succeed."""
        print(f"{name}# {command}", flush=True)
        done = self.start(name, command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        output = done.communicate(timeout=PATIENCE)[0]
        if done.returncode != 0:
            raise RuntimeError(f"exit code {done.returncode}: {output}")
        return output

    def write(self, name, path, text):
        with tempfile.NamedTemporaryFile("w") as file:
            file.write(text)
            file.flush()
            run("podman", "cp", file.name, f"{self._container(name)}:{path}")

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


class Watch:
    """What `hecaton status --watch` tells on a machine."""

    def __init__(self, machines, name, environment):
        self._process = machines.start(name, f"{environment}; exec hecaton status --watch -o json --connect-timeout "
                                       f"{PATIENCE}s", stdout=subprocess.PIPE)

    def until(self, what, condition):
        ended = threading.Timer(PATIENCE, self._process.kill)
        ended.start()
        status = None
        for line in self._process.stdout:
            status = json.loads(line)
            if condition(status):
                ended.cancel()
                print(f"  {what}", flush=True)
                return
        raise RuntimeError(f"{what}: not within {PATIENCE} s; last: {json.dumps(status)}")

    def close(self):
        self._process.kill()
        self._process.wait()


def refuse_the_rest(machines, name):
    """The input chain that section 3 speaks of."""
    for words in ("add table inet filter",
                  "add chain inet filter input { type filter hook input priority 0 ; policy drop ; }",
                  "add rule inet filter input iifname lo accept"):
        machines.filter(name, words.split())


def runs(nodes):
    return lambda status: (status["mode"] == "run" and len(status["nodes"]) == nodes
                           and all(node["state"] == "running" for node in status["nodes"])
                           and all(arm["mode"] == "run" for arm in status["arms"]))


def install(guide, machines):
    """Section 1, but for what the image has done."""
    for name in guide.machines:
        for command in guide.commands(1):
            if not command.startswith("apt-get"):
                machines.type(name, command)


def write_cell(guide, machines):
    """Section 2: on the first machine, and from there to the others."""
    first = next(iter(guide.machines))
    written = False
    for command in guide.commands(2):
        if command.startswith(("hecaton", "scp")) and not written:
            machines.write(first, "/etc/hecaton/cell.yaml", guide.cell)
            written = True
        if not command.startswith("scp"):
            said = machines.type(first, command)
            if command.startswith("hecaton") and "this cell can start" not in said.splitlines()[-1]:
                raise RuntimeError(f"it ends otherwise: {said}")
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
    """Of section 5: what systemd would start. Returns the processes, the operator's environment and other commands."""
    agents, environment, rest = [], None, []
    for command in guide.commands(5):
        if command.startswith("systemctl"):
            name = command.split("@")[1]
            line = re.search(r"^ExecStart=(.*)$", unit, flags=re.M)[1].replace("%i", name)
            print(f"{name}# {command}\n  {line}", flush=True)
            agents.append(machines.start(name, f"exec {line}", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        elif command.startswith("export"):
            environment = command
        else:
            rest.append(command)
    return agents, environment, rest


def follow(guide, unit, machines):
    first, *_, last = guide.machines
    install(guide, machines)
    write_cell(guide, machines)
    open_ports(guide, machines)
    agents, environment, looks = start_agents(guide, unit, machines)
    with contextlib.closing(Watch(machines, last, environment)) as watch:
        watch.until("nine nodes are running", runs(9))
        for command in looks:
            print(machines.type(last, f"{environment}; {command}"))
        for command in (*guide.commands(6), "hecaton resume"):
            machines.type(last, f"{environment}; {command}")
        watch.until("it runs again", runs(9))
        # What the guide ends with.
        machines.pull_cable(first)
        watch.until(f"the fault is {first}", lambda status: any(
            fault["kind"] == "agent_lost" and fault["subject"] == first for fault in status["faults"]))
        machines.plug_cable(first)
        watch.until("with the cable it goes on", runs(9))
    if any(agent.poll() is not None for agent in agents):
        raise RuntimeError("an agent has ended by itself")


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
    try:
        follow(guide, options.unit.read_text(), machines)
    finally:
        machines.close()
    print("the guide holds")
    return 0


if __name__ == "__main__":
    sys.exit(main())
