#!/usr/bin/env python3
"""Live cells of N arms on a grid, all processes on this machine: start, cost of each kind of process, messages, goals, and a fault.

usage: live_growth.py BIN [--arms 3,10,30] [--clock 1,0.3,0.1] [--tasks 30] [--seconds 20] [--keys]

BIN is the folder of Hecaton's programs. --keys: the cells have keys. --clock: for each N the share of the usual speed (deploy/cells/grid_cell.py). The arms
move to random goals, and the script measures for --seconds. Then it kills a planner and a driver, and waits until the cell names
both and runs again. It starts itself in a network namespace (`unshare -rn`), whose datagrams the kernel counts. Columns:
  start                until all arms may move
  planner % …          processor time of each kind of process, in per cent of a core: the mean and the greatest
  recovery             from the deaths until the cell has named both and runs; inf: the goals were over before
  datagrams, each arm  in a second, divided by the clock: as they would be at the usual speed
"""
import argparse
import collections
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from cell_cost import ROOT, processor_seconds, resident_megabytes, with_keys

INSIDE = "HECATON_LIVE_GROWTH_INSIDE"
START = 600.0  # [s]
KINDS = {"hecaton-planner": "planner", "hecaton-arm-dri": "driver", "hecaton-world": "world", "hecaton-supervi": "supervisor",
         "hecaton-agent": "agent"}


def processes():
    """Process numbers by kind of process."""
    found = collections.defaultdict(list)
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            name = (entry / "comm").read_text().strip()
            inside = os.readlink(entry / "ns/net") == os.readlink("/proc/self/ns/net")
        except OSError:
            continue
        if inside and name in KINDS:
            found[KINDS[name]].append(int(entry.name))
    return found


def datagrams():
    """Received in this network namespace so far."""
    lines = [line.split() for line in pathlib.Path("/proc/net/snmp").read_text().splitlines() if line.startswith("Udp:")]
    return int(lines[1][lines[0].index("InDatagrams")])


def ask(programs, cell, what):
    """The answer of `hecaton WHAT`; None: the cell does not answer."""
    answer = subprocess.run([programs / "hecaton", "--cell", cell, "-o", "json", what], capture_output=True, text=True)
    return json.loads(answer.stdout) if answer.returncode == 0 else None


def wait_until(condition, up):
    """The time until `condition` held [s]; infinite when the cell `up` ended before, or after START."""
    began = time.monotonic()
    while not condition():
        if time.monotonic() - began > START or up.poll() is not None:
            return float("inf")
        time.sleep(0.1)
    return time.monotonic() - began


def runs(programs, cell, arms):
    told = ask(programs, cell, "status")
    return told is not None and len(told["arms"]) == arms and all(arm["planner_alive"] and (arm["state"] or {}).get("mode") == "running" for arm in told["arms"])


def cost(kind, spent):
    shares = [100 * share for share in spent[kind]]
    return f"{sum(shares) / len(shares):5.1f}, {max(shares):5.1f}"


def kill_and_wait(programs, cell, arms, up):
    """Kills a planner and a driver; the time until the cell has named both and runs again [s]."""
    found = processes()
    for kind in ("planner", "driver"):
        os.kill(sorted(found[kind])[arms // 2], signal.SIGKILL)

    def named():
        told = ask(programs, cell, "faults")
        return told is not None and sum(fault["kind"] == "process_died" for fault in told) >= 2

    return wait_until(named, up) + wait_until(lambda: runs(programs, cell, arms), up)


def measure(programs, arms, clock, options, folder):
    tasks, seconds = options.tasks, options.seconds
    cell = folder / f"grid{arms}.yaml"
    subprocess.run([sys.executable, ROOT / "deploy/cells/grid_cell.py", str(arms), "--clock", str(clock), "--interface", "127.0.0.1",
                    "-o", cell], check=True)
    if options.keys:
        with_keys(programs, cell)
    report = folder / f"{arms}.json"
    with open(folder / f"{arms}.log", "w") as log:
        up = subprocess.Popen([programs / "hecaton", "up", cell, "--headless", "--tasks", str(tasks), "--report", report,
                               "--start-timeout", f"{START:.0f}s"], stdout=log, stderr=log)
        try:
            start = wait_until(lambda: runs(programs, cell, arms), up)
            if start == float("inf"):
                raise SystemExit(f"live_growth: the cell of {arms} arms did not start:\n{(folder / f'{arms}.log').read_text()[-3000:]}")
            before = {kind: {pid: processor_seconds(pid) for pid in pids} for kind, pids in processes().items()}
            messages, began = datagrams(), time.monotonic()
            time.sleep(seconds)
            passed = time.monotonic() - began
            spent = {kind: [(processor_seconds(pid) - used) / passed for pid, used in pids.items()] for kind, pids in before.items()}
            rate = (datagrams() - messages) / passed / clock
            memory = max(resident_megabytes(pid) for pids in before.values() for pid in pids)
            recovered = kill_and_wait(programs, cell, arms, up)
            up.wait()
        finally:
            up.terminate()
            up.wait()
    told = json.loads(report.read_text()) if report.exists() else {}
    print(f"{arms:5} {clock:6} {start:7.1f} s " + " ".join(f"{cost(kind, spent):>14}" for kind in KINDS.values())
          + f" {rate:10.0f} {rate / arms:8.0f} {memory:6.0f} MB {recovered:6.1f} s  exit {up.returncode}, {summary(told)}", flush=True)
    if not told:
        print((folder / f"{arms}.log").read_text()[-3000:])


def summary(told):
    return ", ".join(f"{key} {told[key]}" for key in ("tasks", "reached", "contacts", "min_separation_m")
                     if key in told) or "no report"


def main():
    if INSIDE not in os.environ:
        os.environ[INSIDE] = "1"
        os.execvp("unshare", ["unshare", "-rn", "sh", "-c", 'ip link set lo up; exec "$@"', "sh", sys.executable, *sys.argv])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("--arms", default="3,10,30")
    parser.add_argument("--clock", default="1,0.3,0.1")
    parser.add_argument("--tasks", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--keys", action="store_true")
    options = parser.parse_args()
    clocks = [float(clock) for clock in options.clock.split(",")]
    print(f"{'arms':>5} {'clock':>6} {'start':>9} " + " ".join(f"{kind + ' %':>14}" for kind in KINDS.values())
          + f" {'datagrams':>10} {'each arm':>8} {'memory':>9} {'recovery':>8}  goals", flush=True)
    with tempfile.TemporaryDirectory(prefix="hecaton_growth_") as name:
        for i, arms in enumerate(map(int, options.arms.split(","))):
            measure(options.programs.resolve(), arms, clocks[min(i, len(clocks) - 1)], options, pathlib.Path(name))


if __name__ == "__main__":
    main()
