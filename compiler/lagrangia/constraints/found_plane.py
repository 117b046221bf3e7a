"""Whether all of a scene in space moves in parallel planes: all turns are about parallel axes, and nothing shifts along them.

Loads, and gravity, may point anywhere: what they do across the plane does no work. It does press the joints: where reactions are
asked for, or felt by friction, the scene is run in space.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, sqrt

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar, dot, minus, times
from lagrangia.algebra.scalars import column, scalars_in
from lagrangia.base.diagnostics import LagError, Span
from lagrangia.constraints.changes import changes_of
from lagrangia.constraints.parameters import default_parameters
from lagrangia.frames import spatial
from lagrangia.frames.closure_frames import way_of_shift
from lagrangia.frames.edges import Closure
from lagrangia.frames.graph import build_graph
from lagrangia.frames.in_plane import along_normal
from lagrangia.frames.kinematics import Kinematics, build_kinematics
from lagrangia.frames.planes import NoPlane, Plane
from lagrangia.frames.spatial import Matrix, Vector, plain_matrix
from lagrangia.language.flat import FlatModel
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.frame_steps import Step
from lagrangia.language.mentions import leaves, nodes
from lagrangia.language.tree import Flat, FrameRef, Ref
from lagrangia.run.scene import ALL_REACTIONS

_TILTED = 1e-9  # of the cosine of an angle between planes that a loop joins
_NEGLIGIBLE = 1e-12  # of a part along the normal
_ROUNDING = 1e-14  # of numbers that are about 1
_UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def in_its_plane(kinematics: Kinematics, outputs: Sequence[str], is_general: bool, massless: tuple[str, ...] | None
                 ) -> Kinematics:
    """The kinematics of a scene in space, of the plane where it lies in one; its graph says why it lies in none. `outputs` are
    asked for; the others are as in build_kinematics."""
    plane = _find_plane(kinematics, outputs, is_general)
    if isinstance(plane, Plane):
        return build_kinematics(build_graph(kinematics.graph.model, plane), is_general, massless)
    return replace(kinematics, graph=replace(kinematics.graph, plane=plane))


def _find_plane(kinematics: Kinematics, outputs: Sequence[str], is_general: bool) -> Plane | NoPlane:
    found = _reads_reactions(kinematics.graph.model, outputs) or _without_hinges(kinematics)
    try:
        return found or _Look(kinematics, is_general).look()
    except LagError:  # which is told, with its place, where poses are made
        return NoPlane("something turns about no axis", None)
    except _NoNumber:
        return NoPlane("where an axis points follows from the motion", None)


class _NoNumber(Exception):
    """Of what parameters alone do not give, or no finite number."""


def _reads_reactions(model: FlatModel, outputs: Sequence[str]) -> NoPlane | None:
    """Reactions have parts across the plane."""
    asked = [name for name in outputs if name == ALL_REACTIONS or f".{REACTIONS[0]}" in name]
    if asked:
        return NoPlane("reactions are asked for, which have parts across any plane", None)
    bindings = (v.binding for v in model.variables.values() if v.binding is not None)
    stated = [x for e in (*model.constraints, *model.initial_equations) for x in (e.left, e.right)]
    stated += [e.value for e in model.energies] + [x for w in model.works for x in (w.force, w.position)]
    stated += [x for figure in model.figures for x in figure.expressions()]
    for node in nodes(*bindings, *stated, *model.looks()):
        if isinstance(node, FrameRef) and node.attribute in REACTIONS:
            return NoPlane(f"{node.span.text} is asked for, which has parts across any plane", node.span)
    return None


def _without_hinges(kinematics: Kinematics) -> NoPlane | None:
    graph = kinematics.graph
    for name, attitude in graph.attitudes.items():
        return NoPlane(f"the attitude '{name}' has no plane", attitude.span)
    for root in graph.roots:
        if not root.is_ground:
            return NoPlane(f"'{root.frame}' floats", graph.model.frames[root.frame].span)
    return None


class _Look:
    """A walk along the tree, and across what closes its loops. Of each frame there is what takes its axes to the world's, or to
    the plane's, where nothing that turns is turned."""

    def __init__(self, kinematics: Kinematics, is_general: bool) -> None:
        self.kinematics, self.is_general = kinematics, is_general
        p, values = default_parameters(kinematics)
        self.values = dict(zip((x.__hash__() for x in p.elements()), values.full().ravel(), strict=True))
        variables = [v for v in kinematics.graph.model.variables.values() if v.kind == "parameter"]
        self.names = dict(zip(self.values, (v.name for v in variables for _ in v.elements()), strict=True))
        self.used: set[str] = set()

    def look(self) -> Plane | NoPlane:
        """The plane of the first hinge, if all the others have the same."""
        first = self._first_turn()
        if first is None:
            return NoPlane("nothing turns about an axis", None)
        base, axis, span = first
        axes = plain_matrix(spatial.product(base, _basis(axis)))
        leaving = self._leaving(axes)
        if leaving is not None:
            return leaving
        numbers = self._numbers()
        return numbers if isinstance(numbers, NoPlane) else Plane(axes, numbers, span)

    def _first_turn(self) -> tuple[Matrix, Vector, Span] | None:
        graph = self.kinematics.graph
        own = dict.fromkeys((root.frame for root in graph.roots), _UNIT)
        for edge in graph.edges:
            here = own[edge.parent]
            for step in (step for step in edge.steps if step.kind == "turn"):
                axis, angle = self._axis(step), self._amount(step)
                if self._changes((1.0,), (angle,)):
                    return here, axis, edge.span
                here = self._turned(here, step, axis, angle)
            own[edge.child] = here
        return None

    def _leaving(self, axes: Matrix) -> NoPlane | None:
        """What turns about another axis, or shifts along that of the plane."""
        graph = self.kinematics.graph
        own = dict.fromkeys((root.frame for root in graph.roots), plain_matrix(spatial.transposed(axes)))
        for edge in graph.edges:
            found = self._along(own[edge.parent], edge.steps, edge.coordinates, edge.span)
            if isinstance(found, NoPlane):
                return found
            own[edge.child] = found
        for cut in graph.closures:
            a, b = self._along(own[cut.a], cut.steps_a, (), cut.span), self._along(own[cut.b], cut.steps_b, (), cut.span)
            if isinstance(a, NoPlane) or isinstance(b, NoPlane):
                return a if isinstance(a, NoPlane) else b if isinstance(b, NoPlane) else None
            if abs(dot(a[2], b[2]) - 1) > _TILTED:
                return NoPlane("the two sides of a loop are tilted against each other", cut.span)
            if cut.freedom is not None and (leaves_it := self._freed(a, cut, cut.freedom)) is not None:
                return leaves_it
        return None

    def _freed(self, own: Matrix, cut: Closure, freedom: Step) -> NoPlane | None:
        """What a cut joint leaves free, if that is not in the plane."""
        if cut.ahead is not None:
            return NoPlane(f"'{cut.ahead_kept}' and '{cut.kept}' lead out of any plane", cut.span)
        if freedom.kind == "turn":
            is_free = bool(along_normal(spatial.times_matrix(own, self._axis(freedom))))
            return None if is_free else NoPlane(f"'{cut.kept}' turns about an axis that is not parallel to others", cut.span)
        origin, ahead = way_of_shift(self.kinematics, freedom, cut.kept)
        way = [minus(y, x) for x, y in zip(origin, ahead, strict=True)]
        size = max(abs(self._value(x)) for x in way)
        is_free = abs(self._number(dot(own[2], way))) <= _NEGLIGIBLE * size
        return None if is_free else NoPlane(f"'{cut.kept}' shifts along an axis about which others turn", cut.span)

    def _along(self, own: Matrix, steps: Sequence[Step], coordinates: Sequence[str], span: Span) -> Matrix | NoPlane:
        moved = f"'{coordinates[0]}'" if coordinates else f"'{span.text}'"
        for step in steps:
            amount = self._amount(step)
            if step.kind == "shift":
                if self._leaves(own[2], amount):
                    return NoPlane(f"{moved} shifts along an axis about which others turn", span)
                continue
            axis = self._axis(step)
            if along_normal(spatial.times_matrix(own, axis)):
                continue
            if self._changes((1.0,), (amount,)):
                return NoPlane(f"{moved} turns about an axis that is not parallel to others", span)
            own = self._turned(own, step, axis, amount)
        return own

    def _turned(self, own: Matrix, step: Step, axis: Vector, angle: Scalar) -> Matrix:
        angle = self._number(angle)
        return plain_matrix(spatial.product(own, spatial.rotation(axis, -angle if step.is_inverse else angle,
                                                                  self.kinematics.algebra)))

    def _amount(self, step: Step) -> Scalar | Vector:
        return self.kinematics.evaluator.value(step.amount)

    def _axis(self, step: Step) -> Vector:
        """Of length 1."""
        if step.axis is None:
            return _UNIT[2]
        numbers = tuple(map(self._number, self.kinematics.evaluator.value(step.axis)))
        return spatial.unit_axis(step, numbers, self.kinematics.algebra)

    def _changes(self, along: Sequence[float], value: Sequence[Scalar]) -> bool:
        """Whether the motion, time or inputs change what a value has along a direction."""
        changes = changes_of(value, self.values)
        if not np.isfinite(changes).all():
            return bool(np.isinf(changes[np.array(along) != 0]).any())
        return bool(np.abs(np.array(along) @ changes).max() > _NEGLIGIBLE * np.abs(changes).max() + _ROUNDING)

    def _leaves(self, normal: Vector, amount: Vector) -> bool:
        """Whether a shift changes along the normal: whatever the parameters, or with those that are compiled in as they are
        declared, which it then takes note of."""
        if not self._changes(normal, amount):
            return False
        variables = self.kinematics.graph.model.variables
        known = [x for x in self._symbols(column(*amount)) if x.__hash__() in self.values]
        own = [x for x in known if variables[self.names[x.__hash__()]].is_evaluated]
        numbers = ca.DM([self.values[x.__hash__()] for x in own])
        if not own or self._changes(normal, scalars_in(ca.substitute(column(*amount), ca.vertcat(*own), numbers))):
            return True
        self.used |= {self.names[x.__hash__()] for x in own}
        return False

    def _number(self, value: Scalar) -> float:
        """With the parameters as they are declared, which it takes note of. Raises _NoNumber."""
        found = self._value(value)
        self.used |= {self.names[x.__hash__()] for x in self._symbols(value)}
        return found

    def _value(self, value: Scalar) -> float:
        """With the parameters as they are declared. Raises _NoNumber."""
        symbols = self._symbols(value)
        if any(x.__hash__() not in self.values for x in symbols):
            raise _NoNumber
        numbers = ca.DM([self.values[x.__hash__()] for x in symbols])
        found = float(ca.evalf(ca.substitute(value, ca.vertcat(*symbols), numbers)) if symbols else value)
        if not isfinite(found):
            raise _NoNumber
        return found

    @staticmethod
    def _symbols(value: Scalar) -> list[ca.SX]:
        return list(ca.symvar(value)) if isinstance(value, ca.SX) else []

    def _numbers(self) -> dict[str, tuple[float | None, ...]] | NoPlane:
        """Of the parameters that it takes note of, and of those that they follow."""
        variables = self.kinematics.graph.model.variables
        bindings = {name: v.binding for name, v in variables.items()}
        roots: list[Flat] = [x for name in self.used if (x := bindings[name]) is not None]
        names = self.used | {leaf.name for leaf in leaves(roots, bindings) if isinstance(leaf, Ref)}
        chosen = [variables[name] for name in variables if name in names and variables[name].kind == "parameter"]
        for variable in chosen:
            if self.is_general and not variable.locked:
                return NoPlane(f"the parameter '{variable.name}' says where axes point, and can be set", variable.span)
        values: dict[str, list[float]] = {}
        for key, name in self.names.items():
            values.setdefault(name, []).append(float(self.values[key]))
        return {variable.name: tuple(values[variable.name]) for variable in chosen}


def _basis(normal: Vector) -> Matrix:
    """Columns: two axes across the normal, and the normal; axes of coordinates where it is along one of these."""
    along = [k for k, x in enumerate(normal) if x != 0]
    if len(along) == 1:
        k = along[0]
        return spatial.transposed((_UNIT[(k + 1) % 3], _UNIT[(k + 2) % 3], _UNIT[k]))
    least = min(range(3), key=lambda k: abs(normal[k]))
    across = spatial.cross(normal, _UNIT[least])
    size = sqrt(dot(across, across))
    first = tuple(times(x, 1 / size) for x in across)
    return spatial.transposed((first, spatial.cross(normal, first), normal))


