#!/usr/bin/env python3
"""What the Python package costs and whether it loses anything: goals to three arms, then calls as of an hour.

usage: python_cost.py BUILD [--goals 1000] [--calls 36000]

BUILD is the build folder, such as build/release. The script starts a cell of its own. An hour has 36,000 calls for each arm, as of
a program that reads states ten times a second.
"""
import argparse
import collections
import gc
import os
import pathlib
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def prepare(build):
    """What CTest sets for the tests of the package."""
    os.environ.update(HECATON_BIN=str(build / "bin"), HECATON_SOURCE=str(ROOT), HECATON_ROBOTS=str(ROOT / "deploy/robots"),
                      HECATON_CELLS=str(ROOT / "deploy/cells"))
    sys.path[:0] = [str(build / "python"), str(ROOT / "tests/cell/python")]


def resident():
    """Resident memory of this process [kB]."""
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def cost(name, calls, call):
    took = []
    for _ in range(calls):
        begin = time.perf_counter()
        call()
        took.append(1e6 * (time.perf_counter() - begin))
    took.sort()
    print(f"{name}: median {took[len(took) // 2]:.1f} µs, p99 {took[len(took) * 99 // 100]:.1f} µs", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, metavar="BUILD")
    parser.add_argument("--goals", type=int, default=1000)
    parser.add_argument("--calls", type=int, default=36000)
    options = parser.parse_args()
    prepare(options.build.resolve())
    import numpy as np
    import hecaton
    from live_cell import Domain, Up, still_cell
    domain = Domain()
    with tempfile.TemporaryDirectory() as folder:
        file = still_cell(folder)
        up = Up(file, domain.number)
        try:
            with hecaton.connect(file, domain=domain.number, timeout=60) as cell:
                arms = cell.arms(60)
                poses = [arm.state(60).q for arm in arms]
                outcomes = collections.Counter()
                marks = []
                for i in range(-(-options.goals // len(arms))):
                    step = np.array([0.02 if i % 2 else -0.02, 0, 0, 0, 0, 0])
                    goals = [arm.go_to(q + step) for arm, q in zip(arms, poses)]
                    for goal in goals:
                        goal.on_progress(lambda progress: None)
                    outcomes.update(outcome.kind for outcome in cell.wait_all(goals, 120, check=False))
                    if i % 50 == 49:
                        gc.collect()
                        marks.append(resident())
                print(f"{sum(outcomes.values())} goals: {dict(outcomes)}; resident after each 150 [kB]: {marks}", flush=True)
                gc.collect()
                before = resident()
                begin = time.perf_counter()
                for _ in range(options.calls):
                    for arm in arms:
                        arm.state()
                    arms[0].goal
                gc.collect()
                print(f"{options.calls * len(arms)} states in {time.perf_counter() - begin:.0f} s: resident {before} kB, then "
                      f"{resident()} kB", flush=True)
                goal = arms[0].go_to(poses[0])
                goal.wait(120)
                cost("arm.state()", 5000, arms[0].state)
                cost("goal.progress", 5000, lambda: goal.progress)
                cost("arm.go_to(q)", 100, lambda: arms[0].go_to(poses[0]))
                cost("cell.status()", 100, lambda: cell.status(60))
        finally:
            up.close()
            domain.close()


if __name__ == "__main__":
    main()
