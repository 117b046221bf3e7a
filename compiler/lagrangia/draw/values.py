"""Figures of the flat model -> their numbers at each moment, by one function of the motion."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import fail
from lagrangia.compile.functions import observer_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.frames import planar
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.geometry import Pose
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.planar import SIZE
from lagrangia.language.dimensions import dimension_of_value
from lagrangia.language.figures import CHOICES, WORDS
from lagrangia.language.flat import Figure, FlatModel, places_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.tree import Call, Flat, FrameRef, Number, String
from lagrangia.language.units import ONE, dimension

Vector = NDArray[np.float64]
_UNITS = {dimension(m=1): "length", dimension(kg=1, m=1, s=-2): "force", dimension(kg=1, m=2, s=-2): "torque"}


@dataclass(frozen=True)
class States:
    """Moments of a motion: t (1, T), q and v (n, T), u (n_u, T), p (n_p, 1), all in SI units."""

    t: Vector
    q: Vector
    v: Vector
    u: Vector
    p: Vector

    def picked(self, moments: Sequence[int]) -> "States":
        """Some of the moments."""
        chosen = list(moments)
        return States(self.t[:, chosen], self.q[:, chosen], self.v[:, chosen], self.u[:, chosen], self.p)


@dataclass(frozen=True)
class Item:
    """A figure that can be drawn: rows of `Numbers` of its places, its sizes and its options; `frames` its places hang on."""

    figure: Figure
    frames: tuple[str, ...]  # "" for a position
    places: tuple[int, ...]  # the first of SIZE rows each
    numbers: tuple[tuple[int, ...], ...]
    options: dict[str, tuple[int, ...]]
    choices: dict[str, str]
    measure: str = ""  # of an arrow: force, torque, length or direction

    @property
    def word(self) -> str:
        """What is drawn."""
        return self.figure.word


@dataclass(frozen=True)
class Numbers:
    """`values`: (rows, T). `frames`: rows of the places of frames, (SIZE,) each."""

    items: tuple[Item, ...]
    values: Vector
    frames: dict[str, int]

    def place(self, frame: str) -> Vector:
        """(SIZE, T): m, rad."""
        row = self.frames[frame]
        return self.values[row : row + SIZE]


@dataclass
class _Rows:
    """Scalars, in the order in which they are asked for."""

    kinematics: Kinematics
    scalars: list[ca.SX] = field(default_factory=list)

    def add(self, values: Sequence[ca.SX]) -> int:
        self.scalars += [ca.SX(x) for x in values]
        return len(self.scalars) - len(values)

    def value(self, node: Flat) -> tuple[int, ...]:
        found = scalars_of(self.kinematics.evaluator.value(node))
        first = self.add(found)
        return tuple(range(first, first + len(found)))

    def place(self, node: Flat) -> tuple[str, int]:
        if not _is_frame(node):
            x, y = scalars_of(self.kinematics.evaluator.value(node))
            return "", self.add([x, y, 0.0])
        return root_of(node), self.add(self._pose(node).place)

    def _pose(self, node: Flat) -> Pose:
        if isinstance(node, FrameRef):
            return self.kinematics.pose(node.name, 0)
        assert isinstance(node, Call)
        base, amount = node.arguments
        value = self.kinematics.evaluator.value(amount)
        return planar.step(self._pose(base), Step(node.function, amount), value, self.kinematics.algebra)


@dataclass(frozen=True)
class Drawn:
    """Figures as rows of one function of t, q, v, u, p, (rows, 1), and the frames they hang on with all that carries these."""

    items: tuple[Item, ...]
    frames: dict[str, int]
    function: ca.Function


def build_drawn(c: Compilation, figures: Sequence[Figure], for_tape: bool = False) -> Drawn:
    """Figures whose places are all there. Raises LagError."""
    rows = _Rows(c.kinematics)
    lost = set(c.graph.unused_frames)
    items = tuple(_item(c.flat, rows, figure, lost) for figure in figures)
    frames = {name: rows.add(c.kinematics.pose(name, 0).place) for name in c.flat.frames if name not in lost}
    return Drawn(items, frames, observer_of(c.kinematics, c.motion, c.constraints,
                                            ca.densify(ca.vertcat(*rows.scalars)), for_tape))


def evaluate_drawn(drawn: Drawn, states: States) -> Numbers:
    """Its rows at all moments. What acts late, which comes last in u, is in no row of results: nothing is known of it."""
    late = np.full((drawn.function.size1_in(3) - len(states.u), states.t.size), np.nan)
    given = np.vstack([states.u.reshape(-1, states.t.size), late])
    values = np.array(drawn.function(states.t, states.q, states.v, given, states.p), dtype=float)
    return Numbers(drawn.items, values.reshape(drawn.function.numel_out(0), -1), drawn.frames)


def evaluate_figures(c: Compilation, figures: Sequence[Figure], states: States) -> Numbers:
    """Both. Raises LagError."""
    return evaluate_drawn(build_drawn(c, figures), states)


def _item(model: FlatModel, rows: _Rows, figure: Figure, lost: set[str]) -> Item:
    takes = WORDS[figure.word].takes
    places: list[tuple[str, int]] = []
    numbers: list[tuple[int, ...]] = []
    is_lost = False
    for k, node in enumerate(figure.arguments):
        kind = takes[min(k, len(takes) - 1)]
        if kind == "place":
            for place in places_of(node):
                is_lost |= root_of(place) in lost
                places += [] if is_lost else [rows.place(place)]
        elif kind != "text":
            numbers.append(_sized(rows, node, 2 if kind == "vector" else 1))
    given = {name: node for name, node in figure.options.items() if name not in ("label", "of", *CHOICES)}
    options = {name: _sized(rows, node, 2 if name == "along" else 1) for name, node in given.items()}
    choices = {name: node.value for name, node in figure.options.items() if name in CHOICES and isinstance(node, String)}
    frames, starts = ((), ()) if is_lost else (tuple(name for name, _ in places), tuple(row for _, row in places))
    return Item(figure, frames, starts, tuple(numbers), options, choices, measure_of(model, figure))


def _sized(rows: _Rows, node: Flat, size: int) -> tuple[int, ...]:
    found = rows.value(node)
    if len(found) != size:
        fail("L0303", f"{'a vector of two components' if size == 2 else 'one number'} is needed here", node.span)
    return found


def measure_of(model: FlatModel, figure: Figure) -> str:
    """Of an arrow: force, torque, length or direction; of a curved one angle."""
    if figure.word not in ("arrow", "curved_arrow") or len(figure.arguments) < 2:
        return ""
    found = dimension_of_value(model, figure.arguments[1])
    plain = "angle" if figure.word == "curved_arrow" else "direction"
    if found is None or found == ONE:
        return plain
    return _UNITS.get(found, "other")


def _is_frame(node: Flat) -> bool:
    return (isinstance(node, FrameRef) and not node.attribute) or (isinstance(node, Call) and node.function in ("shift", "turn"))


def root_of(node: Flat) -> str:
    """The frame that a place hangs on; "" for a position."""
    if isinstance(node, FrameRef):
        return node.name if not node.attribute else ""
    if isinstance(node, Call) and node.function in ("shift", "turn"):
        return root_of(node.arguments[0])
    return ""


def number_of(node: Flat) -> float | None:
    """A number that is written as such."""
    return node.value if isinstance(node, Number) else None
