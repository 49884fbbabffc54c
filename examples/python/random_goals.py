"""Sends random goals to all arms of a running cell, prints a summary, and plots the times if matplotlib is there."""
# %% Options. A notebook has no command line: there the defaults count.
import argparse
import collections
import importlib
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import hecaton

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("cell", nargs="?", default="deploy/cells/three_puma.yaml", help="cell file (%(default)s)")
parser.add_argument("goals", nargs="?", type=int, default=100, help="number of goals (%(default)s)")
parser.add_argument("plot", nargs="?", metavar="PLOT.png", help="picture of the times; none without it")
options = parser.parse_args([] if "ipykernel" in sys.modules else None)

# %% The running cell, and the models of its file.
file = hecaton.load(options.cell)
cell = hecaton.connect(options.cell, timeout=20)
arms = cell.arms()


# %% Each arm gets its share of the goals, one after the other: joint positions around its start, within its limits.
def work(arm: hecaton.Arm, goals: int, seed: int) -> list[hecaton.Outcome]:
    model, random = file.arm(arm.name), np.random.default_rng(seed)
    lower, upper = np.maximum(model.limits.lower, -10), np.minimum(model.limits.upper, 10)
    ended = []
    for _ in range(goals):
        q = np.clip(model.start + random.uniform(-0.5, 0.5, size=model.start.shape), lower, upper)
        ended.append(arm.go_to(q, time_limit=20).wait(30, check=False))
    return ended


shares = [options.goals // len(arms) + (i < options.goals % len(arms)) for i in range(len(arms))]
with ThreadPoolExecutor(len(arms)) as threads:
    groups = list(threads.map(work, arms, shares, range(7, 7 + len(arms))))

# %% The summary.
outcomes = [outcome for group in groups for outcome in group]
counts = collections.Counter(outcome.kind for outcome in outcomes)
times = np.array([outcome.progress.elapsed for outcome in outcomes if outcome and outcome.progress])
print(f"{len(outcomes)} goals: " + ", ".join(f"{count} {kind}" for kind, count in counts.most_common()))
if len(times) > 0:
    print(f"median {np.median(times):.2f} s, longest {times.max():.2f} s")
report = cell.status().contacts
print(f"contacts: {report.contacts if report else 'unknown'}")
cell.close()

# %% The picture.
if options.plot:
    try:
        pyplot = importlib.import_module("matplotlib.pyplot")  # it has types in newer versions only
    except ModuleNotFoundError:
        print("matplotlib is not installed: no plot", file=sys.stderr)
    else:
        figure, axes = pyplot.subplots()
        axes.hist(times, bins=20)
        axes.set(xlabel="time to the goal [s]", ylabel="goals")
        figure.savefig(options.plot)
        print(f"plot in {options.plot}")
