"""Sends random goals to all arms of a running cell, prints a summary, and plots the times if matplotlib is there."""
import argparse
import asyncio
import collections
import sys

import numpy as np
from numpy.typing import NDArray

import hecaton


def draw(model: hecaton.ArmModel, random: np.random.Generator) -> NDArray[np.float64]:
    """Joint positions around the start, within the limits."""
    limits, start = model.limits, model.start
    q = start + random.uniform(-0.5, 0.5, size=start.shape)
    inside: NDArray[np.float64] = np.clip(q, np.maximum(limits.lower, -10), np.minimum(limits.upper, 10))
    return inside


async def work(arm: hecaton.Arm, model: hecaton.ArmModel, goals: int, random: np.random.Generator) -> list[hecaton.Outcome]:
    """Gives one arm its goals, one after the other: the outcomes."""
    outcomes = []
    for _ in range(goals):
        outcomes.append(await arm.go_to(draw(model, random), time_limit=20).ended(30, check=False))
    return outcomes


async def all_arms(cell: hecaton.Cell, file: hecaton.CellFile, goals: int) -> list[hecaton.Outcome]:
    arms = cell.arms()
    share = [goals // len(arms) + (i < goals % len(arms)) for i in range(len(arms))]
    random = [np.random.default_rng(7 + i) for i in range(len(arms))]
    groups = await asyncio.gather(*(work(arm, file.arm(arm.name), n, generator)
                                    for arm, n, generator in zip(arms, share, random)))
    return [outcome for group in groups for outcome in group]


def plot(outcomes: list[hecaton.Outcome], path: str) -> None:
    try:
        import matplotlib
    except ModuleNotFoundError:
        print("matplotlib is not installed: no plot", file=sys.stderr)
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots()
    axes.hist([outcome.progress.elapsed for outcome in outcomes if outcome and outcome.progress], bins=20)
    axes.set(xlabel="time to the goal [s]", ylabel="goals")
    figure.savefig(path)
    print(f"plot in {path}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cell", help="cell file")
    parser.add_argument("goals", nargs="?", type=int, default=100, help="number of goals (100)")
    parser.add_argument("plot", nargs="?", metavar="PLOT.png", help="picture of the times; none without it")
    arguments = parser.parse_args()
    try:
        file = hecaton.load(arguments.cell)
        with hecaton.connect(arguments.cell, timeout=20) as cell:
            outcomes = asyncio.run(all_arms(cell, file, arguments.goals))
            report = cell.status().contacts
    except hecaton.Error as error:
        print(f"{error.kind}: {error}", file=sys.stderr)
        return 1
    counts = collections.Counter(outcome.kind for outcome in outcomes)
    times = np.array([outcome.progress.elapsed for outcome in outcomes if outcome and outcome.progress])
    print(f"{len(outcomes)} goals: " + ", ".join(f"{count} {kind}" for kind, count in counts.most_common()))
    if len(times) > 0:
        print(f"median {np.median(times):.2f} s, longest {times.max():.2f} s")
    print(f"contacts: {report.contacts if report else 'unknown'}")
    if arguments.plot:
        plot(outcomes, arguments.plot)
    return 0


sys.exit(main())
