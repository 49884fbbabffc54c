"""Keeps obstacles of a running cell at what a camera sees: clusters of points become convex hulls that appear, move and go.

The camera is a function that makes point clouds. Replace frames() by yours: it yields a dictionary of clouds, shape (N, 3), in W.
"""
import argparse
import sys
from typing import Iterator

import numpy as np
from numpy.typing import NDArray

import hecaton

PREFIX = "seen_"


def frames(count: int) -> Iterator[dict[int, NDArray[np.float64]]]:
    """A box that drives past the cell, and a cone that is there half of the time."""
    random = np.random.default_rng(1)
    box = random.uniform(-0.1, 0.1, size=(400, 3))
    angle, height = random.uniform(0, 2 * np.pi, 400), random.uniform(0, 0.3, 400)
    cone = np.column_stack([(0.3 - height) * np.cos(angle), (0.3 - height) * np.sin(angle), height])
    for i in range(count):
        clouds = {1: box + [1.6, -1.0 + 2.0 * i / count, 0.5]}
        if i % 20 < 10:
            clouds[2] = cone + [-1.8, 0, 0]
        yield clouds


class SeenObstacles:
    """Makes the cell's obstacles those of the newest frame. A cloud of the same identifier is the same rigid body. The cell rejects
    what touches an arm: the next frame tries again."""

    def __init__(self, world: hecaton.World) -> None:
        self._world = world
        self._known: set[str] = set()

    def update(self, clouds: dict[int, NDArray[np.float64]]) -> list[hecaton.Rejected]:
        seen = {f"{PREFIX}{identifier}": points for identifier, points in clouds.items()}
        rejections = []
        for name in sorted(self._known | seen.keys()):
            try:
                self._edit(name, seen.get(name))
            except hecaton.Rejected as error:
                rejections.append(error)
        return rejections

    def _edit(self, name: str, points: NDArray[np.float64] | None) -> None:
        if points is None:
            self._world.remove(name)
            self._known.remove(name)
            return
        centre = points.mean(axis=0)
        if name in self._known:
            self._world.move(name, hecaton.Pose(centre))
        else:
            self._world.add(name, hecaton.ConvexHull(points - centre), hecaton.Pose(centre))
            self._known.add(name)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cell", help="cell file")
    parser.add_argument("frames", nargs="?", type=int, default=20, help="number of frames (20)")
    arguments = parser.parse_args()
    try:
        with hecaton.connect(arguments.cell, timeout=20) as cell:
            obstacles = SeenObstacles(cell.world)
            for clouds in frames(arguments.frames):
                for error in obstacles.update(clouds):
                    print(f"{error.kind}: {error}", file=sys.stderr)
            obstacles.update({})
            left = [state.name for state in cell.world.obstacles() if state.name.startswith(PREFIX)]
            print(f"{arguments.frames} frames; obstacles left: {len(left)}")
    except hecaton.Error as error:
        print(f"{error.kind}: {error}", file=sys.stderr)
        return 1
    return 0


sys.exit(main())
