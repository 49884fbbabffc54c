"""Keeps obstacles of a running cell at what a camera sees: clusters of points become convex hulls that appear, move and go."""
# %% Options. A notebook has no command line: there the defaults count.
import argparse
import sys
from typing import Iterator

import numpy as np
from numpy.typing import NDArray

import hecaton

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("cell", nargs="?", default="deploy/cells/three_puma.yaml", help="cell file (%(default)s)")
parser.add_argument("frames", nargs="?", type=int, default=20, help="number of frames (%(default)s)")
options = parser.parse_args([] if "ipykernel" in sys.modules else None)

Clouds = dict[int, NDArray[np.float64]]  # points in W, shape (N, 3); those of one identifier are one rigid body


# %% The camera. Replace frames() by yours: here a box drives past the cell, and a cone is there half of the time.
def frames(count: int) -> Iterator[Clouds]:
    random = np.random.default_rng(1)
    box = random.uniform(-0.1, 0.1, size=(400, 3))
    angle, height = random.uniform(0, 2 * np.pi, 400), random.uniform(0, 0.3, 400)
    cone = np.column_stack([(0.3 - height) * np.cos(angle), (0.3 - height) * np.sin(angle), height])
    for i in range(count):
        clouds = {1: box + [1.6, -1.0 + 2.0 * i / count, 0.5]}
        if i % 20 < 10:
            clouds[2] = cone + [-1.8, 0, 0]
        yield clouds


# %% The running cell, and the names of the obstacles in it that the camera has seen.
cell = hecaton.connect(options.cell, timeout=20)
known: set[str] = set()


# %% An edit makes the cell's obstacles those of a frame. The cell rejects what touches an arm: the next frame tries again.
def show(clouds: Clouds) -> None:
    seen = {f"seen_{identifier}": points for identifier, points in clouds.items()}
    for name in sorted(known | seen.keys()):
        try:
            edit(name, seen.get(name))
        except hecaton.Rejected as error:
            print(f"{error.kind}: {error}", file=sys.stderr)


def edit(name: str, points: NDArray[np.float64] | None) -> None:
    if points is None:
        cell.world.remove(name)
        known.remove(name)
        return
    centre = points.mean(axis=0)
    if name in known:
        cell.world.move(name, hecaton.Pose(centre))
    else:
        cell.world.add(name, hecaton.ConvexHull(points - centre), hecaton.Pose(centre))
        known.add(name)


# %% All frames, and then none: the obstacles go.
for frame in frames(options.frames):
    show(frame)
show({})
left = [state.name for state in cell.world.obstacles() if state.name.startswith("seen_")]
print(f"{options.frames} frames; obstacles left: {len(left)}")
cell.close()
