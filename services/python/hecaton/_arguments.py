"""Types of arguments, and their checks. A wrong one raises InvalidArgument with its name, its value and what is allowed."""

from __future__ import annotations

import math
import operator
import reprlib
from typing import Any, Iterable, Mapping, NoReturn, Sequence, SupportsFloat, SupportsIndex, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from . import _hecaton
from .errors import InvalidArgument

Vector = NDArray[np.float64]
Joints = Union[str, Sequence[float], NDArray[Any]]
Target = Union[str, _hecaton.Pose, Sequence[float], NDArray[Any]]
Numbers = Union[Sequence[float], NDArray[Any]]
Rows = Union[Sequence[Sequence[float]], NDArray[Any]]
Shape = Union[_hecaton.Box, _hecaton.Sphere, _hecaton.Cylinder, _hecaton.Capsule, _hecaton.ConvexHull,
              _hecaton.Points]
Motion = Union[_hecaton.Static, _hecaton.Conveyor, _hecaton.Sine, _hecaton.Circle, _hecaton.Dynamic]

SHAPES = (_hecaton.Box, _hecaton.Sphere, _hecaton.Cylinder, _hecaton.Capsule, _hecaton.ConvexHull,
          _hecaton.Points)
MOTIONS = (_hecaton.Static, _hecaton.Conveyor, _hecaton.Sine, _hecaton.Circle, _hecaton.Dynamic)

T = TypeVar("T")


def refuse(key: str, value: object, must_be: str) -> NoReturn:
    raise InvalidArgument(f"{key} = {reprlib.repr(value)} must be {must_be}", "invalid_value", key)


def text(key: str, value: str) -> str:
    if not isinstance(value, str):
        refuse(key, value, "a str")
    return value


def texts(key: str, value: str | Iterable[str]) -> list[str]:
    """One name or several. An empty list would be an order for the whole cell, which its caller does not want."""
    if isinstance(value, str):
        return [value]
    if not isinstance(value, Iterable):
        refuse(key, value, "a list of names")
    names = [text(f"a name in {key}", name) for name in value]
    if not names:
        raise InvalidArgument(f"{key} is empty: name at least one arm, or omit it for the whole cell", "invalid_value", key)
    return names


def word(key: str, value: str, words: Sequence[str]) -> str:
    if value not in words:
        refuse(key, value, f"{', '.join(words[:-1])} or {words[-1]}")
    return value


def number(key: str, value: SupportsFloat, must_be: str = "a number") -> float:
    if not isinstance(value, (str, bytes)):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    refuse(key, value, must_be)


def finite_number(key: str, value: SupportsFloat) -> float:
    must_be = "a finite number"
    if not math.isfinite(number(key, value, must_be)):
        refuse(key, value, must_be)
    return float(value)


def positive(key: str, value: SupportsFloat, unit: str) -> float:
    """Infinite is allowed."""
    must_be = f"a number above 0 [{unit}]"
    if not number(key, value, must_be) > 0.0:
        refuse(key, value, must_be)
    return float(value)


def distance(key: str, value: SupportsFloat) -> float:
    must_be = "a finite number of at least 0 [m]"
    if not 0.0 <= number(key, value, must_be) < math.inf:
        refuse(key, value, must_be)
    return float(value)


def limit(key: str, value: SupportsFloat | None) -> float | None:
    """A time limit; None: no limit."""
    if value is None:
        return None
    must_be = "a number of seconds, or None for no limit"
    if math.isnan(number(key, value, must_be)):
        refuse(key, value, must_be)
    return float(value)


def whole(key: str, value: SupportsIndex, least: int, most: int) -> int:
    try:
        result = operator.index(value)
    except TypeError:
        result = least - 1
    if not least <= result <= most:
        refuse(key, value, f"a whole number from {least} to {most}")
    return result


def one_of(key: str, value: T, types: tuple[type, ...]) -> T:
    if not isinstance(value, types):
        names = [f"hecaton.{each.__name__}" for each in types]
        refuse(key, value, f"a {names[0]}" if len(names) == 1 else f"a {', '.join(names[:-1])} or {names[-1]}")
    return value


def pose(key: str, value: _hecaton.Pose) -> _hecaton.Pose:
    return one_of(key, value, (_hecaton.Pose,))


def require_function(key: str, value: object) -> None:
    if not callable(value):
        refuse(key, value, "a function")


def _numbers(value: object) -> Vector:
    """Real numbers only: NumPy also converts texts, truth values and complex numbers."""
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise TypeError
    numbers: Vector = np.asarray(array, dtype=np.float64)
    return numbers


def joints(key: str, value: Sequence[float] | NDArray[Any]) -> Vector:
    try:
        positions = _numbers(value)
    except (TypeError, ValueError):
        positions = np.empty((0, 0))
    if positions.ndim != 1:
        refuse(key, value, "the name of a pose, or a sequence of joint positions")
    return positions


def finite(key: str, value: object, must_be: str) -> Vector:
    """A copy as an array of finite numbers."""
    try:
        array = np.array(_numbers(value))
    except (TypeError, ValueError):
        refuse(key, value, must_be)
    for index in np.argwhere(~np.isfinite(array))[:1].tolist():
        where = key + "".join(f"[{i}]" for i in index)
        refuse(where, array[tuple(index)].item(), "a finite number")
    return array


def _require_shape(key: str, array: Vector, shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise InvalidArgument(f"{key} has the shape {array.shape}, but must have the shape {shape}", "invalid_value", key)


def rows(key: str, value: Rows, shape: tuple[int, ...] | None = None) -> Vector:
    """An array of two dimensions, a row for each point."""
    array = finite(key, value, "a row of numbers for each point")
    if shape is not None:
        _require_shape(key, array, shape)
    elif array.ndim != 2 or array.size == 0:
        raise InvalidArgument(f"{key} has the shape {array.shape}, but must have a row for each point and a column for "
                              "each joint", "invalid_value", key)
    return array


def times(key: str, value: Numbers, size: int) -> Vector:
    array = finite(key, value, "a number for each point [s]")
    _require_shape(key, array, (size,))
    if array[0] < 0.0:
        refuse(f"{key}[0]", array[0].item(), "0 or above [s]")
    for i in np.flatnonzero(np.diff(array) <= 0.0)[:1]:
        refuse(f"{key}[{i + 1}]", array[i + 1].item(), f"above {key}[{i}] = {array[i].item()} [s]")
    return array


def tolerances(key: str, value: float | Numbers, size: int) -> Vector:
    """One for each joint, or one for all of them."""
    array = finite(key, value, "a number, or one for each joint [rad | m]")
    if array.ndim == 0:
        array = np.full(size, array)
    _require_shape(key, array, (size,))
    for i in np.flatnonzero(array < 0.0)[:1]:
        refuse(f"{key}[{i}]", array[i].item(), "0 (none) or above [rad | m]")
    return array


def by_arm(key: str, value: Mapping[str, Joints]) -> Mapping[str, Joints]:
    if not isinstance(value, Mapping):
        refuse(key, value, 'a dict of joint positions by arm, such as {"north": "ready"}')
    return value
