"""hinge_angle(a, b): the angle of b against a as the hinges between them turn, whose axes are parallel; in the plane it is the
difference of the two frames' angles. In space it is what springs of torsion, dampers, stops and motors act on that are given the
two sides of a hinge: each pair of frames has a variable that is bound to the angle of the hinge, or to the sum of several.
"""

import math
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Protocol

from lagrangia.base.diagnostics import LagError, Report, Span, fail
from lagrangia.language.classes import ClassTable
from lagrangia.language.flat import Frame, FrameEquation, Variable
from lagrangia.language.folding import fold, numbers_of
from lagrangia.language.frame_steps import Step, between
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, Ref, Time, Unary

HINGE_ANGLE = "hinge_angle"
_PARALLEL = 1e-12  # sine of the angle between axes that are told as parallel
_Vector = tuple[float, float, float]
_Z: _Vector = (0.0, 0.0, 1.0)
_MOVING = frozenset({"coordinate", "input", "held", "delayed"})
_DECIDES = "part of an axis that decides how the angles of several hinges add up"  # of parameters, why they stay
_INSTEAD = "give it the two sides of a hinge, as a = hinge.a, b = hinge.b; or bind the angle, as twist = hinge.phi, or its rate"
_OF_BALLS = "hold it by a SphericalSpring or a Bushing, or by torques about its axes: work {Mx, My, Mz} on b.attitude"


def frames_of(call: Call[Flat]) -> tuple[FrameRef, FrameRef]:
    """The two frames that a call names. Raises LagError L0221."""
    for frame in call.arguments:
        if not isinstance(frame, FrameRef) or frame.attribute:
            fail("L0221", f"{HINGE_ANGLE} needs two frames, as bar.a and bar.b", frame.span)
    a, b = (frame for frame in call.arguments if isinstance(frame, FrameRef))
    return a, b


def name_of(a: str, b: str) -> str:
    """Of the variable that stands for the angle in space."""
    return f"{HINGE_ANGLE}({a}, {b})"


def frames_behind(name: str) -> list[str]:
    """The frames whose angle such a variable is; none of other variables."""
    return name[len(HINGE_ANGLE) + 1 : -1].split(", ") if name.startswith(f"{HINGE_ANGLE}(") else []


class Names(Protocol):
    """What values mean (names.py)."""

    turned: dict[str, Call[Flat]]


class Flattening(Protocol):
    """What flattening.py has collected."""

    report: Report
    table: ClassTable
    frames: dict[str, Frame]
    frame_equations: list[FrameEquation]
    variables: dict[str, Variable]

    @property
    def names(self) -> Names:
        """What values mean."""


def hinge_angles(flat: Flattening) -> dict[str, Variable]:
    """The variables that stand for the calls, and parameters that no run can change, for they decided how. Reports L0221 where
    no hinges about parallel axes join the frames, of what the library calls where its component is."""
    found: dict[str, Variable] = {}
    calls = flat.names.turned
    ways = Ways(flat.frame_equations, flat.variables) if calls else None
    for name, call in calls.items():
        assert ways is not None
        try:
            a, b = frames_of(call)
            place = flat.frames[a.name].span if call.span.source in flat.table.library_sources else call.span
            angle = ways.angle(a.name, b.name, place)
        except LagError as error:
            flat.report.add(error.diagnostics)
            continue
        found[name] = Variable(name, "variable", (), "rad", "deg", angle, None, False, None, None, False, "", call.span)
    for name in ways.deciding if ways is not None else ():
        variable = flat.variables[name]
        if variable.kind == "parameter" and not variable.locked:
            found[name] = replace(variable, locked=_DECIDES)
    return found


class Ways:
    """What leads from frame to frame."""

    def __init__(self, joints: Iterable[FrameEquation], variables: Mapping[str, Variable]) -> None:
        self.variables, self.bindings = variables, {name: v.binding for name, v in variables.items()}
        self.deciding: dict[str, None] = {}  # what axes depend on by which angles of several hinges were added up
        self.ahead: dict[str, list[tuple[str, tuple[Step, ...]]]] = {}
        for joint in joints:
            parent, child, steps = between(joint.left, joint.right)
            self.ahead.setdefault(parent, []).append((child, steps))
            self.ahead.setdefault(child, []).append((parent, tuple(step.inverse() for step in reversed(steps))))

    def angle(self, a: str, b: str, span: Span) -> Flat:
        """Of b against a: about the axis of the first hinge on the way. Raises LagError L0221."""
        told, way = f"between '{a}' and '{b}'", self._way(a, b)
        turns = [step for step in way or () if step.kind == "turn"]
        hinges = [k for k, step in enumerate(turns) if self._moves(step.amount)]
        if not hinges:
            why = "they are not joined" if way is None else "nothing turns one against the other"
            fail("L0221", f"no hinge is {told}: {why}", span, _INSTEAD)
        if any(self._is_attitude(turns[k]) for k in hinges):
            fail("L0221", f"a ball joint is {told}: no one angle says how it is turned", span, _OF_BALLS)
        if len(turns) > 1:
            axes = leaves([step.axis for step in turns if step.axis is not None], self.bindings)
            self.deciding |= dict.fromkeys(leaf.name for leaf in axes if isinstance(leaf, Ref) and leaf.name in self.variables)
        axis, total = self._axis(turns[hinges[0]]), None
        sides = [1 if k == hinges[0] else _side(axis, self._axis(step)) for k, step in enumerate(turns)]
        if 0 in sides[hinges[0] : hinges[-1] + 1]:
            fail("L0221", f"the axes of the hinges {told} are not plainly parallel: no one angle says how they turn", span,
                 _INSTEAD)
        first = 1 + max((k for k in range(hinges[0]) if sides[k] == 0), default=-1)  # beyond a fixed turn about another axis
        last = min((k for k in range(hinges[-1], len(sides)) if sides[k] == 0), default=len(sides))  # parallel ones are not so
        for step, side in list(zip(turns, sides, strict=True))[first:last]:
            total = _plus(total, step.amount, -side if step.is_inverse else side)
        assert total is not None
        return total

    def hinge(self, a: str, b: str) -> tuple[tuple[Step, ...], Step] | None:
        """The first hinge on the way from a to b, and the turns from a's axes to those in which its axis is told; None without
        one, and where it is a ball joint."""
        turns = [step for step in self._way(a, b) or () if step.kind == "turn"]
        at = next((k for k, step in enumerate(turns) if self._moves(step.amount)), None)
        return None if at is None or self._is_attitude(turns[at]) else (tuple(turns[:at]), turns[at])

    def _way(self, a: str, b: str) -> tuple[Step, ...] | None:
        """The steps from a to b that move the fewest angles; None where nothing leads there."""
        best: dict[str, tuple[int, tuple[Step, ...]]] = {a: (0, ())}
        queue = deque([a])
        while queue:
            here = queue.popleft()
            turned, way = best[here]
            for there, steps in self.ahead.get(here, ()):
                cost = turned + sum(step.kind == "turn" and self._moves(step.amount) for step in steps)
                if there not in best or cost < best[there][0]:
                    best[there] = cost, way + steps
                    queue.append(there)
        return best[b][1] if b in best else None

    def _moves(self, amount: Flat) -> bool:
        return any(isinstance(leaf, Time) or (isinstance(leaf, Ref) and leaf.name in self.variables
                                              and self.variables[leaf.name].kind in _MOVING)
                   for leaf in leaves([amount], self.bindings))

    def _is_attitude(self, step: Step) -> bool:
        amount = step.amount
        return isinstance(amount, Ref) and amount.name in self.variables and self.variables[amount.name].is_attitude

    def _axis(self, step: Step) -> _Vector | None:
        """Where it points, of any length; None where that is no matter of numbers."""
        if step.axis is None:
            return None if self._is_attitude(step) else _Z
        node: Flat | None = step.axis
        while isinstance(node, Ref) and not node.index and node.name in self.bindings:
            node = self.bindings[node.name]
        found = numbers_of(node, (3,), self._known) if node is not None else []
        x, y, z = found if len(found) == 3 else (None, None, None)
        return None if x is None or y is None or z is None else (x, y, z)

    def _known(self, node: Ref) -> float | None:
        """The value of what is bound to numbers."""
        binding = self.bindings.get(node.name)
        if binding is None:
            return None
        found = binding.items[node.index[0] - 1] if len(node.index) == 1 and isinstance(binding, Array) else binding
        return None if isinstance(found, Array) else fold(found, self._known)


def _side(axis: _Vector | None, other: _Vector | None) -> int:
    """1 where an axis points to where another one does, -1 where it points back, 0 where they are not parallel."""
    if axis is None or other is None:
        return 0
    size, along = math.hypot(*axis) * math.hypot(*other), sum(x * y for x, y in zip(axis, other, strict=True))
    pairs = ((1, 2), (2, 0), (0, 1))
    across = math.hypot(*(axis[i] * other[j] - axis[j] * other[i] for i, j in pairs))
    return 0 if across > _PARALLEL * size or size == 0 else 1 if along > 0 else -1


def _plus(total: Flat | None, amount: Flat, side: int) -> Flat:
    if total is None:
        return amount if side > 0 else Unary("-", amount, amount.span)
    return Binary("+" if side > 0 else "-", total, amount, amount.span)
