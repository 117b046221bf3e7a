"""Constraints that only just hold, such as a rod exactly as long as the way can be: where Phi vanishes, so do its slopes.

Phi = 0 is a double root there, wherever the scene moves: it has no multiplier, though the motion is well posed. Its place is
taken by its slopes, which vanish with it and are independent. Of one equation these are dPhi/dq_k = 0; of two of a loop, whose
slopes are all along t = dPhi/dq_c, they are t . Phi = 0 and t x dPhi/dq_k = 0. What second order leaves of motion tells whether
that is so. Source: deflation (A. Leykin, J. Verschelde, A. Zhao, Theoretical Computer Science 359, 2006, 111).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.orthogonal import Vector, general_numbers, independent_columns
from lagrangia.algebra.pointers import Pointer
from lagrangia.algebra.scalars import symbols_in
from lagrangia.constraints.assembly import assembled
from lagrangia.constraints.initial import InitialConditions, build_initial
from lagrangia.constraints.parameters import at_declared_values, parameter_symbols
from lagrangia.constraints.positions import Positions
from lagrangia.constraints.rows import Constraints, Row, derived
from lagrangia.constraints.vanishing_sums import split_vanishing_sums
from lagrangia.dynamics.equilibrium import StaticEquations, ways_at
from lagrangia.frames.kinematics import Kinematics

_DEPENDENT = 1e-4  # of normalised rows: a double root is known to half the digits
_MOST = 40  # coordinates of scenes that are looked at
_ASIDE = 0.1
_NOTHING = 1e-300
Build = Callable[[Kinematics], ca.SX]


def static_constraints(kinematics: Kinematics, phi: ca.SX, J: ca.SX) -> StaticEquations:
    """The constraints alone, without forces, with the parameters as declared."""
    q = ca.vertcat(*kinematics.symbols.positions.values())
    lam = ca.SX.sym("lambda", J.shape[0])
    phi, J = (ca.densify(x) for x in at_declared_values(kinematics, [phi, J]))
    bent = ca.jacobian(ca.jtimes(phi, q, lam[: phi.numel()], True), q) if phi.numel() else ca.SX(q.numel(), q.numel())
    gaps = Pointer(ca.Function("gaps", [q], [phi]))
    slopes = Pointer(ca.Function("slopes", [q, lam], [ca.densify(bent), ca.densify(ca.jacobian(phi, q)), J]))
    nothing, ones = np.zeros(q.numel()), np.ones(q.numel())

    def stiffness(x: Vector, multipliers: Vector) -> tuple[Vector, Vector, Vector]:
        K, own, rows = slopes.matrices(x, multipliers if multipliers.size else 0)
        return K, own, rows

    return StaticEquations(lambda x: (nothing, gaps(x), 0.0), stiffness, ones, np.full(q.numel(), False))


def lift_double_roots(kinematics: Kinematics, constraints: Constraints, initial: InitialConditions) -> Constraints | None:
    """The constraints with slopes in place of what only just holds at the start, and with the parts of sums that are nowhere
    negative where these are to vanish; None where nothing does."""
    split = split_vanishing_sums(kinematics, constraints)
    if split is None:
        return _lift(kinematics, constraints, initial)
    return _lift(kinematics, split, build_initial(kinematics, split)) or split


def _lift(kinematics: Kinematics, constraints: Constraints, initial: InitialConditions) -> Constraints | None:
    rows, n = constraints.rows, len(kinematics.symbols.positions)
    if not rows or n > _MOST or not all(row.is_holonomic for row in rows) or kinematics.algebra.modes:
        return None
    q = ca.vertcat(*kinematics.symbols.positions.values())
    phi = ca.vertcat(*[row.value(kinematics, 0) for row in rows])
    J = ca.jacobian(phi, q)
    start, failed = assembled(kinematics, initial)
    place, positions = start[:n], Positions(kinematics, phi, J)
    if failed >= 0 or not (touching := _touching(rows, _normalised(positions, place))):
        return None
    ways = ways_at(static_constraints(kinematics, phi, J), place)
    if ways is None or ways.is_open or len(ways.planes) > 1:
        return None
    freedom = ways.planes[0].shape[1] if ways.planes else 0
    lifted = _replace(kinematics, constraints, touching, positions.slopes(place))
    kept = _independent(kinematics, lifted, place, len(rows) - sum(map(len, touching)))
    if kept is None or len(kept) != n - freedom:
        return None
    return replace(lifted, rows=tuple(lifted.rows[k] for k in kept))


def touching_notes(kinematics: Kinematics, constraints: Constraints) -> dict[str, object]:
    """As plain data, for a scene that is kept: the constraints that only just hold, and the places of parameters in them."""
    places = list[int]()
    if constraints.touching:
        mentioned = symbols_in(ca.vertcat(*[row.value(kinematics, 0) for row in constraints.touching]))
        places = [k for k, x in enumerate(parameter_symbols(kinematics).elements()) if x.__hash__() in mentioned]
    return {"touching": {"told": list(dict.fromkeys(row.told for row in constraints.touching)), "parameters": places}}


def _normalised(positions: Positions, q: Vector) -> Vector:
    """The slopes of the rows (m, n), each by its size here or a little aside, where those that vanish here do not."""
    aside = q + _ASIDE * general_numbers(4, -1, 1, q.size)
    here, there = positions.slopes(q), positions.slopes(aside)
    return np.asarray(here / np.maximum(np.linalg.norm(np.vstack([[here], [there]]), axis=2).max(axis=0), _NOTHING)[:, None])


def _touching(rows: Sequence[Row], J: Vector) -> list[tuple[int, ...]]:
    """Rows without slopes, and pairs of rows of one loop whose slopes are parallel."""
    found = [(k,) for k in range(len(rows)) if np.linalg.norm(J[k]) < _DEPENDENT]
    single = {k for (k,) in found}
    loops: dict[int, list[int]] = {}
    for k, row in enumerate(rows):
        if row.loop is not None and row.loop.kind == "hinge" and k not in single:
            loops.setdefault(id(row.loop), []).append(k)
    pairs = [(a, b) for a, b in (x for x in loops.values() if len(x) == 2)
             if np.linalg.svd(J[[a, b]], compute_uv=False)[-1] < _DEPENDENT]
    return [*found, *pairs]


def _replace(kinematics: Kinematics, constraints: Constraints, touching: list[tuple[int, ...]], J: Vector) -> Constraints:
    """Slopes in place of what touches, one for each coordinate."""
    gone = {k for group in touching for k in group}
    kept = [row for k, row in enumerate(constraints.rows) if k not in gone]
    held = [constraints.rows[k] for k in sorted(gone)]
    slopes = [row for group in touching for row in _slopes([constraints.rows[k] for k in group], J[list(group)])]
    agreements = tuple((ca.SX(row.value(kinematics, 0)), row) for row in held)
    return replace(constraints, rows=(*kept, *slopes), touching=(*constraints.touching, *held),
                   agreements=(*constraints.agreements, *agreements))


def _slopes(group: list[Row], J: Vector) -> list[Row]:
    places = range(J.shape[1])
    if len(group) == 1:
        builds: list[Build] = [partial(_slope, group[0], k) for k in places]
    else:
        along = int(np.argmax(np.linalg.norm(J, axis=0)))
        builds = [partial(_along, group, along), *(partial(_across, group, along, k) for k in places if k != along)]
    return [Row(partial(_value, build), True, None, group[0].span, i, is_timed=any(row.is_timed for row in group))
            for i, build in enumerate(builds)]


def _column(kinematics: Kinematics, row: Row, k: int) -> ca.SX:
    return ca.jacobian(ca.SX(row.value(kinematics, 0)), list(kinematics.symbols.positions.values())[k])


def _slope(row: Row, k: int, kinematics: Kinematics) -> ca.SX:
    return _column(kinematics, row, k)


def _along(group: list[Row], along: int, kinematics: Kinematics) -> ca.SX:
    return sum((_column(kinematics, row, along) * row.value(kinematics, 0) for row in group), start=ca.SX(0))


def _across(group: list[Row], along: int, k: int, kinematics: Kinematics) -> ca.SX:
    a, b = group
    return (_column(kinematics, a, along) * _column(kinematics, b, k) - _column(kinematics, b, along) * _column(kinematics, a, k))


def _value(build: Build, kinematics: Kinematics, level: int) -> Scalar:
    return derived(build(kinematics), kinematics, level)


def _independent(kinematics: Kinematics, lifted: Constraints, q: Vector, n_kept: int) -> list[int] | None:
    """The rows that were there before, `n_kept`, and as many of the others as are independent of them; None where the former are
    not independent themselves."""
    phi = ca.vertcat(*[row.value(kinematics, 0) for row in lifted.rows])
    J = Positions(kinematics, phi, ca.jacobian(phi, ca.vertcat(*kinematics.symbols.positions.values()))).slopes(q)
    sizes = np.linalg.norm(J, axis=1)
    J = J / np.maximum(sizes, _DEPENDENT * sizes.max())[:, None]
    basis = np.linalg.qr(J[:n_kept].T)[0] if n_kept else np.zeros((q.size, 0))
    if n_kept and independent_columns(J[:n_kept].T, _DEPENDENT).size < n_kept:
        return None
    rest = J[n_kept:] - J[n_kept:] @ basis @ basis.T
    return [*range(n_kept), *sorted(n_kept + int(k) for k in independent_columns(rest.T, _DEPENDENT))]
