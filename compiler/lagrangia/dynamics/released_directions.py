"""Generalised forces in directions that the constraints forbid, and the multipliers of the rows that gave a coordinate.

A direction is released by a virtual displacement: of what lies behind a joint (a place, along the world's axes), of the
coordinate of a cut joint, or of a coordinate that a linear row gave. At displacement zero, with the accelerations of the real
motion, Lagrange's equation of the released direction gives the force that holds it:

    R = d/dt(dT/dv) - dT/dq + dV/dq + dD/dv - f + J_rest^T lambda_rest + J_given^T lambda_given

Nothing but the given rows holds the given coordinates, so R vanishes for them:  J_given,given^T lambda_given = -(the rest of R).
"""

from collections.abc import Mapping, Sequence

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.constraints.rows import Constraints, Row
from lagrangia.dynamics.bodies import Bodies
from lagrangia.dynamics.energies import Energies, build_energies
from lagrangia.dynamics.motion import Motion, body_reaction
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.joints import component_of
from lagrangia.frames.kinematics import Kinematics


class Released:
    """The scene with virtual displacements: `sizes` says of how many components each is, by frame or coordinate."""

    def __init__(
        self, kinematics: Kinematics, bodies: Bodies, constraints: Constraints, motion: Motion, sizes: Mapping[str, int]
    ) -> None:
        self.kinematics, self.bodies, self.constraints, self.motion = kinematics, bodies, constraints, motion
        self.open = ca.SX.sym("open", len(constraints.repeated) if constraints.least_squares else 0)
        self.multipliers = {id(row): x for row, x in zip(constraints.repeated, self.open.elements(), strict=False)}
        given = dict.fromkeys(kinematics.dependents, 1) if constraints.absorbed else {}
        self.places, start = {}, 0
        for name, size in {**sizes, **given}.items():
            self.places[name], start = slice(start, start + size), start + size
        new = kinematics.algebra.index.displacements.new
        shift, rate = new(start), new(start)
        free = kinematics.displaced({name: (shift[place], rate[place]) for name, place in self.places.items()})
        rows = ca.vertcat(*[row.value(free, 0) for row in constraints.absorbed])
        found = ca.densify(self._residual(free, shift, rate)), ca.jacobian(rows, shift)
        residual, slopes = ca.substitute(list(found), [shift, rate], [ca.SX.zeros(start), ca.SX.zeros(start)])
        places = [self.places[name].start for name in given]
        given_by = -ca.solve(slopes[:, places].T, residual[places]) if given else ca.SX(0, 1)
        self.forces = residual + slopes.T @ given_by if given else residual
        self.multipliers |= {id(row): given_by[k] for k, row in enumerate(constraints.absorbed)}
        if motion.constrained is not None:
            self.multipliers |= {id(row): motion.constrained.symbols[k] for k, row in enumerate(constraints.rows)}

    def force(self, name: str) -> ca.SX:
        """What holds the released direction: N and N.m, the components in the order of the displacement."""
        return self.forces[self.places[name]]

    def multiplier(self, row: Row) -> ca.SX:
        """Of any row; one that only repeats others carries nothing, or, where least squares are asked for, what is `open`."""
        return self.multipliers.get(id(row), ca.SX(0))

    def _residual(self, free: Kinematics, shift: ca.SX, rate: ca.SX) -> ca.SX:
        """R without the rows that gave a coordinate."""
        energies = build_energies(free)
        positions: list[Scalar] = [energies.total(energies.potential)]
        forces: list[Scalar] = [1.0]
        rates, powers = list[Scalar](), list[Scalar]()  # of what works by its rates
        for inertia in self.bodies.inertias:
            by_rates = free.geometry.by_rates
            moved, wrench = (rates, powers) if by_rates else (positions, forces)
            moved += free.pose(inertia.frame, 1).twist if by_rates else free.pose(inertia.frame, 0).place
            wrench += [force for _, force in body_reaction(self.kinematics, inertia)]
        for load in (*energies.loads, *self.motion.impacts.loads_in(free)):
            moved, wrench = (rates, powers) if load.is_by_rate else (positions, forces)
            moved += load.position
            wrench += [-f for f in load.force]
        total = ca.jtimes(ca.vertcat(*positions), shift, ca.vertcat(*forces), True)
        if rates:
            total += ca.jtimes(ca.vertcat(*rates), rate, ca.vertcat(*powers), True)
        total += ca.gradient(energies.total(energies.dissipation), rate)
        return total + self._other_inertia(energies, shift, rate) + self._remaining_rows(free, shift, rate)

    def _other_inertia(self, energies: Energies, shift: ca.SX, rate: ca.SX) -> ca.SX:
        """d/dt(dT/drate) - dT/dshift of the kinetic terms that are no rigid body's."""
        others = {id(term.statement) for term in self.bodies.rest}
        T = energies.total(tuple(term for term in energies.kinetic if id(term.statement) in others))
        motion, symbols = self.motion, self.kinematics.symbols
        moving, rates = ca.vertcat(motion.q, motion.v, motion.t), ca.vertcat(motion.v, motion.a, symbols.tau)
        return ca.jtimes(ca.densify(ca.gradient(T, rate)), moving, rates) - ca.gradient(T, shift)

    def _remaining_rows(self, free: Kinematics, shift: ca.SX, rate: ca.SX) -> ca.SX:
        total, held = ca.SX.zeros(shift.numel()), self.motion.constrained
        for is_holonomic, moved in ((True, shift), (False, rate)):
            chosen = [k for k, row in enumerate(self.constraints.rows) if row.is_holonomic == is_holonomic]
            if chosen and held is not None:
                rows = ca.vertcat(*[self.constraints.rows[k].value(free, 0) for k in chosen])
                total += ca.jtimes(rows, moved, held.symbols[chosen], True)
        if self.open.numel():
            repeated = ca.vertcat(*[row.value(free, 0) for row in self.constraints.repeated])
            total += ca.jtimes(repeated, shift, self.open, True)
        return total


def forces_of_ties(
    kinematics: Kinematics, released: Released, ties: Mapping[str, Sequence[Row]]
) -> dict[str, ca.SX]:
    """What the rows of each tie exert on its frame: -lambda times the slope of the row when that frame alone is displaced; of a
    contact at which something rests, its force times the slope of the gap."""
    size = kinematics.geometry.size
    new = kinematics.algebra.index.displacements.new
    shift, rate = new(size * len(ties)), new(size * len(ties))
    places = {frame: slice(size * k, size * (k + 1)) for k, frame in enumerate(ties)}
    lone = kinematics.displaced({}, {frame: (shift[place], rate[place]) for frame, place in places.items()})
    forces = {}
    for frame, rows in ties.items():
        force = ca.SX.zeros(size)
        for row in rows:
            moved = (shift if row.is_holonomic else rate)[places[frame]]
            force -= released.multiplier(row) * ca.gradient(ca.SX(row.value(lone, 0)), moved)
        for load in released.motion.impacts.contacts_of(component_of(frame)):
            gap = ca.vertcat(*scalars_of(lone.evaluator.value(load.statement.position)))
            force += ca.jtimes(gap, shift[places[frame]], ca.vertcat(*load.force), True)
        forces[frame] = ca.substitute([force], [shift, rate], [ca.SX.zeros(shift.numel())] * 2)[0]
    return forces
