"""Derivatives of slopes and outputs by time, states, inputs and parameters: along a direction, adjoint, and which are 0.

With F(t, q, v, u, p) = (dq/dt, dv/dt, y), p those parameters that can be set: forward F' s by CasADi's forward mode, adjoint
F'^T w by its reverse mode; both exact, each of a few times the cost of F. Those of closed loops are those of Model
Exchange (runtime/fmi/exchange.c) with two Newton corrections for the projection, which have the same derivatives there.

Axes of hinges that may be set lead to angles that no derivative has where an axis lies along another (dynamics/spatial_axes.py):
what follows from such parameters alone is left out of F' s where s does not go along one of them.

Where the scene has switches, d holds them (switches.py), and with them the shares of what a stop or friction holds: its rates
R(t, q, v, u, d, w, p), which are 0, give them; w are the rates of inputs, along which something may be held. With R as a third
result and directions of d the run time eliminates the shares (runtime/fmi/partial.c).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import casadi as ca

from lagrangia.algebra.scalars import places_in
from lagrangia.compile.functions import outputs_of, state_space
from lagrangia.compile.instructions import tape_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.compile.told_positions import told_positions
from lagrangia.constraints.parameters import all_parameters, default_parameters
from lagrangia.dynamics.delaying import find_delaying
from lagrangia.dynamics.held_motion import HeldMotion
from lagrangia.dynamics.impulses import bends_by_inputs
from lagrangia.dynamics.joint_loads import settled
from lagrangia.dynamics.switches import find_switches
from lagrangia.fmu.factors import DEPENDENT, factor_kinds
from lagrangia.frames.kinematics import Kinematics
from lagrangia.native.tapes import Tape

_CORRECTIONS = 2  # each leaves what E (dynamics/kkt.py) makes of it: 1e-5 in space, whose square is rounding of an importer


@dataclass(frozen=True)
class Derivatives:
    """forward: a state t, q, v, u, d, w, p and directions of all these -> those of the slopes, y, R; adjoint: a state and weights
    of the slopes, y, R -> gradients by all of the state. Without switches nothing is along d and w, and there is no R.

    `rows`: for each of dq/dt, dv/dt and y the columns, of t, q, v, u, p, that it depends on, and how (factors.py);
    `parameter_rows`: for each parameter those that can be set, by their number among these, that it follows from, and how."""

    forward: Tape
    adjoint: Tape
    rows: tuple[Mapping[int, str], ...]
    parameter_rows: tuple[Mapping[int, str], ...]


def build_derivatives(
    compilation: Compilation, outputs: tuple[str, ...], settable: Sequence[bool], stabilisation: float, start: Sequence[float]
) -> Derivatives:
    """The derivatives of slopes, outputs and held rates by all that an importer can set; `stabilisation` in 1/s, `start`: the
    values of the parameters."""
    kinematics, (t, q, v, u, d, p), (slope, y, rates, shares, rests, w) = _equations(compilation, outputs, stabilisation)
    given, mask, values = all_parameters(kinematics, p.numel())
    values = ca.densify(ca.substitute(values, mask, ca.DM([float(x) for x in settable]))) if p.numel() else ca.SX(0, 1)
    slope, y, rates = ca.substitute([slope, y, rates], [p], [values]) if p.numel() else (slope, y, rates)
    d = ca.vertcat(d, shares)
    along_d = d if shares.numel() else ca.SX(0, 1)
    kinked = _kinked(ca.vertcat(slope, y), given, start)
    state = [t, q, v, u, ca.vertcat(d, rests), w, given]
    forward, adjoint = _both([t, q, v, u, along_d, w, given], [slope, y, rates], state, kinked)
    free = [k for k, is_free in enumerate(settable) if is_free]
    chosen = given[free] if free else ca.SX(0, 1)
    n_inputs = u.numel() - len(compilation.flat.delays)  # delayed values come behind them, and nobody sets these
    inputs, late = ca.vertsplit(u, [0, n_inputs, u.numel()])
    followed = rates + ca.jtimes(rates, w, u) if w.numel() else rates  # what is held at an input goes with it
    moving = ca.vertcat(t, q, v, inputs)
    rows = _kinds_with_shares(ca.vertcat(slope, y), followed, moving, ca.vertcat(d, rests, late), given, shares)
    kinds = factor_kinds(values, [], chosen)
    parameter_rows = [{k: own.kind(k) for k in row} for row, own in zip(_rows(values, chosen), kinds, strict=True)]
    return Derivatives(tape_of(forward), tape_of(adjoint), rows, tuple(parameter_rows))


def _equations(compilation: Compilation, outputs: tuple[str, ...],
               stabilisation: float) -> tuple[Kinematics, list[ca.SX], list[ca.SX]]:
    """The symbols t, q, v, u, d, p; slopes, y and R in terms of them, of switches and shares, of what is said of rest, and of
    rates of inputs, which come last."""
    kinematics, motion = compilation.struck, compilation.run
    made = motion.unsolved or motion
    symbols, (a, _, place, steer) = state_space(kinematics, made, compilation.constraints, ())
    _, y, put = outputs_of(kinematics, made, compilation.constraints, outputs)
    t, q, v, *given = symbols
    told = told_positions(kinematics)
    switches = find_switches(motion, find_delaying(kinematics).values, bends_by_inputs(kinematics))
    moving, held = HeldMotion(motion, switches, default_parameters(kinematics)[1]), made.constrained
    multipliers, rows = (held.multipliers, held.rows.rate) if held else (ca.SX(0, 1), ca.SX(0, 1))
    found = settled(motion, switches, {"rows": moving.rows([a, multipliers], rows, v), "y": [moving.outputs(y, put)],
                                       "switches": [switches.values, switches.rates]})
    (a, multipliers), (y,), (_, rates) = found["rows"], found["y"], found["switches"]
    y = ca.densify(ca.substitute(y, ca.vertcat(motion.a, held.symbols if held else ca.SX(0, 1)), ca.vertcat(a, multipliers)))
    shares = ca.vertcat(switches.symbols, motion.impacts.impulses) if switches.symbols.numel() else ca.SX(0, 1)
    (rates,) = ca.substitute([rates], [motion.a], [a])
    Q, V = q, v
    if motion.constrained is not None:
        for _ in range(_CORRECTIONS):
            Q += ca.substitute(place, q, Q)
        for _ in range(_CORRECTIONS):
            V += ca.substitute(steer, ca.vertcat(q, v), ca.vertcat(Q, V))
        a, y, rates = ca.substitute([a, y, rates], [q, v], [Q, V])
    here = told.of(Q)
    slope = ca.vertcat(told.pace(here, V), a)
    if motion.constrained is not None or told.quaternions:
        slope += stabilisation * (ca.vertcat(here, V) - ca.vertcat(told.q, v))
    slope, y, rates = told.put(kinematics.algebra.by_inputs([slope, y, rates], switches.slopes))
    return kinematics, [t, told.q, v, *given], [slope, y, rates, shares, switches.rest_symbols, switches.slopes]


def _kinked(whole: ca.SX, p: ca.SX, start: Sequence[float]) -> list[int]:
    """The parameters by which something that follows from parameters alone has no derivative at these values."""
    _, _, parts = ca.extract_parametric(whole, p)
    if not parts:
        return []
    slopes = ca.jacobian(ca.vertcat(*parts), p)
    _, columns = slopes.sparsity().get_triplet()
    values = ca.Function("slopes", [p], [slopes])(start).nonzeros()
    return sorted({column for column, value in zip(columns, values, strict=True) if not math.isfinite(value)})


def _along_kinked(whole: ca.SX, p: ca.SX, x: ca.SX, seed: ca.SX, kinked: list[int]) -> ca.SX:
    """Along `seed` of x, whose last entries are p."""
    rest, symbols, parts = ca.extract_parametric(whole, p)
    unknown, known, s = ca.vertcat(*symbols), ca.vertcat(*parts), seed[x.numel() - p.numel() :]
    even = [k for k in range(p.numel()) if k not in kinked]
    goes_along = ca.sumsqr(s[kinked])
    ways = _product(known, p[even], s[even], False) + ca.vertcat(*[
        ca.SX.binary(ca.OP_IF_ELSE_ZERO, goes_along, way) for way in _product(known, p[kinked], s[kinked], False).elements()])
    return ca.substitute(_product(rest, ca.vertcat(x, unknown), ca.vertcat(seed, ways), False), unknown, known)


def _both(knowns: list[ca.SX], unknowns: list[ca.SX], state: list[ca.SX],
          kinked: list[int]) -> tuple[ca.Function, ca.Function]:
    """The last of the knowns are parameters."""
    x, whole = ca.vertcat(*knowns), ca.vertcat(*unknowns)
    seeds = [ca.SX.sym(f"s{k}", known.numel()) for k, known in enumerate(knowns)]
    along = (_along_kinked(whole, knowns[-1], x, ca.vertcat(*seeds), kinked) if kinked else
             _product(whole, x, ca.vertcat(*seeds), False))
    weights = [ca.SX.sym(f"w{k}", unknown.numel()) for k, unknown in enumerate(unknowns)]
    back = _product(whole, x, ca.vertcat(*weights), True)
    return (ca.Function("forward", [*state, *seeds], _parted(along, unknowns)),
            ca.Function("adjoint", [*state, *weights], _parted(back, knowns)))


def _parted(column: ca.SX, like: list[ca.SX]) -> list[ca.SX]:
    ends = list(accumulate((part.numel() for part in like), initial=0))
    return [column[i:j] for i, j in pairwise(ends)]


def _kinds_with_shares(unknowns: ca.SX, rates: ca.SX, moving: ca.SX, d: ca.SX, p: ca.SX,
                       shares: ca.SX) -> tuple[dict[int, str], ...]:
    """While something is held, what depends on its share depends on all that shares follow from, in no way that is known."""
    n, x = int(moving.numel()), ca.vertcat(moving, p)
    on_shares, of_rates = _rows(unknowns, shares), _rows(rates, shares)
    held = {k for row, found in zip(_rows(rates, x), of_rates, strict=True) if found for k in row}
    known = {k for found in of_rates for k in found}
    rows = []
    for own, row, found in zip(factor_kinds(unknowns, [moving, d], p), _rows(unknowns, x), on_shares, strict=True):
        kinds = {k: own.kind(k) if k < n else own.kind_of_parameter(k - n) for k in row}
        rows.append(dict(sorted((kinds | (dict.fromkeys(held, DEPENDENT) if known & {*found} else {})).items())))
    return tuple(rows)


def _product(unknowns: ca.SX, x: ca.SX, seed: ca.SX, transposed: bool) -> ca.SX:
    size = x.numel() if transposed else unknowns.numel()
    if unknowns.numel() == 0:
        return ca.SX.zeros(size, 1)
    return ca.densify(ca.jtimes(unknowns, x, seed, transposed))


def _rows(unknowns: ca.SX, knowns: ca.SX) -> tuple[tuple[int, ...], ...]:
    return tuple(tuple(sorted(row)) for row in places_in(unknowns, knowns))
