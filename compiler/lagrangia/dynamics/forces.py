"""Potentials, dissipation, loads and closed loops -> forces and moments on frames, and on what is left, forces on coordinates.

A generalised force sums up all that acts behind a joint. Solving along the tree takes these sums apart again, and what is left
of their rounding is divided by the inertia of one body: of a chain of 20 links three digits went that way. So each force stays
on the body it acts on, found by virtual displacements of every frame and every coordinate that an energy reads, apart from all
others.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field

import casadi as ca

from lagrangia.algebra.displacements import Displacements
from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import cells, column, scalars_in
from lagrangia.base.records import dataclass
from lagrangia.constraints.rows import Row
from lagrangia.dynamics.dissipation import gradient_by_rates
from lagrangia.dynamics.energies import Energies, Term
from lagrangia.frames.alike import evaluate_all
from lagrangia.frames.evaluation import Evaluator, Value, scalars_of
from lagrangia.frames.kinematics import Kinematics, displacement
from lagrangia.language.attitudes import parts_of
from lagrangia.language.frame_attributes import FrameAttribute


@dataclass(frozen=True)
class Forces:
    """What they take from the motion, as h does."""

    on_frames: Mapping[str, list[Scalar]]  # wrenches: along the axes of the world, N; about the frame's origin, N.m
    on_coordinates: Mapping[str, Scalar]


@dataclass
class _Apart:
    """Leaves of an evaluator in which each frame and each coordinate that is read has displacements and rates of its own."""

    kinematics: Kinematics
    new: Displacements
    movable: frozenset[str]
    frames: dict[str, tuple[list[Scalar], list[Scalar]]] = field(default_factory=dict)
    coordinates: dict[str, tuple[Scalar, Scalar]] = field(default_factory=dict)
    is_whole: bool = True  # no coordinate was read that has no displacement of its own, as that of a cut joint

    def symbol(self, name: str, level: int) -> Value | None:
        if level > 0 and name in self.kinematics.symbols.attitudes:  # of which only the rate is asked
            return tuple(self.symbol(part, level) for part in parts_of(name))
        value = self.kinematics.symbol(name, level)
        if name not in self.kinematics.symbols.positions:
            self.is_whole &= not self._is_moved(name)
            return value
        if name not in self.coordinates:
            shift, rate = cells(self.new.new(2))
            self.coordinates[name] = shift, rate
        return value + displacement(self.coordinates[name], level)

    def _is_moved(self, name: str) -> bool:
        """Whether it is a coordinate that has no symbol of its own to be displaced by, unless others give it."""
        kinematics = self.kinematics
        variable = kinematics.graph.model.variables.get(name)
        return variable is not None and variable.kind == "coordinate" and name not in kinematics.dependents

    def time(self, level: int) -> Scalar:
        return self.kinematics.time(level)

    def frames_together(self, names: Sequence[str], attribute: str, level: int,
                        stacked: Callable[[Sequence[Value]], Value]) -> Value:
        """Of each name that attribute, in columns; `stacked` puts values into them."""
        news = dict.fromkeys(name for name in names if name in self.movable and name not in self.frames)
        known, size = self.kinematics.graph.model.space.attributes[attribute], self.kinematics.geometry.size
        if len(news) != len(names) or known.kind == "reaction" or self.kinematics.geometry.by_poses:
            return stacked([self.frame(name, attribute, level) for name in names])
        value = stacked([self.kinematics.frame(name, attribute, level) for name in names])
        shifts, rates = ([self.new.new(len(names)) for _ in range(size)] for _ in range(2))
        parts = zip(*(zip(*map(cells, columns), strict=True) for columns in (shifts, rates)), strict=True)
        self.frames |= {name: ([*shift], [*rate]) for name, (shift, rate) in zip(names, parts, strict=True)}
        return self._moved(value, known, shifts, rates, level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        value = self.kinematics.frame(name, attribute, level)
        known = self.kinematics.graph.model.space.attributes[attribute]
        if name not in self.movable or known.kind == "reaction":  # reactions move with nothing
            return value
        if name not in self.frames:
            size = self.kinematics.geometry.size
            made = cells(self.new.new(2 * size))
            self.frames[name] = made[:size], made[size:]
        shift, rate = self.frames[name]
        if self.kinematics.geometry.by_poses:
            return self._displaced(name, attribute, level)
        return self._moved(value, known, shift, rate, level)

    @staticmethod
    def _moved(value: Value, known: FrameAttribute, shift: Sequence[Scalar], rate: Sequence[Scalar], level: int) -> Value:
        if known.kind == "place":
            moved = tuple(displacement((shift[k], rate[k]), level) for k in known.components)
        else:
            moved = tuple(displacement((rate[k],), level) for k in known.components)
        return tuple(a + b for a, b in zip(value, moved, strict=True)) if isinstance(value, tuple) else value + moved[0]

    def _displaced(self, name: str, attribute: str, level: int) -> Value:
        """In space, where an attitude has no numbers that displacements add to."""
        kinematics, (shift, rate) = self.kinematics, self.frames[name]
        if attribute == "Q":
            self.is_whole = False
            return kinematics.frame(name, attribute, level)
        at = level + 1 if kinematics.graph.model.space.attributes[attribute].kind == "velocity" else level
        moved = [displacement(pair, at) for pair in zip(shift, rate, strict=True)]
        pose = kinematics.pose(name, at).displaced(moved, kinematics.evaluator.algebras[at])
        return kinematics.geometry.attribute_of(pose, attribute)


def find_forces(kinematics: Kinematics, energies: Energies) -> Forces | None:
    """None where one of them reads the coordinate of a cut joint, or a length on a line, whose frames it is not read off."""
    known = kinematics.algebra
    if known.index.lengths:
        return None
    apart = _Apart(kinematics, known.index.displacements, _movable(kinematics))
    evaluator = Evaluator(kinematics.graph.model, known, apart)
    value = evaluator.value

    def total(terms: Sequence[Term]) -> ca.SX:
        values = evaluate_all([term.statement.value for term in terms], [evaluator] * len(terms))
        return energies.total(tuple(Term(x, term.statement) for x, term in zip(values, terms, strict=True)))

    potential, dissipation = total(energies.potential), total(energies.dissipation)
    positions, forces, spins, torques = [potential], [1.0], list[Scalar](), list[Scalar]()
    for load in energies.loads:
        moved, acting = (spins, torques) if load.is_by_rate else (positions, forces)
        moved += scalars_of(value(load.moved))
        acting += [-force for force in load.force]
    if not apart.is_whole:
        return None
    places = [*apart.frames.values(), *(([shift], [rate]) for shift, rate in apart.coordinates.values())]
    shifts, rates = (column(*[x for place in places for x in place[k]]) for k in range(2))
    total = ca.jtimes(column(*positions), shifts, column(*forces), True) + gradient_by_rates(dissipation, rates)
    if spins:
        total += ca.jtimes(column(*spins), rates, column(*torques), True)
    found = scalars_in(ca.densify(ca.substitute([total], [shifts, rates], [ca.SX.zeros(shifts.numel())] * 2)[0]))
    size = kinematics.geometry.size
    on_frames = {name: found[size * k : size * (k + 1)] for k, name in enumerate(apart.frames)}
    return Forces(on_frames, dict(zip(apart.coordinates, found[size * len(on_frames) :], strict=True)))


def forces_of_loops(kinematics: Kinematics, rows: Sequence[Row]) -> list[Forces | None]:
    """What each row asks for at a multiplier of 1: the forces on the frames that a closure joins. None for other rows."""
    names = dict.fromkeys(name for row in rows if row.loop for name in (row.loop.a, row.loop.b))
    size = kinematics.geometry.size
    new = kinematics.algebra.index.displacements.new
    shifts, rates = ({name: new(size, f"{kind}_{name}") for name in names} for kind in ("shift", "rate"))
    apart = kinematics.displaced({}, {name: (shifts[name], rates[name]) for name in names})
    moving = column(*rates.values())
    still, zeros = [column(*shifts.values()), moving, kinematics.symbols.tau], ca.SX.zeros(moving.numel())
    ends = [dict.fromkeys((row.loop.a, row.loop.b)) if row.loop else {} for row in rows]
    gradients = [ca.gradient(ca.SX(row.rate(apart)), column(*[rates[name] for name in frames]))
                 for row, frames in zip(rows, ends, strict=True) if frames]
    found = ca.substitute(gradients, still, [zeros, zeros, ca.SX(1)]) if gradients else []
    forces = iter([map(scalars_in, ca.vertsplit(ca.densify(force), size)) for force in found])
    return [Forces(dict(zip(frames, next(forces), strict=True)), {}) if frames else None for frames in ends]


def _movable(kinematics: Kinematics) -> frozenset[str]:
    """The frames that coordinates move."""
    free, graph = kinematics.symbols.positions, kinematics.graph
    moving = {root.frame for root in graph.roots if any(f"{root.frame}.{a}" in free for a in root.attributes)}
    for edge in graph.edges:
        if edge.parent in moving or any(name in free for name in edge.coordinates):
            moving.add(edge.child)
    return frozenset(moving)
