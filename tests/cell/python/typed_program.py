"""A program of a user with types, which nothing runs: test_package.py checks it by mypy --strict."""

import asyncio

import numpy as np
from numpy.typing import NDArray

import hecaton


def watch(progress: hecaton.Progress) -> None:
    print(progress.state, progress.distance, progress.q_goal.shape)


async def all_ready(cell: hecaton.Cell) -> list[hecaton.Outcome]:
    goal = cell.arm("north").go_to("ready")
    outcome = await goal
    print(outcome.kind, (await asyncio.wait_for(goal, 3)).kind, (await goal.ended(3)).kind)
    print([progress.state async for progress in goal])
    return list(await asyncio.gather(*(arm.go_to("ready", time_limit=3) for arm in cell.arms())))


def drive(cell: hecaton.Cell) -> None:
    north = cell.arm("north")
    q: NDArray[np.float64] = north.state().q
    goal = north.go_to(q + 0.1, time_limit=60, free_rotation="roll")
    goals = [north.go_to([0.0, 1, 2]), north.go_to(np.zeros(6, dtype=np.float32)), north.go_to(hecaton.Pose((1, 2, 3)))]
    goals.append(north.follow([0, 1], [[0.0, 0, 0], [1, 2, 3]], path_tolerance=0.1))
    goals.append(north.follow(np.arange(2), np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((2, 6)), path_tolerance=[0.1] * 6))
    goal.on_progress(watch)
    cell.on_fault(print)
    cell.on_fault(lambda fault: print(fault.cause.kind, fault.cleared))
    print([progress.ended for progress in goal.updates()])
    world = cell.world
    print(world.add("crate", hecaton.Box(0.2, 0.2, 0.2), hecaton.Pose.xyz(1.5, 1.5, 0.1)).edition)
    print(world.replace("crate", hecaton.Sphere(0.1), hecaton.Pose(), timeout=None).edition)
    world.add("part", hecaton.ConvexHull(np.zeros((8, 3))), hecaton.Pose(), hecaton.Circle([0, 0, 0], 1))
    print([(state.name, state.pose.position[0], state.attached_to) for state in world.obstacles()])
    cell.hold(["north"])
    modes: list[str] = [arm.mode for arm in cell.status().arms]
    outcomes: list[hecaton.Outcome] = cell.wait_all(goals, 30)
    print(modes, outcomes, asyncio.run(all_ready(cell)))
    try:
        goal.wait(1)
    except hecaton.GoalFailed as failure:
        print(failure.kind, failure.subject, failure.outcome.kind if failure.outcome else None)


def plan(path: str) -> None:
    file = hecaton.load(path)
    arm = file.arm("north")
    q = arm.inverse(arm.forward("ready"), start=arm.start, free_rotation="all")
    if q is None:
        return
    names: dict[str, str] = {"north": "ready"}
    answer = file.plan(names) or file.plan({"north": q, "west": "ready"}, {"east": [0.0] * 6})
    times, positions, _ = answer.trajectory(0.01)
    report = file.simulate(20)
    print(times[-1], positions["north"][0], file.nearest({"north": q}).distance, arm.limits.lower.max())
    print(report.reached, report.smallest.distance if report.smallest else None, report.missed[0].reason)
    print(hecaton.__version__, hecaton.Pose() == arm.forward("ready"), {hecaton.Box(1, 1, 1): "crate"})
    print([finding.text for finding in file.check()], arm.links(q)["tool"].matrix, arm.jacobian(q).T)


if __name__ == "__main__":
    with hecaton.connect("cell.yaml", domain=42, timeout=None) as connected:
        drive(connected)
    plan("cell.yaml")
