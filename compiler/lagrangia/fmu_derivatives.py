"""Derivatives of slopes and outputs by time, states, inputs and parameters: along a direction, adjoint, and which are 0.

With F(t, q, v, u, p) = (dq/dt, dv/dt, y), p those parameters that can be set: forward F' s by CasADi's forward mode, adjoint
F'^T w by its reverse mode; both exact, each of a few times the cost of F. Constrained slopes are those of Model Exchange
(runtime/fmi/exchange.c) with one Newton correction for the projection, which has the same derivatives on the constraints.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi as ca

from lagrangia.functions import state_space
from lagrangia.instructions import tape_of
from lagrangia.parameters import all_parameters
from lagrangia.pipeline import Compilation
from lagrangia.tapes import Tape


@dataclass(frozen=True)
class Derivatives:
    """`rows`: for each of dq/dt, dv/dt and y the columns, of t, q, v, u, p, that it depends on; `parameter_rows`: for each
    parameter those that can be set, by their number among these, that it follows from."""

    forward: Tape
    adjoint: Tape
    rows: tuple[tuple[int, ...], ...]
    parameter_rows: tuple[tuple[int, ...], ...]


def build_derivatives(
    compilation: Compilation, outputs: tuple[str, ...], settable: Sequence[bool], stabilisation: float
) -> Derivatives:
    symbols, (a, y, place, steer) = state_space(compilation.kinematics, compilation.motion, compilation.constraints, outputs)
    t, q, v, u, d, p = symbols
    slope = ca.vertcat(v, a)
    if compilation.motion.constrained is not None:
        Q = q + place
        V = v + ca.substitute(steer, q, Q)
        on = ca.vertcat(V, ca.substitute([a], [q, v], [Q, V])[0])
        slope = on + stabilisation * (ca.vertcat(Q, V) - ca.vertcat(q, v))
    given, mask, values = all_parameters(compilation.kinematics, p.numel())
    values = ca.densify(ca.substitute(values, mask, ca.DM([float(x) for x in settable]))) if p.numel() else ca.SX(0, 1)
    slope, y = ca.substitute([slope, y], [p], [values]) if p.numel() else (slope, y)
    knowns, unknowns = [t, q, v, u, given], ca.vertcat(slope, y)
    x = ca.vertcat(*knowns)
    state = [t, q, v, u, d, given]
    seeds = [ca.SX.sym(f"s{k}", known.numel()) for k, known in enumerate(knowns)]
    along = _product(unknowns, x, ca.vertcat(*seeds), False)
    forward = ca.Function("forward", [*state, *seeds], [along[: slope.numel()], along[slope.numel() :]])
    weights = [ca.SX.sym("wx", slope.numel()), ca.SX.sym("wy", y.numel())]
    back = _product(unknowns, x, ca.vertcat(*weights), True)
    sizes = [0]
    for known in knowns:
        sizes.append(sizes[-1] + known.numel())
    gradients = [back[i:j] for i, j in pairwise(sizes)]
    adjoint = ca.Function("adjoint", [*state, *weights], gradients)
    free = [k for k, is_free in enumerate(settable) if is_free]
    chosen = given[free] if free else ca.SX(0, 1)
    return Derivatives(tape_of(forward), tape_of(adjoint), _rows(unknowns, x), _rows(values, chosen))


def _product(unknowns: ca.SX, x: ca.SX, seed: ca.SX, transposed: bool) -> ca.SX:
    size = x.numel() if transposed else unknowns.numel()
    if unknowns.numel() == 0:
        return ca.SX.zeros(size, 1)
    return ca.densify(ca.jtimes(unknowns, x, seed, transposed))


def _rows(unknowns: ca.SX, knowns: ca.SX) -> tuple[tuple[int, ...], ...]:
    count = int(unknowns.numel())
    if count == 0 or knowns.numel() == 0:
        return ((),) * count
    sparsity = ca.jacobian_sparsity(unknowns, knowns)
    rows: list[list[int]] = [[] for _ in range(count)]
    for row, column in zip(*sparsity.get_triplet(), strict=True):
        rows[row].append(column)
    return tuple(tuple(sorted(row)) for row in rows)
