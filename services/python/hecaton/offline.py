"""A cell file without a network: checks, kinematics, distances, plans and simulations."""

from __future__ import annotations

import os
from typing import Mapping, NamedTuple

from . import _arguments, _hecaton
from ._arguments import Joints, Vector
from ._hecaton import PlanAnswer, Pose
from .errors import InvalidArgument

__all__ = ["CellFile", "ArmModel", "Finding", "Limits", "MissedTask", "Separation", "SimulationReport", "load"]

_MOST = 2**31 - 1
_HIGHEST_SEED = 2**64 - 1


class Finding(NamedTuple):
    """A sentence of `hecaton check`; `severity` is error, warning or note."""

    severity: str
    text: str


class Separation(NamedTuple):
    """Two bodies, such as "north/forearm" and "post", and their distance [m]; negative: depth of penetration."""

    a: str
    b: str
    distance: float


class Limits(NamedTuple):
    """Limits of the joints from base to tip [rad | m and per second], NumPy arrays."""

    lower: Vector
    upper: Vector
    velocity: Vector
    acceleration: Vector


class MissedTask(NamedTuple):
    """A simulated task that was not reached."""

    episode: int
    arm: str
    reason: str


class SimulationReport(NamedTuple):
    """Sums over all simulated tasks. `duration` is virtual [s]; `reach_times` are those of the reached goals [s]."""

    tasks: int
    reached: int
    blocked: int
    timed_out: int
    not_drawn: int
    contacts: int
    duration: float
    reach_times: Vector
    smallest: Separation | None
    missed: list[MissedTask]

    def __repr__(self) -> str:
        """All values; of the times their number alone."""
        values = dict(self._asdict(), reach_times=f"<{len(self.reach_times)} times>")
        texts = [f"{key}={value if key == 'reach_times' else repr(value)}" for key, value in values.items()]
        return f"SimulationReport({', '.join(texts)})"


class ArmModel:
    """An arm of a cell file: its joints and its kinematics. A configuration may be the name of a pose."""

    __slots__ = ("_model", "_name", "_poses")

    def __init__(self, model: _hecaton.CellModel, name: str) -> None:
        self._model = model
        self._name = name
        self._poses: dict[str, Vector] = model.poses(name)

    @property
    def name(self) -> str:
        """Name in the cell file."""
        return self._name

    @property
    def joint_names(self) -> list[str]:
        """From base to tip."""
        return self._model.joint_names(self._name)

    @property
    def limits(self) -> Limits:
        """The URDF's, tightened by the cell file."""
        return Limits(**self._model.limits(self._name))

    @property
    def poses(self) -> dict[str, Vector]:
        """Named joint positions [rad | m]."""
        return dict(self._poses)

    @property
    def start(self) -> Vector:
        """Where the arm starts [rad | m]."""
        return self._model.start(self._name)

    def forward(self, q: Joints) -> Pose:
        """The pose of the tool frame in W."""
        return self._model.forward(self._name, self._joints(q))

    def links(self, q: Joints) -> dict[str, Pose]:
        """The poses of all link frames in W, by name."""
        return self._model.links(self._name, self._joints(q))

    def jacobian(self, q: Joints) -> Vector:
        """Shape (6, joints): angular, then linear velocity of the tool frame in W for each joint rate."""
        return self._model.jacobian(self._name, self._joints(q))

    def inverse(self, pose: Pose, *, start: Joints | None = None, free_rotation: str = "none",
                position_tolerance: float = 1e-4, orientation_tolerance: float = 1e-3, collision_free: bool = True,
                seeds: int = 32) -> Vector | None:
        """Joint positions within the limits that bring the tool frame to `pose` in W; None when none is found.

        The search begins at `start` (where the arm starts), then at `seeds` random configurations; it is deterministic.
        Ctrl-C ends it.
        `collision_free`: clear of the arm itself, of obstacles, and of links of other arms that no joint moves.
        """
        begin = None if start is None else self._joints(start)
        return self._model.inverse(self._name, _arguments.pose("pose", pose), begin,
                                   _arguments.word("free_rotation", free_rotation, _hecaton.FREE_ROTATIONS),
                                   _arguments.positive("position_tolerance", position_tolerance, "m"),
                                   _arguments.positive("orientation_tolerance", orientation_tolerance, "rad"),
                                   bool(collision_free), _arguments.whole("seeds", seeds, 0, _MOST))

    def _joints(self, q: Joints) -> Vector:
        if not isinstance(q, str):
            return _arguments.joints(f"joint positions of arm {self._name}", q)
        if q not in self._poses:
            raise InvalidArgument(f"arm {self._name} has no pose '{q}'; its poses are {', '.join(self._poses)}", "unknown_name", q)
        return self._poses[q]

    def __repr__(self) -> str:
        return f"<hecaton.ArmModel {self._name}: {len(self.joint_names)} joints; poses {', '.join(self._poses) or 'none'}>"


class CellFile:
    """A loaded cell file; load() makes it. Constant. Usable from any thread."""

    __slots__ = ("_model",)

    def __init__(self, model: _hecaton.CellModel) -> None:
        self._model = model

    @property
    def name(self) -> str:
        """Name of the cell."""
        return self._model.name

    @property
    def arms(self) -> list[ArmModel]:
        """All arms, in the order of the file."""
        return [self.arm(name) for name in self._model.arms]

    @property
    def obstacles(self) -> list[str]:
        """Names of the obstacles."""
        return self._model.obstacles

    def arm(self, name: str) -> ArmModel:
        """An arm by its name."""
        return ArmModel(self._model, _arguments.text("name", name))

    def check(self) -> list[Finding]:
        """What `hecaton check` finds in the file, errors first; without its draw of a task."""
        return [Finding(*finding) for finding in self._model.check()]

    def nearest(self, positions: Mapping[str, Joints] | None = None) -> Separation:
        """The nearest pair of bodies that can move relative to each other, with obstacles where they start.

        `positions`: joint positions by arm. Other arms are where they start.
        """
        return Separation(*self._model.nearest(self._positions("positions", positions)))

    def plan(self, goal: Mapping[str, Joints], start: Mapping[str, Joints] | None = None, *, method: str | None = None,
             seed: int = 1, budget: float = 10.0, clearance: float = 0.0) -> PlanAnswer:
        """Plans a path around obstacles and other arms, for one arm or for several together.

        `goal`: joint positions by arm. `start`: of any arm, also of one that stays; without it an arm starts as in the
        file. `method`: a global planner, such as rrt_connect. `budget`: time limit [s]. `clearance`: distance kept [m].
        """
        return self._model.plan(self._positions("goal", goal), self._positions("start", start),
                                None if method is None else _arguments.text("method", method),
                                _arguments.whole("seed", seed, 0, _HIGHEST_SEED),
                                _arguments.positive("budget", budget, "s"),
                                _arguments.distance("clearance", clearance))

    def simulate(self, tasks: int = 100, *, seed: int = 1, threads: int = 1) -> SimulationReport:
        """Simulates random conflicting tasks in virtual time, as `hecaton simulate` does. The same seed, the same report."""
        values = self._model.simulate(_arguments.whole("tasks", tasks, 1, _MOST),
                                      _arguments.whole("seed", seed, 0, _HIGHEST_SEED),
                                      _arguments.whole("threads", threads, 1, _MOST))
        values["smallest"] = None if values["smallest"] is None else Separation(*values["smallest"])
        values["missed"] = [MissedTask(*task) for task in values["missed"]]
        return SimulationReport(**values)

    def _positions(self, key: str, positions: Mapping[str, Joints] | None) -> dict[str, Vector]:
        given = {} if positions is None else _arguments.by_arm(key, positions)
        return {name: self.arm(name)._joints(q) for name, q in given.items()}

    def __repr__(self) -> str:
        obstacles = ", ".join(self.obstacles) or "none"
        return f"<hecaton.CellFile {self.name}: arms {', '.join(self._model.arms)}; obstacles {obstacles}>"


def load(path: str | os.PathLike[str]) -> CellFile:
    """Loads a cell file with its URDFs. Raises InvalidArgument, with file and key, for one that cannot start."""
    return CellFile(_hecaton.CellModel.load(os.fspath(path)))
