"""Figures of a scene in space -> what they need of each moment, as rows of one function of the motion."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np

from lagrangia.compile.functions import observer_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.values import root_of
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.dimensions import dimension_of_value
from lagrangia.language.figures import CHOICES, WORDS
from lagrangia.language.flat import Figure, FlatModel, places_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.hinge_angles import Ways
from lagrangia.language.tree import Call, Flat, FrameRef, String
from lagrangia.language.units import dimension

HINGE = "hinge"  # among the options of a spring or damper of torsion: its hinge's axis, in the world's axes
_TORSION = (dimension(kg=1, m=2, s=-2), dimension(kg=1, m=2, s=-1))  # of stiffnesses and torques, of damping


@dataclass(frozen=True)
class Asked:
    """The rows of a figure: `places` an origin and a matrix by its rows each."""

    figure: Figure
    places: tuple[slice, ...]
    numbers: tuple[slice, ...]
    options: dict[str, slice]

    @property
    def frames(self) -> tuple[str, ...]:
        """On which its places hang, "" for a position."""
        return tuple(root_of(place) for place in places_in(self.figure))


@dataclass(frozen=True)
class Rows:
    """`function`: t, q, v, u, p -> (rows, 1). `frames` are the places of all frames, `up` points against gravity."""

    asked: tuple[Asked, ...]
    frames: dict[str, slice]
    up: slice
    function: ca.Function


def build_rows(c: Compilation, figures: Sequence[Figure], for_tape: bool = False) -> Rows:
    """Of figures whose places are all there. Raises LagError."""
    rows, lost = _Gathered(c.kinematics, Ways(c.flat.frame_equations, c.flat.variables)), set(c.graph.unused_frames)
    shown = [figure for figure in figures if not any(root_of(place) in lost for place in places_in(figure))]
    asked = tuple(_ask(rows, figure) for figure in shown)
    frames = {name: rows.place(FrameRef(name, "", (), c.flat.frames[name].span)) for name in c.flat.frames if name not in lost}
    up = rows.add(_up(c.kinematics))
    return Rows(asked, frames, up, observer_of(c.kinematics, c.motion, c.constraints,
                                               ca.densify(ca.vertcat(*rows.scalars)), for_tape))


@dataclass
class _Gathered:
    """Scalars, in the order in which they are asked for."""

    kinematics: Kinematics
    ways: Ways
    scalars: list[ca.SX] = field(default_factory=list)

    def add(self, values: Sequence[ca.SX]) -> slice:
        self.scalars += [ca.SX(x) for x in values]
        return slice(len(self.scalars) - len(values), len(self.scalars))

    def value(self, node: Flat) -> slice:
        return self.add(scalars_of(self.kinematics.evaluator.value(node)))

    def place(self, node: Flat) -> slice:
        """Of a frame, or of a position, whose axes are the world's."""
        pose = self._pose(node)
        if pose is None:
            return self.add([*scalars_of(self.kinematics.evaluator.value(node)), *np.eye(3).ravel()])
        origin, axes = (self.kinematics.geometry.attribute_of(pose, name) for name in ("r", "R"))
        return self.add([*origin, *(x for row in axes for x in row)])

    def hinge(self, places: Sequence[Flat]) -> slice | None:
        """The axis, in the world's axes, about which the second of two frames is turned against the first; None without one."""
        names = [node.name for node in places if isinstance(node, FrameRef) and not node.attribute]
        found = self.ways.hinge(*names) if len(names) == 2 else None
        if found is None:
            return None
        before, turn = found
        pose = self.kinematics.pose(names[0], 0)
        for step in before:
            pose = self.kinematics.step(step, pose, 0)
        axis = [0.0, 0.0, 1.0] if turn.axis is None else scalars_of(self.kinematics.evaluator.value(turn.axis))
        axes = self.kinematics.geometry.attribute_of(pose, "R")
        return self.add([sum((x * along for x, along in zip(row, axis, strict=True)), ca.SX(0)) for row in axes])

    def _pose(self, node: Flat) -> Any:
        if isinstance(node, FrameRef) and not node.attribute:
            return self.kinematics.pose(node.name, 0)
        if not isinstance(node, Call) or node.function not in ("shift", "turn"):
            return None
        base, amount, *axis = node.arguments
        step = Step(node.function, amount, False, axis[0] if axis else None)
        return self.kinematics.step(step, self._pose(base), 0)


def _ask(rows: _Gathered, figure: Figure) -> Asked:
    takes = WORDS[figure.word].takes
    kinds = [takes[min(k, len(takes) - 1)] for k in range(len(figure.arguments))]
    numbers = [rows.value(node) for node, kind in zip(figure.arguments, kinds, strict=True) if kind not in ("place", "text")]
    options = {name: rows.value(node) for name, node in figure.options.items() if name not in ("label", "of", *CHOICES)}
    places = places_in(figure)
    axis = rows.hinge(places) if _is_torsion(rows.kinematics.graph.model, figure) else None
    options |= {HINGE: axis} if axis is not None else {}
    return Asked(figure, tuple(rows.place(place) for place in places), tuple(numbers), options)


def _is_torsion(model: FlatModel, figure: Figure) -> bool:
    """Whether it is a spring or damper whose label is a stiffness, damping or torque of turning."""
    label = figure.options.get("label") if figure.word in ("zigzag", "dashpot") else None
    return label is not None and not isinstance(label, String) and dimension_of_value(model, label) in _TORSION


def places_in(figure: Figure) -> list[Flat]:
    """The expressions of its places."""
    takes = WORDS[figure.word].takes
    return [place for k, node in enumerate(figure.arguments) if takes[min(k, len(takes) - 1)] == "place"
            for place in places_of(node)]


def _up(kinematics: Kinematics) -> Sequence[Any]:
    """Against gravity, where there is any."""
    return [-x for x in scalars_of(kinematics.symbols.values.get("world.gravity", (0.0, 0.0, 0.0)))]
