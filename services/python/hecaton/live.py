"""A running cell: arms, goals, obstacles, faults, hold, resume, stop and speed."""

from __future__ import annotations

import asyncio
import math
import os
import queue
import time
import weakref
from typing import Any, AsyncIterator, Callable, Generator, Iterable, Iterator, Mapping

from . import _arguments, _hecaton
from ._arguments import Motion, Numbers, Rows, Shape, Target, limit
from ._events import Events
from ._hecaton import ArmState, CellStatus, Fault, ObstacleState, Outcome, Pose, Progress, Receipt, SavedRecording, ToolState
from .errors import Error, GoalFailed, InvalidArgument, Rejected, WaitTimeout

__all__ = ["Cell", "Arm", "Goal", "Signals", "Tool", "World", "connect", "ANSWER_LIMIT", "GRIPPER_LIMIT"]

ANSWER_LIMIT = 2.0
"""Default time limit of requests, orders and edits [s]."""
GRIPPER_LIMIT = 15.0
"""The same of an order to a gripper, which moves [s]."""


class _Link:
    """Owns a session. It is closed when the last cell, arm and goal have gone, and before the interpreter ends."""

    __slots__ = ("session", "events", "close", "__weakref__")

    def __init__(self, session: _hecaton.Session) -> None:
        self.session = session
        self.events = Events(session)
        self.close = weakref.finalize(self, self.events.close)


class Goal:
    """A goal of one arm. Losing the object does not cancel the goal: the arm continues.

    `await goal` waits in asyncio and returns the outcome, as `wait` does in other code.
    """

    __slots__ = ("_link", "_native", "_arm")

    def __init__(self, link: _Link, native: _hecaton.NativeGoal, arm: str) -> None:
        self._link = link
        self._native = native
        self._arm = arm

    @property
    def id(self) -> str:
        """Identifier, unique among the goals of the arm."""
        return self._native.id

    @property
    def arm(self) -> str:
        """Name of the arm."""
        return self._arm

    @property
    def progress(self) -> Progress | None:
        """The newest progress; None until a planner has answered. Does not wait."""
        return self._native.progress()

    @property
    def outcome(self) -> Outcome:
        """How the goal stands now. Does not wait and raises no GoalFailed."""
        return self._native.wait(0.0)

    def wait(self, timeout: float | None = None, *, check: bool = True) -> Outcome:
        """Waits until the goal has ended, for at most `timeout` [s], and returns its outcome.

        With `check`, raises GoalFailed for a goal that ended unreached, and WaitTimeout for one that continues. Ctrl-C
        ends the wait; the goal continues. A restarted cell continues it, too: without `timeout` the wait outlasts a
        cell that has ended.
        """
        return self._checked(self._native.wait(limit("timeout", timeout)), check)

    async def ended(self, timeout: float | None = None, *, check: bool = True) -> Outcome:
        """The same for asyncio. A cancelled task leaves the goal as it is: see cancel()."""
        waiter = _Ended(asyncio.get_running_loop())
        self._link.events.subscribe(self._native, waiter)
        try:
            await asyncio.wait_for(waiter.future, limit("timeout", timeout))
        except asyncio.TimeoutError:
            pass
        finally:
            self._link.events.unsubscribe(self.id, waiter)
        return self._checked(self._native.wait(0.0), check)

    def __await__(self) -> Generator[Any, None, Outcome]:
        return self.ended().__await__()

    def cancel(self) -> None:
        """Cancels the goal: the arm brakes. Does not wait: the outcome becomes cancelled when the planner confirms."""
        self._native.cancel()

    def on_progress(self, callback: Callable[[Progress], object]) -> None:
        """Calls `callback` with the newest progress and each later one, until the goal ends.

        It runs in a thread of the connection, one callback after the other; it may wait, but then it delays the next.
        The newest progress may come again when another subscription to the goal begins.
        """
        _arguments.require_function("callback", callback)
        self._link.events.subscribe(self._native, _Callback(callback))

    def updates(self) -> Iterator[Progress]:
        """Iterates over the progress from the newest to the last: `for progress in goal.updates()`."""
        updates = _Updates()
        self._link.events.subscribe(self._native, updates)
        try:
            while (progress := updates.queue.get()) is not None:
                yield progress
                if progress.ended:
                    return
        finally:
            self._link.events.unsubscribe(self.id, updates)

    async def __aiter__(self) -> AsyncIterator[Progress]:
        """The same for asyncio: `async for progress in goal`."""
        updates = _AsyncUpdates(asyncio.get_running_loop())
        self._link.events.subscribe(self._native, updates)
        try:
            while (progress := await updates.queue.get()) is not None:
                yield progress
                if progress.ended:
                    return
        finally:
            self._link.events.unsubscribe(self.id, updates)

    def _checked(self, outcome: Outcome, check: bool) -> Outcome:
        if not check or outcome:
            return outcome
        cause = outcome.cause
        kind = cause.kind if cause else outcome.kind
        subject = cause.subject if cause else ""
        failure = GoalFailed if outcome.ended else WaitTimeout
        raise failure(f"goal of arm {self.arm}: {outcome}", kind, subject or self.arm, outcome)

    def __repr__(self) -> str:
        try:
            outcome = self.outcome
            state = f": {outcome}" if outcome.progress else ": not answered yet"
        except Error:
            state = ""  # the connection is closed
        return f"<hecaton.Goal {self.id} of arm {self.arm}{state}>"


class Tool:
    """The gripper of an arm."""

    __slots__ = ("_link", "_arm")

    def __init__(self, link: _Link, arm: str) -> None:
        self._link = link
        self._arm = arm

    def open(self, width: float | None = None, force: float | None = None, *,
             timeout: float | None = GRIPPER_LIMIT) -> None:
        """Opens the gripper, to `width` [m] or as far as it goes, and releases what it holds where it is.

        The arm must stand. Returns when the gripper has arrived, and raises Rejected with the reason.
        """
        self._grip(False, width, force, timeout)

    def close(self, width: float | None = None, force: float | None = None, *,
              timeout: float | None = GRIPPER_LIMIT) -> None:
        """Closes the gripper on what is between its fingers, which becomes part of the arm. `force` in [N]."""
        self._grip(True, width, force, timeout)

    def state(self, timeout: float | None = ANSWER_LIMIT) -> ToolState:
        """Width, held obstacle and signals, with their age. Unreachable: the arm has no gripper and no signals."""
        return self._link.session.tool_state(self._arm, limit("timeout", timeout))

    def _grip(self, close: bool, width: float | None, force: float | None, timeout: float | None) -> None:
        self._link.session.grip(self._arm, close, None if width is None else _arguments.distance("width", width),
                                None if force is None else _arguments.positive("force", force, "N"),
                                limit("timeout", timeout))

    def __repr__(self) -> str:
        return f"<hecaton.Tool of arm {self._arm}>"


class Signals:
    """The inputs and outputs of an arm's device, by their names in the cell file."""

    __slots__ = ("_link", "_arm")

    def __init__(self, link: _Link, arm: str) -> None:
        self._link = link
        self._arm = arm

    def get(self, name: str, timeout: float | None = ANSWER_LIMIT) -> float | None:
        """The newest value of a signal, 0 or 1 of a digital one; None: the device has not reported any."""
        signals = self._link.session.tool_state(self._arm, limit("timeout", timeout)).signals
        for signal in signals:
            if signal.name == _arguments.text("name", name):
                return signal.value
        names = ", ".join(signal.name for signal in signals) or "no signals"
        raise Rejected(f"arm {self._arm} has no signal {name}; it has {names}", "unknown_name", name)

    def set(self, name: str, value: float, *, timeout: float | None = ANSWER_LIMIT) -> None:
        """Sets an output; of a simulated arm also an input."""
        self._link.session.set_signal(self._arm, _arguments.text("name", name), _arguments.number("value", value),
                                      limit("timeout", timeout))

    def wait(self, name: str, value: float | None = None, *, above: float | None = None, below: float | None = None,
             timeout: float | None = None) -> bool:
        """Waits until a signal has `value`, or one between `above` and `below`. False: not within `timeout` [s]."""
        if (value is None) == (above is None and below is None):
            raise InvalidArgument("wait for a value, or for one above or below", "invalid_value", "value")
        if value is not None:
            above = below = value
        lowest = -math.inf if above is None else _arguments.number("above", above)
        highest = math.inf if below is None else _arguments.number("below", below)
        return self._link.session.wait_for_signal(self._arm, _arguments.text("name", name), lowest, highest,
                                                  limit("timeout", timeout))

    def __repr__(self) -> str:
        return f"<hecaton.Signals of arm {self._arm}>"


class Arm:
    """A handle to one arm."""

    __slots__ = ("_link", "_name", "_tool", "_io")

    def __init__(self, link: _Link, name: str) -> None:
        self._link = link
        self._name = name
        self._tool = Tool(link, name)
        self._io = Signals(link, name)

    @property
    def name(self) -> str:
        """Name in the cell file."""
        return self._name

    def go_to(self, target: Target, *, time_limit: float | None = None, free_rotation: str = "none",
              position_tolerance: float = 1e-3, orientation_tolerance: float = 8.72665e-3) -> Goal:
        """Sends a goal and returns at once. It replaces the present goal of the arm, also that of another client.

        `target` is the name of a pose of the cell file, joint positions from base to tip [rad | m], or a Pose of the
        tool frame in W. The planner ends the goal after `time_limit` [s]; None, 0: no limit. For a Pose:
        `free_rotation` is none, roll, pitch, yaw or all; tolerances in [m] and [rad].
        """
        native = self._link.session.go_to(self._name, target, limit("time_limit", time_limit),
                                          _arguments.word("free_rotation", free_rotation, _hecaton.FREE_ROTATIONS),
                                          _arguments.finite_number("position_tolerance", position_tolerance),
                                          _arguments.finite_number("orientation_tolerance", orientation_tolerance))
        return Goal(self._link, native, self._name)

    def follow(self, times: Numbers, positions: Rows, velocities: Rows | None = None, accelerations: Rows | None = None,
               *, path_tolerance: float | Numbers | None = None, time_limit: float | None = None) -> Goal:
        """Sends a goal with a trajectory, as go_to(). The arm slows down, waits and returns where something is near.

        `times` [s] has the shape (N,) and grows; `positions` [rad | m], `velocities` and `accelerations` have the shape
        (N, joints). The first point is at most 0.1 rad or m from the arm, unless its time is above 0; the last one is at
        rest. PlanAnswer.trajectory() has such arrays. `path_tolerance` [rad | m] is that of each joint, or one for all;
        0: none. The arm goes around what blocks it within the tolerance; None: wherever it can. The goal ends
        ('cancelled', cause 'path_tolerance') when something pushes the arm out of the tolerance.
        Progress.trajectory_time says how far it has come.
        """
        rows = _arguments.rows("positions", positions)
        count, joints = rows.shape

        def same(key: str, values: Rows | None) -> _arguments.Vector | None:
            return None if values is None else _arguments.rows(key, values, rows.shape)

        if path_tolerance is not None:
            path_tolerance = _arguments.tolerances("path_tolerance", path_tolerance, joints)
        native = self._link.session.follow(self._name, _arguments.times("times", times, count), rows,
                                           same("velocities", velocities), same("accelerations", accelerations),
                                           path_tolerance, limit("time_limit", time_limit))
        return Goal(self._link, native, self._name)

    @property
    def tool(self) -> Tool:
        """Its gripper."""
        return self._tool

    @property
    def io(self) -> Signals:
        """Inputs and outputs of its device."""
        return self._io

    def posture(self, joints: Mapping[str, float], *, timeout: float | None = ANSWER_LIMIT) -> None:
        """Tells all planners where joints outside the chain are, by name [rad | m]. Nothing moves."""
        if not isinstance(joints, Mapping):
            _arguments.refuse("joints", joints, 'a dict of positions by joint, such as {"finger": 0.01}')
        for joint, position in joints.items():
            self._link.session.place_joint(self._name, _arguments.text("a name in joints", joint),
                                           _arguments.number(f"joints[{joint!r}]", position), limit("timeout", timeout))

    def state(self, timeout: float | None = ANSWER_LIMIT) -> ArmState:
        """The last measured state, with its age. The first call waits until a state has arrived."""
        return self._link.session.arm_state(self._name, limit("timeout", timeout))

    @property
    def goal(self) -> Progress | None:
        """Progress of the arm's newest goal, of any client, as far as received; Cell.status() updates it."""
        return self._link.session.newest_goal(self._name)

    def hold(self, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Brakes the arm and keeps its goal."""
        return self._link.session.hold([self._name], limit("timeout", timeout))

    def resume(self, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Ends hold and stop of this arm."""
        return self._link.session.resume([self._name], limit("timeout", timeout))

    def stop(self, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """As hold, latched until resume."""
        return self._link.session.stop([self._name], limit("timeout", timeout))

    def set_speed(self, speed: float, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Sets the speed override of this arm, as Cell.set_speed does."""
        return self._link.session.set_speed(_arguments.number("speed", speed), [self._name], limit("timeout", timeout))

    def __repr__(self) -> str:
        return f"<hecaton.Arm {self._name}>"


def _obstacle(name: str, shape: Shape, pose: Pose, motion: Motion | None) -> tuple[str, Shape, Pose, Motion]:
    moves = _hecaton.Static() if motion is None else _arguments.one_of("motion", motion, _arguments.MOTIONS)
    return (_arguments.text("name", name), _arguments.one_of("shape", shape, _arguments.SHAPES),
            _arguments.pose("pose", pose), moves)


class World:
    """The obstacles of a cell. An edit returns when it is made; a rejected edit raises Rejected and changes nothing."""

    __slots__ = ("_link",)

    def __init__(self, link: _Link) -> None:
        self._link = link

    def add(self, name: str, shape: Shape, pose: Pose, motion: Motion | None = None, *,
            timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Adds an obstacle. `name` must be unique; `pose` is that of its frame in W; without `motion` it stays."""
        return self._link.session.add(*_obstacle(name, shape, pose, motion), limit("timeout", timeout))

    def replace(self, name: str, shape: Shape, pose: Pose, motion: Motion | None = None, *,
                timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """As add(), in the place of the obstacle with this name, if there is one. Arms see either shape, never none."""
        return self._link.session.replace(*_obstacle(name, shape, pose, motion), limit("timeout", timeout))

    def move(self, name: str, pose: Pose, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Moves an obstacle to `pose` in W and ends its scripted motion."""
        return self._link.session.move(_arguments.text("name", name), _arguments.pose("pose", pose),
                                       limit("timeout", timeout))

    def remove(self, name: str, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Removes an obstacle."""
        return self._link.session.remove(_arguments.text("name", name), limit("timeout", timeout))

    def attach(self, arm: str, obstacle: str, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Attaches an obstacle to the tool of an arm at its present pose, at most 0.1 m from the tool."""
        return self._link.session.attach(_arguments.text("arm", arm), _arguments.text("obstacle", obstacle),
                                         limit("timeout", timeout))

    def detach(self, arm: str, obstacle: str, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Detaches an obstacle at its present pose. Dynamic obstacles fall."""
        return self._link.session.detach(_arguments.text("arm", arm), _arguments.text("obstacle", obstacle),
                                         limit("timeout", timeout))

    def obstacles(self, timeout: float | None = ANSWER_LIMIT) -> list[ObstacleState]:
        """All obstacles, with their age. The first call waits until their states have arrived."""
        return self._link.session.obstacles(limit("timeout", timeout))

    def __repr__(self) -> str:
        return f"<hecaton.World of {Cell(self._link)!r}>"


class Cell:
    """A connection to a running cell; connect() makes it. Usable from any thread.

    As a context manager it closes itself at the end. Keep one connection for the whole life of a program.
    """

    __slots__ = ("_link", "_world")

    def __init__(self, link: _Link) -> None:
        self._link = link
        self._world = World(link)

    @property
    def world(self) -> World:
        """The obstacles."""
        return self._world

    def arm(self, name: str) -> Arm:
        """A handle to an arm. Raises InvalidArgument, with the names of all arms, when the cell has no such arm.

        Does not wait for a name of the cell file or of the last status. Any other name is checked by the status, which
        the supervisor must answer within ANSWER_LIMIT: else a name stays unchecked, unless connected with a cell file.
        """
        self._link.session.require_arm(_arguments.text("name", name), ANSWER_LIMIT)
        return Arm(self._link, name)

    def arms(self, timeout: float | None = ANSWER_LIMIT) -> list[Arm]:
        """All arms, in the order of the cell file. Requests the status from the supervisor."""
        return [Arm(self._link, status.name) for status in self.status(timeout).arms]

    def status(self, timeout: float | None = ANSWER_LIMIT) -> CellStatus:
        """Requests the status from the supervisor."""
        return self._link.session.status(limit("timeout", timeout))

    def hold(self, arms: Iterable[str] | None = None, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Brakes all arms, or those named, and keeps their goals. Returns when the order was carried out."""
        return self._link.session.hold(_names(arms), limit("timeout", timeout))

    def resume(self, arms: Iterable[str] | None = None, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """Ends hold and stop. Arms that were stopped by name or by their device must be resumed by name."""
        return self._link.session.resume(_names(arms), limit("timeout", timeout))

    def stop(self, arms: Iterable[str] | None = None, *, timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """As hold, latched until resume."""
        return self._link.session.stop(_names(arms), limit("timeout", timeout))

    def set_speed(self, speed: float, arms: Iterable[str] | None = None, *,
                  timeout: float | None = ANSWER_LIMIT) -> Receipt:
        """No joint moves faster than `speed`, 0.01 to 1, times its velocity limit. For the cell, or the arms named.

        The lower of the cell's override and the arm's own is in force. Goals under way continue, slower. The override
        lasts until the next order.
        """
        return self._link.session.set_speed(_arguments.number("speed", speed), _names(arms), limit("timeout", timeout))

    def save_recordings(self, *, timeout: float | None = ANSWER_LIMIT) -> list[SavedRecording]:
        """Orders all recorders of the cell to save what they keep, and the time after it that their `after_fault` says."""
        return self._link.session.save_recordings(limit("timeout", timeout))

    def faults(self) -> list[Fault]:
        """Faults received so far. The first call subscribes to faults; status() updates them. Does not wait."""
        return self._link.session.faults()

    def on_fault(self, callback: Callable[[Fault], object] | None) -> None:
        """Calls `callback` with each present fault, and with each that begins, changes or is cleared. None: no calls.

        It replaces the earlier callback, and runs in a thread of the connection, like that of Goal.on_progress.
        """
        if callback is not None:
            _arguments.require_function("callback", callback)
        self._link.events.on_fault(callback)

    def wait_all(self, goals: Iterable[Goal], timeout: float | None = None, *, check: bool = True) -> list[Outcome]:
        """Waits until all goals have ended, for at most `timeout` [s]. Outcomes in the same order; `check` as in wait."""
        seconds = limit("timeout", timeout)
        end = None if seconds is None else time.monotonic() + seconds
        pending = list(goals)
        outcomes = [goal.wait(None if end is None else end - time.monotonic(), check=False) for goal in pending]
        return [goal._checked(outcome, check) for goal, outcome in zip(pending, outcomes)]

    def close(self) -> None:
        """Closes the connection. Goals continue; waits of other threads raise Closed. Waits until a planner has
        answered each goal, for at most 2 s."""
        self._link.close()

    def __enter__(self) -> Cell:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        try:
            arms = ", ".join(self._link.session.arms)
        except Error:
            return "<hecaton.Cell (closed)>"
        return f"<hecaton.Cell with arms {arms}>" if arms else "<hecaton.Cell>"


def connect(cell_file: str | os.PathLike[str] | None = None, *, domain: int | None = None,
            timeout: float | None = ANSWER_LIMIT) -> Cell:
    """Connects to the running cell of a cell file, or to the only one in a DDS domain.

    `domain`: None: the environment variable HECATON_DOMAIN, else the cell file's domain, else 42. Returns when the
    supervisor or the world service is found, and raises Unreachable when none is within `timeout` [s].
    """
    path = None if cell_file is None else os.fspath(cell_file)
    number = None if domain is None else _arguments.whole("domain", domain, 0, _hecaton.HIGHEST_DOMAIN)
    return Cell(_Link(_hecaton.Session.connect(path, number, limit("timeout", timeout))))


def _names(arms: Iterable[str] | None) -> list[str]:
    return [] if arms is None else _arguments.texts("arms", arms)


class _Callback:
    def __init__(self, callback: Callable[[Progress], object]) -> None:
        self._callback = callback

    def progress(self, progress: Progress) -> None:
        self._callback(progress)

    def closed(self) -> None:
        pass


class _Updates:
    """Progress for an iterator of another thread."""

    def __init__(self) -> None:
        self.queue: queue.SimpleQueue[Progress | None] = queue.SimpleQueue()

    def progress(self, progress: Progress) -> None:
        self.queue.put(progress)

    def closed(self) -> None:
        self.queue.put(None)


class _InLoop:
    """Calls functions in the thread of an event loop."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop

    def _soon(self, function: Callable[..., None], *arguments: object) -> None:
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:
            pass  # the loop is closed: its tasks have ended


class _AsyncUpdates(_InLoop):
    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(loop)
        self.queue: asyncio.Queue[Progress | None] = asyncio.Queue()

    def progress(self, progress: Progress) -> None:
        self._soon(self.queue.put_nowait, progress)

    def closed(self) -> None:
        self._soon(self.queue.put_nowait, None)


class _Ended(_InLoop):
    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(loop)
        self.future: asyncio.Future[None] = loop.create_future()

    def progress(self, progress: Progress) -> None:
        if progress.ended:
            self._soon(self._set)

    def closed(self) -> None:
        self._soon(self._set)

    def _set(self) -> None:
        if not self.future.done():
            self.future.set_result(None)
