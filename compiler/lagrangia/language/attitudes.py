"""Attitudes as they are written: by angles about axes, by an axis and an angle, by a quaternion. All become unit quaternions of
four expressions, real part first."""

from collections.abc import Callable, Mapping, Sequence
from functools import reduce

from lagrangia.base.attitude_values import PRODUCT, SEQUENCES
from lagrangia.base.diagnostics import fail
from lagrangia.language.elements import Size, element, length
from lagrangia.language.tree import Array, Binary, Call, Flat, Number, String, Unary

ROTATION = "Rotation"  # the type of a coordinate that is an attitude
_Quaternion = Sequence[Flat | None]  # (4,); None is 0


def _angles(call: Call[Flat], size: Size) -> Flat:
    """angles("zxz", a, b, c): about the first axis, then about the second one as it has moved, then about the third."""
    sequence, *angles = call.arguments
    if not isinstance(sequence, String) or sequence.value not in SEQUENCES:
        fail("L0215", "the first argument of angles is three axes, of which neighbours differ", sequence.span,
             f"about axes that move with the body, one of {', '.join(SEQUENCES)}")
    turns = [_half_turn(call, "xyz".index(axis), angle) for axis, angle in zip(sequence.value, angles, strict=True)]
    return _told(call, reduce(lambda a, b: _product(call, a, b), turns))


def _axis_angle(call: Call[Flat], size: Size) -> Flat:
    """axis_angle({x, y, z}, angle), the axis of any length but 0."""
    axis, angle = call.arguments
    if length(axis, size) != 3:
        fail("L0303", "an axis has three components", axis.span, "write {x, y, z}")
    parts = [element(axis, k, size) for k in (1, 2, 3)]
    sine, norm = _of_half(call, "sin", angle), Call("norm", (Array(tuple(parts), axis.span),), (), axis.span)
    along = Binary("/", sine, norm, call.span)
    return _told(call, (_of_half(call, "cos", angle), *[Binary("*", x, along, call.span) for x in parts]))


def _quaternion(call: Call[Flat], size: Size) -> Flat:
    """quaternion(a, b, c, d), or of an array of four, real part first, of any length but 0."""
    parts: Sequence[Flat] = call.arguments
    if len(parts) == 1 and length(parts[0], size) == 4:
        parts = [element(parts[0], k, size) for k in range(1, 5)]
    if len(parts) != 4:
        fail("L0215", "a quaternion has four parts, the real one first", call.span, "write quaternion(a, b, c, d)")
    norm = Call("norm", (Array(tuple(parts), call.span),), (), call.span)
    return _told(call, tuple(Binary("/", x, norm, call.span) for x in parts))


def parts_of(name: str) -> tuple[str, ...]:
    """The names of the three coordinates that an attitude has."""
    return tuple(f"{name}.s[{k}]" for k in (1, 2, 3))


ATTITUDES: Mapping[str, tuple[tuple[int, ...] | None, Callable[[Call[Flat], Size], Flat]]] = {
    "angles": ((4,), _angles), "axis_angle": ((2,), _axis_angle), "quaternion": ((1, 4), _quaternion),
}


def _of_half(call: Call[Flat], function: str, angle: Flat) -> Flat:
    return Call(function, (Binary("/", angle, Number(2.0, "1", call.span), call.span),), (), call.span)


def _half_turn(call: Call[Flat], axis: int, angle: Flat) -> _Quaternion:
    sine = _of_half(call, "sin", angle)
    return (_of_half(call, "cos", angle), *[sine if k == axis else None for k in range(3)])


def _product(call: Call[Flat], a: _Quaternion, b: _Quaternion) -> _Quaternion:
    found: list[Flat | None] = []
    for parts in PRODUCT:
        total: Flat | None = None
        for i, j, sign in parts:
            left, right = a[i], b[j]
            if left is None or right is None:
                continue
            part: Flat = Binary("*", left, right, call.span)
            if total is None:
                total = part if sign > 0 else Unary("-", part, call.span)
            else:
                total = Binary("+" if sign > 0 else "-", total, part, call.span)
        found.append(total)
    return found


def _told(call: Call[Flat], parts: Sequence[Flat | None]) -> Flat:
    return Array(tuple(Number(0.0, None, call.span) if x is None else x for x in parts), call.span)
