"""Joint reactions, from Lagrange's equations of the released directions (released_directions.py).

A joint of the tree is released by all virtual displacements of what lies behind it: they give the force and the torque that the
joint exerts. Where a loop is cut, the multipliers are the reaction, and what acts on the cut coordinate adds to them. Rows
that only repeat others carry nothing: where constraints are redundant, this is one of the ways in which they can share the load;
shared_reactions.py has that of least squares. Only what is asked for is built.
"""

from collections.abc import Mapping, Sequence
from typing import NoReturn

import casadi as ca

from lagrangia.base.diagnostics import Span, fail
from lagrangia.constraints.rows import Constraints, Row
from lagrangia.dynamics.bodies import Bodies
from lagrangia.dynamics.driven_joints import force_beside_drives
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.released_directions import Released, forces_of_ties
from lagrangia.dynamics.shared_reactions import shared_by_least_squares
from lagrangia.frames.closures import meeting_place, wrench_on_b
from lagrangia.frames.edges import Closure, Edge
from lagrangia.frames.joints import component_of, cuts_of, joints_of, reaction_ports
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.consequences import equation_of
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import FrameRef


def build_reactions(kinematics: Kinematics, bodies: Bodies, constraints: Constraints, motion: Motion) -> tuple[ca.SX, ca.SX]:
    """The symbols that stand for reactions in outputs, and their values in t, q, v, a, lambda, u, d, p: a wrench of each joint,
    and one of each equation that is asked for its force.

    Raises LagError L0911 for what has no reaction.
    """
    asked = kinematics.reactions
    if not asked and not kinematics.forces:
        return ca.SX(0, 1), ca.SX(0, 1)
    if constraints.touching:
        _refuse(kinematics, constraints.touching[0])
    edges, cuts = joints_of(kinematics.graph), cuts_of(kinematics.graph)
    ports = [f"{path}.{port}" for path, port in reaction_ports(kinematics.graph).items()] if constraints.least_squares else []
    wanted = list(dict.fromkeys((*asked, *ports)))
    ties = {frame: [row for row in constraints.all_rows if row.loop is None and row.component == component_of(frame)]
            for frame in wanted if frame not in cuts and frame not in edges}
    contacts = {when.component for when in kinematics.graph.model.whens}
    for frame in (frame for frame, rows in ties.items() if not rows and component_of(frame) not in contacts):
        fail("L0911", f"'{component_of(frame)}' is no joint, so it has no reaction", _asked_at(kinematics, frame))
    sizes = {edges[frame][0].child: kinematics.geometry.size for frame in wanted if frame in edges}
    sizes |= {cuts[frame][0].coordinate: 1 for frame in wanted if frame in cuts and cuts[frame][0].coordinate}
    released = Released(kinematics, bodies, constraints, motion, sizes)
    values = forces_of_ties(kinematics, released, ties)
    for frame in wanted:
        if frame in cuts:
            values[frame] = _of_cut(kinematics, constraints, *cuts[frame], frame, released)
        elif frame in edges:
            values[frame] = _of_joint(kinematics, constraints, *edges[frame], frame, released)
    forces = [_along_left_side(kinematics, constraints, released, name) for name in kinematics.forces]
    symbols = ca.vertcat(*[s for frame in asked for s in asked[frame]], *kinematics.forces.values())
    told = ca.vertcat(*[values[frame] for frame in asked], *forces)
    told = shared_by_least_squares(kinematics, constraints, motion, released, [values[frame] for frame in ports],
                                   _of_no_port(constraints, released, ports, cuts), told)
    return symbols, ca.substitute(told, kinematics.symbols.tau, ca.SX(1))


def _of_no_port(constraints: Constraints, released: Released, ports: Sequence[str], cuts: Mapping[str, tuple[Closure, float]]
                ) -> ca.SX:
    """The multipliers of rows that belong to no joint or tie among those with these ports."""
    joints = [cut for frame, (cut, _) in cuts.items() if frame in ports]
    ties = {component_of(frame) for frame in ports}
    return ca.vertcat(ca.SX(0, 1), *[released.multiplier(row) for row in constraints.all_rows
                                     if (row.component not in ties if row.loop is None else row.loop not in joints)])


def _refuse(kinematics: Kinematics, straight: Row) -> NoReturn:
    """Where a constraint only just holds."""
    frame = next(iter(kinematics.reactions), None)
    what = "the force of an equation" if frame is None else f"the reaction of '{component_of(frame)}'"
    fail("L0911", f"{what} is not known: {straight.told} only just holds, so that nothing bounds its force",
         straight.span if frame is None else _asked_at(kinematics, frame),
         "make what is straight there a little longer or shorter")


def _along_left_side(kinematics: Kinematics, constraints: Constraints, released: Released, name: str) -> ca.SX:
    """-lambda: the power of left = right is that times the rate of either side."""
    equation = kinematics.graph.model.constraints[equation_of(name)]
    rows = [row for row in constraints.all_rows if row.equation is equation]
    if len(rows) != 1 or not rows[0].is_holonomic:
        fail("L0911", "not supported yet: the force of an equation between rates, or between vectors", equation.span,
             "write one equation for each component, between positions or angles")
    return -released.multiplier(rows[0])


def _asked_at(kinematics: Kinematics, frame: str) -> Span:
    """Where an output names the reaction; the frame's declaration when it was asked for by name."""
    bindings = [v.binding for v in kinematics.graph.model.variables.values() if v.binding is not None]
    named = [x for x in nodes(*bindings) if isinstance(x, FrameRef) and x.name == frame and x.attribute in REACTIONS]
    return named[0].span if named else kinematics.graph.model.frames[frame].span


def _of_joint(
    kinematics: Kinematics, constraints: Constraints, edge: Edge, sign: float, frame: str, released: Released
) -> ca.SX:
    """Force and torque that a joint of the tree exerts on the side of `frame`, about the origin of `frame`."""
    force = released.force(edge.child) - force_beside_drives(kinematics, constraints, released, edge)
    return kinematics.geometry.wrench_about(sign * force, kinematics.pose(edge.child, 0), kinematics.pose(frame, 0))


def _of_cut(
    kinematics: Kinematics, constraints: Constraints, closure: Closure, sign: float, frame: str, released: Released
) -> ca.SX:
    """The multipliers of a cut joint push its gaps shut: -lambda times the gap's slope is the force on its frame b.

    What acts on the coordinate of the joint itself (a spring, a motor in it) adds to them; a joint that is cut with all its
    coordinates keeps them, and the multipliers are all that holds b.
    """
    rows = sorted((row for row in constraints.all_rows if row.loop is closure), key=lambda row: row.part)
    drive = released.force(closure.coordinate) if closure.coordinate else ca.SX(0)
    on_b = ca.vertcat(*wrench_on_b(kinematics, closure, [-released.multiplier(row) for row in rows], drive))
    return kinematics.geometry.wrench_about(sign * on_b, meeting_place(kinematics, closure), kinematics.pose(frame, 0))
