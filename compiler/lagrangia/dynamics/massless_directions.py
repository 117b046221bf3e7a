"""Kinematics, constraints and energies -> ways of moving that move no mass, one of several coordinates each.

Two joints in series with nothing on the frame between them share their rates: T depends on their sum alone. Such a way z is a
vector with M z = 0 and J z = 0 at all positions, and is looked for in numbers, at general ones. Where its entries depend on
parameters (a massless differential gear), they follow from M z = 0 as expressions of these.
"""

from collections.abc import Collection, Sequence
from typing import NoReturn

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import Vector, general_numbers, independent_columns
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import usual_parameters
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.energies import Energies
from lagrangia.frames.graph import Coordinate
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.frame_attributes import component_named

_MOST = 60  # coordinates of scenes whose M is looked at as a whole
_LOOKS = 3  # general positions
_SINGULAR = 1e-14  # singular values, times the number of coordinates, of M with a diagonal of 1 and of rows of length 1
_SAME = 1e-9


@dataclass(frozen=True)
class Direction:
    """Coordinates that move together without mass, by how much each as an expression of the parameters: of the first, 1."""

    coordinate: Coordinate
    factors: tuple[tuple[str, ca.SX], ...]

    @staticmethod
    def of_one(coordinate: Coordinate) -> "Direction":
        """The coordinate alone."""
        return Direction(coordinate, ((coordinate.name, ca.SX(1)),))

    @property
    def told(self) -> str:
        """In words, before "and ..."."""
        with_it = ", ".join(f"{name} by {factor} of it" for name, factor in self.factors[1:])
        together = f" where it takes others with it ({with_it})" if with_it else ""
        return f"the coordinate '{self.coordinate.name}' moves no mass{together}"


def numbers_at(kinematics: Kinematics, expressions: list[ca.SX], seed: int = 1) -> list[Vector]:
    """At a general state, with parameters beside the declared ones; rates of either sign."""
    expressions, (p, numbers) = kinematics.unturned(expressions), usual_parameters(kinematics)
    known = symbols_in(p) if p.numel() else frozenset()
    free = [x for x in ca.symvar(ca.veccat(*expressions)) if x.__hash__() not in known]
    random, rates = np.random.default_rng(seed), {x.__hash__() for x in kinematics.symbols.rates.values()}
    values = random.uniform(0.4, 1.6, len(free)) * [random.choice((-1, 1)) if x.__hash__() in rates else 1 for x in free]
    found = ca.Function("numbers", [p, ca.vertcat(ca.SX(0, 1), *free)], [ca.densify(x) for x in expressions])(numbers, values)
    return [np.array(x) for x in (found if len(expressions) > 1 else [found])]


def shared_directions(kinematics: Kinematics, constraints: Constraints, energies: Energies, settled: Collection[str]
                      ) -> list[Direction]:
    """Those of several coordinates, in scenes of up to 60, without the coordinates that are `settled` by themselves.

    Raises LagError L0504 where others move no mass along ways that depend on where they are.
    """
    names = [name for name in kinematics.symbols.positions if name not in settled]
    if not 1 < len(names) <= _MOST:
        return []
    looks = _Looks(kinematics, constraints, energies, names)
    if looks.is_regular():
        return []
    here, elsewhere = looks.directions(0), looks.directions(1)
    if len(here) != len(elsewhere):
        return []
    coordinates, directions = {c.name: c for c in kinematics.graph.coordinates}, []
    for z in here:
        refuse_attitudes([(coordinates[names[k]], float(z[k])) for k in np.flatnonzero(np.abs(z) > _SAME)])
    if loose := looks.loose(len(here)):
        fail("L0504", f"the coordinates {', '.join(names[k] for k in loose)} move no mass together, along a way that depends on "
             "where they are (not supported yet)", coordinates[names[loose[0]]].span, "give what lies between them a small mass")
    for z, other in zip(here, elsewhere, strict=True):
        places = [k for k in range(len(names)) if abs(z[k]) > _SAME]
        is_fixed = np.abs(other - z).max() <= _SAME
        factors = [ca.SX(1), *([ca.SX(round(z[k], 9)) for k in places[1:]] if is_fixed else looks.by_parameters(places))]
        directions.append(Direction(coordinates[names[places[0]]], tuple(zip((names[k] for k in places), factors, strict=True))))
    return directions


def refuse_attitudes(moving: Sequence[tuple[Coordinate, float]]) -> None:
    """Raises LagError L0504 for what moves no mass and turns an attitude; `moving`: coordinates, and how much each does."""
    turned = next((c for c, _ in moving if c.attitude), None)
    if turned is None:
        return
    axis = [sum(x for c, x in moving if c.attitude == turned.attitude and c.part == k) for k in (1, 2, 3)]
    length = float(np.linalg.norm(axis))
    named = [f"its {letter} axis" for letter, x in zip("xyz", axis, strict=True) if abs(x) > (1 - _SAME) * length]
    about = named[0] if named else f"the axis {{{', '.join(f'{x / length:.4g}' for x in axis)}}} of its own"
    others = dict.fromkeys(c.attitude or c.name for c, _ in moving if c.attitude != turned.attitude)
    together = f", where it takes {', '.join(others)} with it" if others else ""
    fail("L0504", f"the attitude '{turned.attitude}' moves no mass about {about}{together}", turned.span,
         "give what it turns a moment of inertia about that axis: I = {Ixx, Iyy, Izz}")


def refuse_loose(kinematics: Kinematics, massless: Sequence[Coordinate]) -> NoReturn:
    """Raises LagError L0504 for coordinates that move no mass, and that nothing holds or pushes."""
    first, *others = massless
    beside = f" (nor do {', '.join(x.name for x in others[:3])})" if others else ""
    fail("L0504", f"the coordinate '{first.name}' moves no mass{beside}", first.span, _missing_port(kinematics, first.name))


def _missing_port(kinematics: Kinematics, coordinate: str) -> str:
    """Names the port of the coordinate's component that nobody joined to anything."""
    component = coordinate.rpartition(".")[0]
    ends = [edge.parent for edge in kinematics.graph.edges] + [edge.child for edge in kinematics.graph.edges]
    loose = [name for name in kinematics.graph.model.frames if name.startswith(component + ".") and ends.count(name) == 1]
    if loose:
        return f"'{loose[0]}' is joined to nothing: connect a body there"
    frame, _, name = coordinate.rpartition(".")
    if frame in kinematics.graph.model.frames and component_named(name).is_angle:
        return (f"what is placed beside '{frame}' (shift, turn) turns with it, and a mass point has no moment of inertia: make "
                "it a Disc or a Bar, shift the other port, or measure from the point: gap = p.center.y - 0.1[m]")
    turned = [edge.child for edge in kinematics.graph.edges
              if any(step.kind == "turn" and str(step.amount) == coordinate for step in edge.steps)]
    if turned:
        return ("give what it turns a moment of inertia about the axis, where a PointMass has none: a Disc, a Bar, or a "
                f"PointMass beside the axis, its center = shift({turned[0]}, ...)")
    return "give a body behind it a mass"


class _Looks:
    """M and J at general positions, in the columns of some coordinates."""

    def __init__(self, kinematics: Kinematics, constraints: Constraints, energies: Energies, names: Sequence[str]) -> None:
        self.v = ca.vertcat(*[kinematics.symbols.rates[name] for name in names])
        momentum = ca.densify(ca.gradient(energies.total(energies.kinetic), self.v))
        rates = ca.vertcat(ca.SX(0, 1), *[row.rate(kinematics) for row in constraints.rows])
        momentum, rates = kinematics.unturned([momentum, rates])
        self.p, self.numbers = usual_parameters(kinematics)
        changing = symbols_in(ca.vertcat(self.p, self.v))
        self.free = ca.vertcat(ca.SX(0, 1), *[x for x in ca.symvar(ca.vertcat(momentum, rates)) if x.__hash__() not in changing])
        self.momentum, self.n = momentum, len(names)
        attitudes = [c.attitude for name in names for c in kinematics.graph.coordinates if c.name == name]
        self.turning = [[k for k, x in enumerate(attitudes) if x == attitude] for attitude in {*attitudes} - {""}]
        self.slopes = ca.Function("slopes", [self.v, self.free, self.p], [ca.vertcat(momentum, rates)])

    def directions(self, which: int) -> list[Vector]:
        """Each as long as one coordinate alone would be, which no other one has; with one of two sets of parameters."""
        numbers = self.numbers * general_numbers(which, 0.8, 1.2, self.numbers.size)
        return _reduced(self._null_space(numbers, range(_LOOKS)))

    def is_regular(self) -> bool:
        """Whether nothing moves without mass at one position, so that nothing does at all."""
        return not self._null_space(self.numbers, [0]).size

    def loose(self, known: int) -> list[int]:
        """Coordinates of a way that is one at any position, behind so many that are the same at all; none where there is none."""
        ways = [self._null_space(self.numbers, [seed]) for seed in range(_LOOKS)]
        if min(map(len, ways)) <= known:
            return []
        return np.flatnonzero(np.abs(_reduced(ways[0])).max(axis=0) > _SAME).tolist()

    def _null_space(self, numbers: Vector, seeds: Sequence[int]) -> Vector:
        """In the rows, what all looks have in common: with M scaled to a diagonal of 1 and the rows of J to the length 1."""
        looks = [self._look(numbers, seed) for seed in seeds]
        lengths = np.sqrt(np.max([np.abs(np.diag(M)) for M, _ in looks], axis=0))
        lengths[lengths == 0] = 1.0
        rows = np.vstack([x for M, J in looks for x in (M / np.outer(lengths, lengths), J / lengths)])
        if not np.isfinite(rows).all():
            return np.zeros((0, self.n))
        norms = np.linalg.norm(rows, axis=1)
        _, sizes, ways = np.linalg.svd(rows / np.where(norms > 0, norms, 1)[:, None])
        return np.asarray(ways[int((sizes > _SINGULAR * self.n).sum()):] / lengths)

    def _look(self, numbers: Vector, seed: int) -> tuple[Vector, Vector]:
        """M, as differences of momenta, and J."""
        n, place = self.n, general_numbers(seed, 0.4, 1.6, self.free.numel())
        found = self.slopes(np.hstack([np.eye(n), -np.eye(n)]), place, numbers).full()
        A = (found[:, :n] - found[:, n:]) / 2
        M, diagonal = A[:n], np.abs(np.diag(A[:n]))
        for places in self.turning:  # about one of its axes it has rounding: its velocities are told in the world's axes
            idle = [k for k in places if diagonal[k] <= _SINGULAR * diagonal[places].max()]
            M[idle] = M[:, idle] = 0.0
        return M, A[n:]

    def by_parameters(self, places: list[int]) -> list[ca.SX]:
        """The entries of a direction behind the first, from M z = 0 at one state, which is as good as any."""
        known = general_numbers(2, 0.4, 1.6, self.free.numel())
        state, values = ca.vertcat(self.free, self.v), ca.SX([*known, *np.ones(self.n)])
        M = ca.substitute(ca.densify(ca.jacobian(self.momentum, self.v)), state, values)
        numbers = ca.evalf(ca.substitute(M, self.p, ca.SX(self.numbers))).full()
        rows = independent_columns(numbers[:, places[1:]].T, _SAME).tolist()
        return list(ca.solve(M[rows, places[1:]], -M[rows, places[0]]).elements())


def _reduced(ways: Vector) -> list[Vector]:
    """The reduced row echelon form, which is the same however a basis came out."""
    left, found = ways / np.abs(ways).max(axis=1, initial=0.0, keepdims=True), list[int]()
    for column in range(left.shape[1]):
        k = len(found)
        if k == len(left) or np.abs(left[k:, column]).max(initial=0.0) <= _SAME:
            continue
        best = k + int(np.abs(left[k:, column]).argmax())
        left[[k, best]] = left[[best, k]]
        left[k] /= left[k, column]
        left -= np.outer([0.0 if i == k else x for i, x in enumerate(left[:, column])], left[k])
        found.append(column)
    return list(left)
