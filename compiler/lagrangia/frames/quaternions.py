"""The attitude of a frame as a unit quaternion, real part first: the product of those of the turns on the way to it.

Each turn has its half angle, and so the quaternion goes on continuously when a hinge turns through full turns.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from lagrangia.algebra.duals import Algebra, Scalar, minus, plus, times
from lagrangia.base import attitude_values
from lagrangia.frames.spatial import unit_axis
from lagrangia.language.frame_steps import Step

Quaternion = tuple[Scalar, ...]  # (4,)
NOT_TURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)


def quaternion_along(steps: Iterable[Step], value: Callable[..., Any], level: int, algebra: Algebra,
                     attitude: Callable[[Step, int], Quaternion | None], first: Quaternion = NOT_TURNED) -> Quaternion:
    """Of what lies behind steps from where it is the first one; `value`: of an expression at a level; `attitude`: of a turn by
    one, at a level."""
    found = first
    for step in (step for step in steps if step.kind == "turn"):
        if (turned := attitude(step, level)) is not None:
            found = quaternion_product(found, conjugate(turned) if step.is_inverse else turned)
            continue
        half = value(step.amount, level) * (-0.5 if step.is_inverse else 0.5)
        axis = unit_axis(step, value(step.axis) if step.axis is not None else None, algebra)
        sine = algebra.call("sin", half)
        found = quaternion_product(found, (algebra.call("cos", half), *(times(x, sine) for x in axis)))
    return found


def conjugate(q: Sequence[Scalar]) -> Quaternion:
    """Of the turn back."""
    return q[0], *(minus(0.0, x) for x in q[1:])


def quaternion_product(a: Sequence[Scalar], b: Sequence[Scalar]) -> Quaternion:
    """As attitude_values.py has it, of scalars: what is the number 0 costs nothing."""
    return attitude_values.quaternion_product(a, b, times, plus, minus)
