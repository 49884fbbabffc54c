"""Hecaton for Python: drive a running cell of robot arms, and plan without one.

    import hecaton

    with hecaton.connect("deploy/cells/three_puma.yaml") as cell:
        cell.world.add("crate", hecaton.Box(0.2, 0.2, 0.2), hecaton.Pose.xyz(1.5, 1.5, 0.1))
        cell.arm("north").go_to("ready").wait(60)

Units are SI: metres, radians, seconds, kilograms. Poses are in the frame W of the cell. Joint vectors are NumPy arrays
from base to tip. Failures are exceptions of hecaton.errors, with `kind` and `subject` for programs.
"""

try:
    import numpy as _numpy
except ImportError as _error:
    import sys as _sys
    raise ImportError(f"hecaton needs NumPy, which {_sys.executable} does not have; install python3-numpy and run the program "
                      "with /usr/bin/python3", name="numpy") from _error
try:
    from . import _hecaton as _module
except ImportError as _error:
    import pathlib as _pathlib

    from ._native import sentence as _sentence
    _reason = _sentence(_pathlib.Path(__file__).parent)
    if _reason is None:
        raise
    raise ImportError(_reason, name="hecaton._hecaton") from _error

from ._hecaton import (
    ARM_MODES, CAUSE_KINDS, CELL_MODES, FREE_ROTATIONS, GOAL_STATES, NODE_KINDS, NODE_STATES, SEVERITIES, ArmState,
    ArmStatus, Binding, Box, Capsule, Cause, CellStatus, Circle, ContactReport, ConvexHull, Conveyor, Cylinder, Dynamic,
    Fault, NearestPose, NodeStatus, ObstacleState, Outcome, PlanAnswer, Points, Pose, Progress, Receipt, SavedRecording, Signal,
    Sine, Sphere, Static, ToolError, ToolState)
from .errors import Closed, Error, GoalFailed, InvalidArgument, NoAnswer, Rejected, Unreachable, WaitTimeout
from .live import ANSWER_LIMIT, GRIPPER_LIMIT, Arm, Cell, Goal, Signals, Tool, World, connect
from .offline import ArmModel, CellFile, Finding, Limits, MissedTask, Separation, SimulationReport, load

__version__: str = _module.VERSION

__all__ = [
    "ANSWER_LIMIT", "ARM_MODES", "Arm", "ArmModel", "ArmState", "ArmStatus", "Binding", "Box", "CAUSE_KINDS",
    "CELL_MODES", "Capsule", "Cause", "Cell", "CellFile", "CellStatus", "Circle", "Closed", "ContactReport",
    "ConvexHull", "Conveyor", "Cylinder", "Dynamic", "Error", "FREE_ROTATIONS", "Fault", "Finding", "GOAL_STATES",
    "GRIPPER_LIMIT",
    "Goal", "GoalFailed", "InvalidArgument", "Limits", "MissedTask", "NODE_KINDS", "NODE_STATES", "NearestPose",
    "NoAnswer", "NodeStatus", "ObstacleState", "Outcome", "PlanAnswer", "Points", "Pose", "Progress", "Receipt", "Rejected",
    "SEVERITIES", "SavedRecording", "Separation", "Signal", "Signals", "SimulationReport", "Sine", "Sphere", "Static", "Tool", "ToolError",
    "ToolState", "Unreachable",
    "WaitTimeout", "World", "connect", "load"]
