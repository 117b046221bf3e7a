"""Coordinates that a loop in space does not feel, but for rounding.

Two joints along one axis of many digits, or put together by frames that are turned, have axes that differ in their last digits:
then an equation that says nothing about a coordinate has it 1e-17 times. Solved for that coordinate it would say where this is,
and measured by its own slopes rounding would be a way to go.
"""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.algebra.orthogonal import Vector, general_numbers
from lagrangia.frames.kinematics import Kinematics

_SUSPECTED = 1e-12  # of slopes, beside the largest one: looked at again, as one steep law dwarfs all others
_ROUNDING = 1e-14  # of each operation, and of numbers that are made of those of about 1
_PLACES, _TIMES = 2, 8


def find_unfelt(kinematics: Kinematics, gaps: ca.SX, rates: ca.SX) -> list[tuple[str, ...]]:
    """Of each gap, (m,), with its rate: the coordinates by which neither changes, nor the rate with theirs, at places in general
    and with parameters in general. Of rates (0,) the gaps alone."""
    symbols = kinematics.symbols
    q, v = (ca.vertcat(*x.values()) for x in (symbols.positions, symbols.rates))
    slopes = [ca.jacobian(gaps, q), *([ca.jacobian(rates, v), ca.jacobian(rates, q)] if rates.numel() else [])]
    mentioned = sum((x.sparsity() for x in slopes[1:]), slopes[0].sparsity())
    entries = ca.horzcat(*[ca.vertcat(ca.SX(0, 1), *ca.project(x, mentioned).nonzeros()) for x in slopes])
    inner = ca.symvar(entries)
    places = np.array([general_numbers(1 + k, 0.3, 1.7, len(inner)) for k in range(_PLACES)]).reshape(_PLACES, len(inner))
    sizes = ca.Function("sizes", [ca.vertcat(ca.SX(0, 1), *inner)], [entries])
    found = np.abs(np.hstack([sizes(place).full() for place in places]))
    largest = np.max(found, initial=0.0, where=np.isfinite(found))
    suspected = [k for k, size in enumerate(found.max(axis=1, initial=0.0)) if size <= _SUSPECTED * largest]
    names, unfelt = list(symbols.positions), [list[str]() for _ in range(gaps.numel())]
    rows, columns = mentioned.get_triplet()
    for k, is_rounding in zip(suspected, _are_rounding(entries[suspected, :], inner, places), strict=True):
        if is_rounding:
            unfelt[rows[k]].append(names[columns[k]])
    return [tuple(row) for row in unfelt]


def _are_rounding(entries: ca.SX, inner: list[ca.SX], places: Vector) -> list[bool]:
    """Of each row, (m, k): whether all it says at these places, (n, inner), is what its operations round."""
    if not entries.size1():
        return []
    function = ca.Function("entries", [ca.vertcat(ca.SX(0, 1), *inner)], [ca.densify(entries)])
    found = _rounded_at_random(function, places).reshape(_PLACES, _TIMES, entries.size2(), entries.size1())
    is_rounding = np.abs(found.mean(axis=1)) <= 3 * found.std(axis=1)
    return [bool(x) for x in is_rounding.all(axis=(0, 1))]


def _rounded_at_random(function: ca.Function, places: Vector) -> Vector:
    """What it gives, (places * _TIMES, entries), where each operation rounds at random."""
    at, count = np.repeat(places, _TIMES, axis=0), _PLACES * _TIMES
    noise = np.random.default_rng(1)
    values, results = dict[int, Vector](), np.zeros((count, function.numel_out()))
    for k in range(function.n_instructions()):
        op, read, written = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            values[written[0]] = at[:, read[1]]
        elif op == ca.OP_OUTPUT:
            results[:, written[1]] = values[read[0]]
        elif op == ca.OP_CONST:
            number = float(function.instruction_constant(k))
            own = 0.0 if number.is_integer() else max(1.0, abs(number))
            values[written[0]] = number + own * _ROUNDING * noise.uniform(-1, 1, count)
        elif op == ca.OP_CALL:  # looked up in a table: something in general
            values |= {place: np.full(count, noise.uniform(0.3, 1.7)) for place in written}
        else:
            operands = [ca.DM(values[x]) for x in read]
            value = ca.DM.unary(op, *operands) if len(operands) == 1 else ca.DM.binary(op, *operands)
            values[written[0]] = value.full().ravel() * (1 + _ROUNDING * noise.uniform(-1, 1, count))
    return results


def without_unfelt(kinematics: Kinematics, value: Scalar, unfelt: Sequence[str]) -> Scalar:
    """Of a gap at some level, where those coordinates are 0 and stay so."""
    symbols = kinematics.symbols
    motion = [x[name] for x in (symbols.positions, symbols.rates, symbols.accelerations) for name in unfelt if name in x]
    return _at_rest(value, [x for x in motion if isinstance(x, ca.SX)])


def _at_rest(value: Scalar, motion: list[ca.SX]) -> Scalar:
    if isinstance(value, Dual):
        return Dual(_at_rest(value.value, motion), _at_rest(value.rate, motion))
    return ca.substitute([value], motion, [ca.SX(0)] * len(motion))[0] if isinstance(value, ca.SX) and motion else value
