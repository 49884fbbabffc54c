#!/usr/bin/env python3
"""The cost of supervision: processor time, memory and traffic of a supervisor for cells of N arms.

usage: supervision_cost.py BIN [--arms 3,10,30] [--seconds 20]

BIN is the folder of Hecaton's programs. The supervisor is the real one. One process publishes the messages of all planners,
drivers, agents and the world of such a cell, at their rates (heartbeats every 10 ms, arm states every 2 ms). The kernel
counts the bytes on the loopback interface of a separate network namespace. The script starts itself in `unshare -rn`.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATIENCE = 60.0  # [s]
INSIDE = "HECATON_SUPERVISION_COST_INSIDE"


def loopback_bytes():
    for line in pathlib.Path("/proc/net/dev").read_text().splitlines():
        name, _, counters = line.partition(":")
        if name.strip() == "lo":
            return int(counters.split()[0])
    raise RuntimeError("no loopback interface")


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_megabytes(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


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


def measure(programs, arms, seconds, folder):
    cell = folder / f"grid{arms}.yaml"
    subprocess.run([sys.executable, ROOT / "deploy/cells/grid_cell.py", str(arms), "-o", cell], check=True)
    cell.write_text(cell.read_text() + "network: {interface: 127.0.0.1}\n")
    with open(folder / f"{arms}.log", "w") as log:
        crowd = subprocess.Popen([programs / "supervision-crowd", cell], stderr=log)
        time.sleep(2.0)
        begin = loopback_bytes()
        time.sleep(seconds)
        alone = (loopback_bytes() - begin) / seconds
        supervisor = subprocess.Popen([programs / "hecaton-supervisor", cell], stderr=log)
        try:
            wait_until_all_are_heard(programs, cell, 2 * arms + 3)
            time.sleep(2.0)
            begin, spent, at = loopback_bytes(), processor_seconds(supervisor.pid), time.monotonic()
            time.sleep(seconds)
            passed = time.monotonic() - at
            spent = processor_seconds(supervisor.pid) - spent
            told = (loopback_bytes() - begin) / passed
            print(f"{arms:5} {100 * spent / passed:10.1f} % {resident_megabytes(supervisor.pid):9.1f} MB "
                  f"{(told - alone) / 1e6:9.2f} MB/s", flush=True)
        finally:
            for process in (supervisor, crowd):
                process.terminate()
                process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--arms", default="3,10,30")
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    if INSIDE not in os.environ:
        os.environ[INSIDE] = "1"
        os.execvp("unshare", ["unshare", "-rn", "sh", "-c", 'ip link set lo up; exec "$@"', "sh", sys.executable, *sys.argv])
    print(f"{'arms':>5} {'processor':>12} {'memory':>12} {'hears and tells':>14}")
    with tempfile.TemporaryDirectory(prefix="hecaton_cost_") as folder:
        for arms in options.arms.split(","):
            measure(options.programs.resolve(), int(arms), options.seconds, pathlib.Path(folder))


if __name__ == "__main__":
    main()
