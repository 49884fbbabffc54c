#!/usr/bin/env python3
"""What the Python package costs and whether it loses anything: goals to three arms, then calls as of an hour.

usage: python_cost.py BUILD [--goals 1000] [--calls 36000] [--minutes 20] [--kills 9]

BUILD is the build folder, such as build/release. The script starts a cell of its own, whose devices are simulated. An hour has
36,000 calls for each arm, as of a program that reads states ten times a second. Then a program uses the cell for MINUTES of the
clock: states and progress ten times a second, and each second goals or trajectories, obstacle edits and the status. Then it takes
the time of single calls, and client-cost that of the same calls in C++: their ratio is what Python adds. At last the script kills the only planner of an arm and sends a trajectory at once. It measures the time until the next planner answers.
"""
import argparse
import collections
import gc
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from cell_cost import ROOT, resident_megabytes


def prepare(build):
    """What CTest sets for the tests of the package."""
    os.environ.update(HECATON_BIN=str(build / "bin"), HECATON_SOURCE=str(ROOT), HECATON_ROBOTS=str(ROOT / "deploy/robots"),
                      HECATON_CELLS=str(ROOT / "deploy/cells"))
    sys.path[:0] = [str(build / "python"), str(ROOT / "tests/cell/python")]


def cost(calls, call):
    """Median and 99th percentile of the time of a call [µs]."""
    took = []
    for _ in range(calls):
        begin = time.perf_counter()
        call()
        took.append(1e6 * (time.perf_counter() - begin))
    took.sort()
    return took[len(took) // 2], took[len(took) * 99 // 100]


def cost_in_cpp(programs, file, domain, arm):
    """The same for each name of a call, by a program in C++."""
    done = subprocess.run([programs / "client-cost", file, str(domain), arm], check=True, stdout=subprocess.PIPE, text=True)
    lines = [line.split() for line in done.stdout.splitlines()]
    return {name: (float(median), float(p99)) for name, median, p99 in lines}


def compare_calls(cell, arm, q, programs, file, domain):
    goal = arm.go_to(q)
    goal.wait(120)
    python = {"arm.state()": cost(5000, arm.state), "goal.progress": cost(5000, lambda: goal.progress),
              "arm.go_to(q)": cost(100, lambda: arm.go_to(q)), "cell.status()": cost(100, lambda: cell.status(60))}
    cpp = cost_in_cpp(programs, file, domain, arm.name)
    for name, (median, p99) in python.items():
        print(f"{name}: median {median:.1f} µs, p99 {p99:.1f} µs; in C++ {cpp[name][0]:.1f} µs, {cpp[name][1]:.1f} µs; "
              f"ratio of the medians {median / cpp[name][0]:.2f}", flush=True)


def edit(make):
    """Makes an edit, as long as a busy machine lets it wait. One without an answer may have been made: then its repetition is
    rejected."""
    import hecaton
    unanswered = False
    while True:
        try:
            return make()
        except (hecaton.NoAnswer, hecaton.Unreachable) as error:
            unanswered = True
            print(f"  {error}", flush=True)
        except hecaton.Rejected:
            if not unanswered:
                raise
            return None


def use(cell, arms, poses, seconds):
    """Uses the cell, and returns the resident memory at the end of each minute [MB]."""
    import hecaton
    import numpy as np
    box = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)])
    times = np.linspace(0.0, 0.8, 9)
    begin = time.monotonic()
    goals, marks, outcomes = [], [], collections.Counter()
    for tick in range(10 * int(seconds)):
        for arm in arms:
            arm.state(60)
        for goal in goals:
            goal.progress
        if tick % 10 == 0:
            outcomes.update(goal.wait(120, check=False).kind for goal in goals)
            second = tick // 10
            step = np.array([0.02 if second % 2 else 0.0, 0, 0, 0, 0, 0])
            if second % 4 < 2:
                goals = [arm.go_to(q + step) for arm, q in zip(arms, poses)]
            else:
                goals = [arm.follow(times, np.linspace(arm.state(60).q, q + step, 9)) for arm, q in zip(arms, poses)]
            name = f"part{second % 8}"
            if second % 16 < 8:
                edit(lambda: cell.world.add(name, hecaton.ConvexHull(box), hecaton.Pose.xyz(3.0, 3.0, 1.0), timeout=60))
            else:
                edit(lambda: cell.world.remove(name, timeout=60))
            cell.world.obstacles(60)
            cell.status(60)
            cell.faults()
        if tick % 600 == 599:
            gc.collect()
            marks.append(round(resident_megabytes(), 1))
            print(f"  minute {len(marks)}: {marks[-1]} MB, {sum(outcomes.values())} goals", flush=True)
        time.sleep(max(0.0, begin + 0.1 * (tick + 1) - time.monotonic()))
    print(f"{(time.monotonic() - begin) / 60:.1f} minutes of use: {dict(outcomes)}; resident after each [MB]: {marks}")


def seconds_to_answer(cell, arm, programs, domain):
    q = arm.state(60).q
    status = subprocess.run([programs / "hecaton", "-o", "json", "status", "--domain", str(domain)], check=True,
                            capture_output=True, text=True)
    pid = next(node["pid"] for node in json.loads(status.stdout)["nodes"] if node["node"] == f"planner/{arm.name}")
    os.kill(pid, signal.SIGKILL)
    begin = time.monotonic()
    goal = arm.follow([0.0, 1.0], [q, q])
    while goal.progress is None:
        time.sleep(0.01)
    took = time.monotonic() - begin
    goal.wait(120, check=False)
    time.sleep(3.0)  # the agent restarts a process at once that has run for a while
    return round(took, 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, metavar="BUILD")
    parser.add_argument("--goals", type=int, default=1000)
    parser.add_argument("--calls", type=int, default=36000)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--kills", type=int, default=9)
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
                        marks.append(round(resident_megabytes(), 1))
                print(f"{sum(outcomes.values())} goals: {dict(outcomes)}; resident after each 150 [MB]: {marks}", flush=True)
                gc.collect()
                before = resident_megabytes()
                begin = time.perf_counter()
                for _ in range(options.calls):
                    for arm in arms:
                        arm.state()
                    arms[0].goal
                gc.collect()
                print(f"{options.calls * len(arms)} states in {time.perf_counter() - begin:.0f} s: resident {before:.1f} MB, then "
                      f"{resident_megabytes():.1f} MB", flush=True)
                use(cell, arms, poses, 60 * options.minutes)
                programs = options.build.resolve() / "bin"
                compare_calls(cell, arms[0], poses[0], programs, file, domain.number)
                answers = [seconds_to_answer(cell, arms[i % len(arms)], programs, domain.number)
                           for i in range(options.kills)]
                print(f"answers after a killed planner [s]: {sorted(answers)}")
        finally:
            up.close()
            domain.close()


if __name__ == "__main__":
    main()
