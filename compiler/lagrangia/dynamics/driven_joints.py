"""Joints that are driven: an equation that speaks of one coordinate of a joint alone moves it by a force or torque in the joint.

All that is bound to a coordinate acts in its joint: springs, motors, equations. Where one of these is a drive, what ties the same
coordinate to others (a Geneva wheel, a cam, a gear written with angles) acts on the bodies beside it, as if it were written with
their frames: else the drive and the load it carries would cancel in the reaction of the joint.
"""

from collections.abc import Sequence

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.constraints.rows import Constraints, Row
from lagrangia.dynamics.released_directions import Released
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Value
from lagrangia.frames.kinematics import Kinematics, displacement
from lagrangia.language.flat import Equation
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import FrameRef, Ref


def force_beside_drives(kinematics: Kinematics, constraints: Constraints, released: Released, edge: Edge) -> ca.SX:
    """What ties exert on the edge's child by a coordinate that is driven: force and torque about the child's origin."""
    total = ca.SX.zeros(kinematics.geometry.size)
    for name in edge.coordinates:
        rows = {id(row): (row, named) for row in constraints.all_rows if row.equation is not None and row.is_holonomic
                and name in (named := _named(kinematics, row.equation))}
        if not any(named == {name} for _, named in rows.values()):
            continue
        ties = [row for row, named in rows.values() if named != {name}]
        if not ties:
            continue
        force = -sum((released.multiplier(row) * _slope(kinematics, row, name) for row in ties), ca.SX(0))
        total += force * _direction(kinematics, edge, name)
    return total


def _named(kinematics: Kinematics, equation: Equation) -> set[str]:
    """The coordinates, and the frames, that an equation speaks of."""
    variables = kinematics.graph.model.variables
    found = leaves((equation.left, equation.right), {name: v.binding for name, v in variables.items()})
    coordinates = {x.name for x in found if isinstance(x, Ref) and variables[x.name].kind == "coordinate"}
    frames = kinematics.graph.model.frames
    return coordinates | {x.name for x in found if isinstance(x, FrameRef) and not frames[x.name].is_ground}


class _Nudged:
    """Leaves of an evaluator in which one coordinate has a displacement and a rate of its own, and nothing follows it."""

    def __init__(self, kinematics: Kinematics, name: str) -> None:
        self.kinematics, self.name = kinematics, name
        self.symbols = kinematics.algebra.index.displacements.new(2)

    def symbol(self, name: str, level: int) -> Value | None:
        value = self.kinematics.symbol(name, level)
        return value + displacement(tuple(self.symbols.elements()), level) if name == self.name else value

    def slopes(self, values: Sequence[Scalar], which: int) -> list[ca.SX]:
        """Of these by the displacement (0) or the rate (1), where both are 0."""
        found = [ca.gradient(ca.SX(value), self.symbols[which]) for value in values]
        return [ca.substitute(slope, self.symbols, ca.SX.zeros(2)) for slope in found]

    def time(self, level: int) -> Scalar:
        return self.kinematics.time(level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        return self.kinematics.frame(name, attribute, level)


def _slope(kinematics: Kinematics, row: Row, name: str) -> ca.SX:
    """Of a row, along one coordinate."""
    assert row.equation is not None
    nudged = _Nudged(kinematics, name)
    value = Evaluator(kinematics.graph.model, kinematics.algebra, nudged).value
    left, right = (value(side) for side in (row.equation.left, row.equation.right))
    gap = left[row.part] - right[row.part] if isinstance(left, tuple) else left - right
    return nudged.slopes([gap], 0)[0]


def _direction(kinematics: Kinematics, edge: Edge, name: str) -> ca.SX:
    """The force and torque on the edge's child that do the work of a unit force on the coordinate, when the parent rests."""
    nudged = _Nudged(kinematics, name)
    evaluator = Evaluator(kinematics.graph.model, kinematics.algebra, nudged)
    pose = kinematics.follow(edge, kinematics.pose(edge.parent, 1), 1, evaluator)
    return kinematics.geometry.unit_load(nudged.slopes(pose.twist, 1))
