#!/usr/bin/env python3
"""The cost of supervision: processor time, memory and traffic of a supervisor for cells of N arms.

usage: supervision_cost.py BIN [--arms 3,10,30] [--seconds 20]

BIN is the folder of Hecaton's programs. The supervisor is the real one. One process publishes the messages of all planners,
drivers, agents and the world of such a cell, at their rates (heartbeats every 10 ms, arm states every 2 ms). The kernel
counts the bytes on the loopback interface of a separate network namespace. The script starts itself in `unshare -rn`.
"""
import json
import os
import pathlib
import subprocess
import sys
import time

from cell_cost import Cost, for_each_size, resident_megabytes, running

PATIENCE = 60.0  # [s]
INSIDE = "HECATON_SUPERVISION_COST_INSIDE"


def loopback_bytes():
    for line in pathlib.Path("/proc/net/dev").read_text().splitlines():
        name, _, counters = line.partition(":")
        if name.strip() == "lo":
            return int(counters.split()[0])
    raise RuntimeError("no loopback interface")


def wait_until_all_are_heard(programs, cell, nodes):
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        answer = subprocess.run([programs / "hecaton", "-o", "json", "status"], capture_output=True, text=True)
        if answer.returncode == 0:
            heard = sum(1 for node in json.loads(answer.stdout)["nodes"] if node["alive"])
            if heard >= nodes:
                return
        time.sleep(0.2)
    raise SystemExit(f"supervision_cost: not all {nodes} nodes were heard within {PATIENCE:.0f} s: {answer.stdout[-2000:]}{answer.stderr}")


def measure(programs, cell, arms, seconds, folder, log):
    cell.write_text(cell.read_text() + "network: {interface: 127.0.0.1}\n")
    with running(log, programs / "supervision-crowd", cell):
        time.sleep(2.0)
        begin = loopback_bytes()
        time.sleep(seconds)
        alone = (loopback_bytes() - begin) / seconds
        with running(log, programs / "hecaton-supervisor", cell) as supervisor:
            wait_until_all_are_heard(programs, cell, 2 * arms + 3)
            time.sleep(2.0)
            begin = loopback_bytes()
            with Cost(supervisor.pid) as cost:
                time.sleep(seconds)
            told = (loopback_bytes() - begin) / cost.seconds
            print(f"{arms:5} {100 * cost.share:10.1f} % {resident_megabytes(supervisor.pid):9.1f} MB "
                  f"{(told - alone) / 1e6:9.2f} MB/s", flush=True)


def main():
    if INSIDE not in os.environ:
        os.environ[INSIDE] = "1"
        os.execvp("unshare", ["unshare", "-rn", "sh", "-c", 'ip link set lo up; exec "$@"', "sh", sys.executable, *sys.argv])
    for_each_size(__doc__, "3,10,30", f"{'arms':>5} {'processor':>12} {'memory':>12} {'hears and tells':>14}", measure)


if __name__ == "__main__":
    main()
