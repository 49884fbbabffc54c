"""Hosts as podman containers on a bridge, from an image of the package. This machine is the operator's machine."""
import ipaddress
import os
import shutil
import subprocess

from hosts import CannotRun, Hosts, run


class Containers(Hosts):
    kind = "podman containers"

    def __init__(self, image, *folders):
        """`folders`: folders of this machine that the hosts can read."""
        for tool in ("podman", "nsenter", "nft"):
            if shutil.which(tool) is None:
                raise CannotRun(f"{tool} is missing")
        if subprocess.run(["podman", "image", "exists", image]).returncode != 0:
            raise CannotRun(f"podman has no image {image}; run ./run image")
        tried = subprocess.run(["podman", "run", "--rm", "--cap-add", "IPC_LOCK", image, "--version"], capture_output=True, text=True)
        if tried.returncode != 0:
            raise CannotRun(f"podman cannot run a container: {tried.stderr.strip() or tried.returncode}")
        self._image = image
        self._volumes = [word for folder in folders for word in ("--volume", f"{folder}:{folder}:ro")]
        self._network = f"hecaton-test-{os.getpid()}"
        self._addresses = {}

    def _name(self, host):
        return f"{self._network}-{host}"

    def add(self, name, address):
        if not self._addresses:
            network = ipaddress.ip_interface(f"{address}/24").network
            run("podman", "network", "create", "--disable-dns", "--subnet", str(network), self._network)
        self._addresses[name] = address

    def start(self, host, arguments, log):
        return subprocess.Popen(
            ["podman", "run", "--rm", "--replace", "--name", self._name(host), "--hostname", host, "--network", self._network,
             "--ip", self._addresses[host], "--cap-add", "IPC_LOCK", *self._volumes, self._image, *arguments],
            stdout=log, stderr=log)

    def inside(self, host, words):
        pid = run("podman", "inspect", "--format", "{{.State.Pid}}", self._name(host)).strip()
        return run("nsenter", "--target", pid, "--net", *words)

    def signal(self, host, pid, number):
        run("podman", "exec", self._name(host), "bash", "-c", f"kill -{int(number)} {int(pid)}")

    def pause(self, host):
        run("podman", "pause", self._name(host))

    def go_on(self, host):
        run("podman", "unpause", self._name(host))

    def cut_power(self, host):
        run("podman", "kill", "--signal", "KILL", self._name(host))

    def disconnect(self, host):
        run("podman", "network", "disconnect", self._network, self._name(host))

    def connect(self, host):
        run("podman", "network", "connect", "--ip", self._addresses[host], self._network, self._name(host))

    def close(self):
        run("podman", "rm", "--force", "--ignore", *[self._name(host) for host in self._addresses])
        run("podman", "network", "rm", "--force", self._network)
        self._addresses = {}
