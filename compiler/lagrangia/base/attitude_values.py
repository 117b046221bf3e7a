"""Attitudes as they are given to a run: angles("zxz", 10[deg], 20[deg], 0), axis_angle({1, 0, 0}, 30[deg]),
quaternion(1, 0, 0, 0), or four numbers. The run takes them as s = 4 tan(angle/4) times the axis,
counted from no turn (runtime/state/attitudes.c)."""

import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from typing import Any

from lagrangia.base.cutting import cut_list
from lagrangia.base.diagnostics import LagError
from lagrangia.base.spelling import read_number

SEQUENCES = tuple(a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if b not in (a, c))
# Of a product of quaternions, part by part: which parts of the first and of the second one, and with which sign.
PRODUCT = (((0, 0, 1), (1, 1, -1), (2, 2, -1), (3, 3, -1)), ((0, 1, 1), (1, 0, 1), (2, 3, 1), (3, 2, -1)),
           ((0, 2, 1), (2, 0, 1), (3, 1, 1), (1, 3, -1)), ((0, 3, 1), (3, 0, 1), (1, 2, 1), (2, 1, -1)))
HINT = 'write angles("zxz", 10[deg], 20[deg], 0), axis_angle({1, 0, 0}, 30[deg]) or quaternion(1, 0, 0, 0)'
_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*", re.DOTALL)
_ANGLES = {"rad": 1.0, "deg": math.pi / 180, "°": math.pi / 180, "rev": 2 * math.pi}
Quaternion = Sequence[float]
Operation = Callable[[Any, Any], Any]


def read_attitude(given: Any) -> tuple[float, ...]:
    """A unit quaternion (4,), real part first and not negative. Raises ValueError for what is no attitude."""
    if isinstance(given, str):
        found = _read(given)
    elif isinstance(given, Iterable) and not isinstance(given, Mapping):
        found = [float(x) for x in given]
    else:
        raise ValueError(f"an attitude is needed, not {given!r}"[:200])
    if len(found) != 4:
        raise ValueError(f"a quaternion has four parts, the real one first, not {len(found)}")
    length = math.hypot(*found)
    if not (math.isfinite(length) and length > 0):
        raise ValueError("a quaternion of a finite length that is not 0 is needed")
    length = math.copysign(length, found[0] or 1.0)
    return tuple(x / length + 0.0 for x in found)


def turn_of(quaternion: Quaternion) -> tuple[float, float, float]:
    """s of a unit quaternion whose real part is not negative."""
    real, x, y, z = quaternion
    return 4 * x / (1 + real), 4 * y / (1 + real), 4 * z / (1 + real)


def quaternion_of(turn: Sequence[float]) -> tuple[float, ...]:
    """The unit quaternion of s, the inverse of turn_of; NaN for a turn that is not given."""
    square = sum(x * x for x in turn) / 16
    return (1 - square) / (1 + square), *(x / 2 / (1 + square) for x in turn)


def _read(text: str) -> Quaternion:
    call = _CALL.fullmatch(text)
    if call is None or call[1] not in _READERS:
        raise ValueError(f"'{text}' is no attitude: {HINT}")
    try:
        arguments = cut_list(call[2])
    except LagError as error:
        raise ValueError(error.diagnostics[0].message) from None
    return _READERS[call[1]](arguments)


def _angles(arguments: Sequence[str]) -> Quaternion:
    if len(arguments) != 4:
        raise ValueError("angles takes three axes and three angles: angles(\"zxz\", 10[deg], 20[deg], 0)")
    sequence = arguments[0].strip("\"'")
    if sequence not in SEQUENCES:
        raise ValueError(f"'{sequence}' are no three axes of which neighbours differ: {', '.join(SEQUENCES)}")
    turns: list[Quaternion] = []
    for axis, angle in zip(sequence, arguments[1:], strict=True):
        half = _angle(angle) / 2
        turns.append([math.cos(half), *(math.sin(half) if axis == other else 0.0 for other in "xyz")])
    return reduce(quaternion_product, turns)


def _axis_angle(arguments: Sequence[str]) -> Quaternion:
    axis = arguments[0].strip() if len(arguments) == 2 else ""
    parts = axis[1:-1].split(",") if axis.startswith("{") and axis.endswith("}") else []
    if len(parts) != 3:
        raise ValueError("axis_angle takes an axis and an angle: axis_angle({1, 0, 0}, 30[deg])")
    along = [_number(part) for part in parts]
    length, half = math.hypot(*along), _angle(arguments[1]) / 2
    if length == 0:
        raise ValueError("an axis of the length 0 has no direction")
    return [math.cos(half), *(math.sin(half) * x / length for x in along)]


def _quaternion(arguments: Sequence[str]) -> Quaternion:
    parts = arguments[0].strip("{} ").split(",") if len(arguments) == 1 else arguments
    return [_number(part) for part in parts]


def _number(text: str) -> float:
    try:
        return read_number(text)
    except ValueError:
        raise ValueError(f"'{text.strip()}' is no number") from None


def _angle(text: str) -> float:
    number, bracket, unit = text.strip().partition("[")
    factor = _ANGLES.get(unit.removesuffix("]")) if bracket else 1.0
    if factor is None or (bracket and not unit.endswith("]")):
        raise ValueError(f"'{text.strip()}' is no angle: 0.5, or {', '.join(f'0.5[{name}]' for name in _ANGLES)}")
    return _number(number) * factor


_READERS = {"angles": _angles, "axis_angle": _axis_angle, "quaternion": _quaternion}


def quaternion_product(a: Any, b: Any, times: Operation = operator.mul, plus: Operation = operator.add,
                       minus: Operation = operator.sub) -> tuple[Any, ...]:
    """Of the turn b and then the turn a, in the axes of the world; of a, and then b in the axes of a."""
    found = []
    for terms in PRODUCT:
        total: Any = 0.0
        for i, j, sign in terms:
            total = (plus if sign > 0 else minus)(total, times(a[i], b[j]))
        found.append(total)
    return tuple(found)
