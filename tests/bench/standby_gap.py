#!/usr/bin/env python3
"""How long an arm is without commands when its planner is lost and its standby takes over, on two hosts of this machine.

usage: standby_gap.py BIN [--trials N] [--signals KILL,STOP] [--lease 20ms]

BIN is the folder of Hecaton's programs. For each trial the planner in charge of an arm gets the signal (a stopped one goes on
once it has been replaced). The gap is the driver's own: from the arrival of the old planner's last command to that of the new
one's first. Without a loss it is a control period. Beside it, the same run's timer lateness: how much later than asked this
script was woken, which no process of the machine can undercut.
"""
import argparse
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

CELL = """name: standby_gap
network: {{interface: 127.0.0.1}}
hosts: {{alpha: 127.0.0.1, beta: 127.0.0.2}}
world: {{host: alpha}}
supervision: {{host: alpha, failover_timeout: {lease}}}
defaults:
  urdf: {urdf}
  limits: {{velocity: 1.5, acceleration: 10}}
  poses: {{home: [0, -1.9, 2.6, 0, 0.6, 0]}}
arms: [{{name: arm, host: alpha, standby_host: beta}}]
"""
PERIOD_MS = 10.0
PATIENCE = 60.0  # [s]
STEADY = 11.0  # a process with this uptime is restarted without extra delay [s]


class Lateness(threading.Thread):
    """Sleeps a millisecond at a time and keeps how much longer it took."""

    def __init__(self):
        super().__init__(daemon=True)
        self.late_ms = []

    def run(self):
        while True:
            asked = time.monotonic() + 0.001
            time.sleep(0.001)
            self.late_ms.append(1e3 * (time.monotonic() - asked))


class Cell:
    def __init__(self, programs, folder, cell, domain):
        self.programs, self.cell, self.domain = programs, cell, domain
        self.logs = folder / "logs"
        self.killed = {}  # node → when
        self.agents = [
            subprocess.Popen([programs / "hecaton-agent", cell, "--host", host, "--domain", domain, "--log-dir", self.logs],
                             stderr=open(folder / f"agent-{host}.log", "w"))
            for host in ("alpha", "beta")]

    def status(self):
        answer = subprocess.run([self.programs / "hecaton", "--cell", self.cell, "--domain", self.domain, "-o", "json", "status"],
                                capture_output=True, text=True)
        return json.loads(answer.stdout) if answer.returncode == 0 else None

    def ready(self):
        """The status, once one planner is in charge and another one stands by for it."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            status = self.status()
            if status and status["arms"][0]["standby"] and status["arms"][0]["state"]["mode"] == "running":
                return status
            time.sleep(0.05)
        sys.exit("the cell does not become ready; its logs are in " + str(self.logs.parent))

    def failovers(self):
        """(planner, gap in ms) of each, from the driver's log."""
        text = (self.logs / "driver-arm.log").read_text()
        return [(planner, float(gap)) for planner, gap in
                re.findall(r'event="planner changed" planner=(\S+) .*instead_of=\S+ gap_ms=(\S+)', text)]

    def end(self):
        for agent in self.agents:
            agent.terminate()
        for agent in self.agents:
            agent.wait()


def quantiles(values):
    values = sorted(values)
    at = lambda p: values[min(len(values) - 1, int(p * len(values)))]
    return f"p50 {at(0.5):6.1f}   p90 {at(0.9):6.1f}   p99 {at(0.99):6.1f}   max {values[-1]:6.1f}"


def trial(cell, number):
    status = cell.ready()
    in_charge = status["arms"][0]["planner"]
    pid = next(node["pid"] for node in status["nodes"] if node["node"] == in_charge)
    before = len(cell.failovers())
    if number == signal.SIGKILL:
        time.sleep(max(0.0, cell.killed.get(in_charge, 0.0) + STEADY - time.monotonic()))
        cell.killed[in_charge] = time.monotonic()
    os.kill(pid, number)
    until = time.monotonic() + PATIENCE
    while len(cell.failovers()) == before and time.monotonic() < until:
        time.sleep(0.01)
    if number == signal.SIGSTOP:
        os.kill(pid, signal.SIGCONT)
    taken = cell.failovers()[before:]
    if not taken:
        sys.exit("no standby took over; the logs are in " + str(cell.logs.parent))
    return taken[0][1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=lambda path: pathlib.Path(path).resolve())
    parser.add_argument("--trials", type=int, default=30)
    parser.add_argument("--signals", default="KILL,STOP")
    parser.add_argument("--lease", default="20ms")
    parser.add_argument("--domain", default="98")
    options = parser.parse_args()
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(tempfile.mkdtemp(prefix="hecaton-gap-"))
    path = folder / "cell.yaml"
    path.write_text(CELL.format(lease=options.lease, urdf=root / "deploy/cells/urdf/puma560.urdf"))
    lateness = Lateness()
    lateness.start()
    cell = Cell(options.programs, folder, path, options.domain)
    try:
        for name in options.signals.split(","):
            lateness.late_ms.clear()
            gaps = [trial(cell, getattr(signal, "SIG" + name)) for _ in range(options.trials)]
            late = list(lateness.late_ms)
            print(f"SIG{name}, {len(gaps)} trials [ms]")
            print(f"  gap at the driver        {quantiles(gaps)}")
            print(f"  beyond a control period  {quantiles([max(0.0, gap - PERIOD_MS) for gap in gaps])}")
            print(f"  timer lateness           {quantiles(late)}", flush=True)
        status = cell.ready()
        print(f"commands of a replaced planner that the driver refused: {status['arms'][0]['state']['stale_rejected']}")
    finally:
        cell.end()


main()
