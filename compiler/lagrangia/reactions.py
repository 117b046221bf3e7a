"""Joint reactions, from Lagrange's equations of the released coordinates.

A joint is released by three virtual displacements of what lies behind it (x, y and an angle, in world axes at the joint). Their
equations, at displacement zero and with the accelerations of the real motion, give the force and the torque that the joint
exerts:  R = d/dt(dT/dv) - dT/dq + dV/dq + dD/dv - f + (dPhi/dq)^T lambda. Where a loop is cut, the multipliers are the reaction.
Only what is asked for is built.
"""

import casadi as ca

from lagrangia.algebra import Scalar
from lagrangia.bodies import Bodies
from lagrangia.closures import gaps, slide_normal
from lagrangia.constraints import Constraints
from lagrangia.diagnostics import Span, fail
from lagrangia.edges import Closure, Edge
from lagrangia.energies import build_energies
from lagrangia.instances import REACTIONS
from lagrangia.kinematics import Kinematics
from lagrangia.motion import Motion, inertial_reaction
from lagrangia.tree import FrameRef
from lagrangia.walk import nodes


def build_reactions(kinematics: Kinematics, bodies: Bodies, constraints: Constraints, motion: Motion) -> tuple[ca.SX, ca.SX]:
    """The symbols that stand for reactions in outputs, and their values in t, q, v, a, lambda, u, d, p: (3 k,) each.

    Raises LagError L0911 for what has no reaction.
    """
    asked = kinematics.reactions
    if not asked:
        return ca.SX(0, 1), ca.SX(0, 1)
    joints = [edge for edge in kinematics.graph.edges if _is_joint(edge)]
    edges = {edge.child: (edge, 1.0) for edge in joints} | {edge.parent: (edge, -1.0) for edge in joints}
    cuts = {closure.b: closure for closure in kinematics.graph.closures}
    released = _Released(kinematics, bodies, constraints, motion)
    values = []
    for frame in asked:
        if frame in cuts:
            values.append(_of_cut(kinematics, constraints, motion, cuts[frame], released))
        elif frame in edges:
            values.append(released.reaction(*edges[frame], frame))
        else:
            fail("L0911", f"'{frame.rpartition('.')[0]}' is no joint, so it has no reaction", _asked_at(kinematics, frame))
    symbols = ca.vertcat(*[s for frame in asked for s in asked[frame]])
    return symbols, ca.substitute(ca.vertcat(*values), kinematics.symbols.tau, ca.SX(1))


def _asked_at(kinematics: Kinematics, frame: str) -> Span:
    """Where an output names the reaction; the frame's declaration when it was asked for by name."""
    bindings = [v.binding for v in kinematics.graph.model.variables.values() if v.binding is not None]
    named = [x for x in nodes(*bindings) if isinstance(x, FrameRef) and x.name == frame and x.attribute in REACTIONS]
    return named[0].span if named else kinematics.graph.model.frames[frame].span


def _is_joint(edge: Edge) -> bool:
    """Whether the edge lies between the ports a and b of one component."""
    path = edge.child.rpartition(".")[0]
    return {edge.parent, edge.child} == {f"{path}.a", f"{path}.b"}


def _of_cut(
    kinematics: Kinematics, constraints: Constraints, motion: Motion, closure: Closure, released: "_Released"
) -> ca.SX:
    """The multipliers of a cut joint push its gaps shut: -lambda times the gap's slope is the force on b.

    What acts on the coordinate itself (a spring, a motor in the joint) adds to them.
    """
    held = motion.constrained
    rows = [k for k, row in enumerate(constraints.rows) if row.loop is closure]
    if closure.kind == "weld":
        fail("L0912", "not supported yet: the reaction of a joint that closes a loop with all its coordinates", closure.span,
             "ask for the reaction of another joint of the loop")
    if held is None or len(rows) != len(gaps(kinematics, closure, 0)):
        fail("L0912", "not supported yet: the reaction of a cut joint whose equations gave a coordinate", closure.span,
             "ask for the reaction of another joint of the loop")
    forces = [-held.symbols[k] for k in rows]
    drive = released.drive(closure)
    if closure.kind == "hinge":
        return ca.vertcat(*forces, drive)
    torque, across = forces
    x, y, length = slide_normal(kinematics, closure)
    along = drive / length
    return ca.vertcat(across * x + along * y, across * y - along * x, torque)


class _Released:
    """The scene with virtual displacements behind every tree joint that is asked for."""

    def __init__(self, kinematics: Kinematics, bodies: Bodies, constraints: Constraints, motion: Motion) -> None:
        self.kinematics, self.bodies, self.constraints, self.motion = kinematics, bodies, constraints, motion

    def reaction(self, edge: Edge, sign: float, frame: str) -> ca.SX:
        """Force and torque that the joint exerts on the side of `frame`, about the origin of `frame`."""
        shift, rate = ca.SX.sym("shift", 3), ca.SX.sym("rate", 3)
        free = Kinematics(self.kinematics.graph, self.kinematics.symbols, self.kinematics.algebra, self.kinematics.dependents,
                          {edge.child: (shift, rate)})
        force = self._force(free, shift, rate, frame)
        at_rest = ca.substitute(force, ca.vertcat(shift, rate), ca.SX.zeros(6))
        if sign > 0:
            return at_rest
        here, there = self.kinematics.pose(edge.child, 0), self.kinematics.pose(frame, 0)
        dx, dy = here.x - there.x, here.y - there.y
        return -ca.vertcat(at_rest[0], at_rest[1], at_rest[2] + dx * at_rest[1] - dy * at_rest[0])

    def drive(self, closure: Closure) -> ca.SX:
        """The generalised force that acts on the coordinate of a cut joint, in the sense in which b moves away from a."""
        assert closure.freedom is not None
        shift, rate = ca.SX.sym("shift"), ca.SX.sym("rate")
        free = Kinematics(self.kinematics.graph, self.kinematics.symbols, self.kinematics.algebra, self.kinematics.dependents,
                          {closure.coordinate: (shift, rate)})
        force = ca.substitute(self._force(free, shift, rate, closure.b), ca.vertcat(shift, rate), ca.SX.zeros(2))
        return force if closure.kind == "hinge" and closure.freedom.is_inverse else -force

    def _force(self, free: Kinematics, shift: ca.SX, rate: ca.SX, frame: str) -> ca.SX:
        energies = build_energies(free)
        positions: list[Scalar] = [energies.total(energies.potential)]
        forces: list[Scalar] = [1.0]
        for inertia in self.bodies.inertias:
            asked = inertial_reaction(self.kinematics, inertia)
            moved = inertial_reaction(free, inertia)
            positions += [place for place, _ in moved]
            forces += [force for _, force in asked]
        for load in energies.loads:
            positions += load.position
            forces += [-f for f in load.force]
        total = ca.jtimes(ca.vertcat(*positions), shift, ca.vertcat(*forces), True)
        total += ca.gradient(energies.total(energies.dissipation), rate)
        if self.bodies.rest:
            fail("L0913", "not supported yet: reactions beside kinetic terms that are no rigid body's",
                 _asked_at(self.kinematics, frame))
        return total + self._constraint_force(free, shift, rate)

    def _constraint_force(self, free: Kinematics, shift: ca.SX, rate: ca.SX) -> ca.SX:
        for row in self.constraints.absorbed:
            if ca.depends_on(ca.SX(row.value(free, 0)), shift):
                fail("L0912", "not supported yet: reactions beside a linear equation between frames", row.span)
        held = self.motion.constrained
        if held is None:
            return ca.SX.zeros(shift.numel())
        rows = [ca.SX(row.value(free, 0)) for row in self.constraints.rows]
        moved = [shift if row.is_holonomic else rate for row in self.constraints.rows]
        slopes = [ca.gradient(row, by) * held.symbols[k] for k, (row, by) in enumerate(zip(rows, moved, strict=True))]
        return ca.sum2(ca.horzcat(*slopes))
