"""Levels -> simpler ones of the same sign, which have a slope where they change: x of x^3, x*abs(x), 2*sinh(x), tanh(1000*x)."""

from collections.abc import Iterator
from math import atan, inf, isfinite

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import as_expression

_ODD = frozenset({ca.OP_SINH, ca.OP_ASINH, ca.OP_TANH, ca.OP_ATANH, ca.OP_ATAN, ca.OP_ASIN, ca.OP_ERF})  # that also rise
_RISING = _ODD | {ca.OP_EXP, ca.OP_EXPM1, ca.OP_LOG1P}
_BACK = {ca.OP_SINH: np.arcsinh, ca.OP_ASINH: np.sinh, ca.OP_TANH: np.arctanh, ca.OP_ATAN: np.tan, ca.OP_EXP: np.log}
_WITHIN = {ca.OP_SINH: inf, ca.OP_ASINH: inf, ca.OP_TANH: 1.0, ca.OP_ATAN: atan(inf), ca.OP_EXP: inf}
_SAME = 1e-9  # of a factor, at other places and times
_Factor = tuple[ca.SX, bool, bool]  # it, whether its sign counts, whether it is below


def crossing_of(level: ca.SX, moving: ca.SX) -> ca.SX:
    """What is positive, 0 and negative where `level` is, which rises with it; `level` itself where nothing is simpler, or where
    that is it but for a factor that nothing in `moving` changes."""
    found = _simple(level)
    if found is level:
        return level
    symbols, random = ca.vertcat(ca.SX(0, 1), *ca.symvar(level)), np.random.default_rng(8)
    moves = np.array([ca.depends_on(moving, x) for x in symbols.elements()], dtype=bool)
    ratio = ca.Function("ratio", [symbols], [level / found])
    state = random.uniform(0.4, 1.6, symbols.numel())
    there = np.where(moves, random.uniform(0.4, 1.6, symbols.numel()), state)
    here, beside = float(ratio(state)), float(ratio(there))
    return level if abs(here - beside) <= _SAME * abs(here) else found


def _simple(level: ca.SX) -> ca.SX:
    found = _stripped(level)
    return level if found is None else found


def _stripped(d: ca.SX) -> ca.SX | None:
    """None where nothing is taken off; factors that are numbers are not, alone."""
    parts = [d.dep(k) for k in range(d.n_dep())]
    if d.op() in _RISING - {ca.OP_EXP}:
        return _simple(parts[0])
    if d.op() in (ca.OP_ADD, ca.OP_SUB):
        inner = _compared(d.op(), *parts)
        return None if inner is None else _simple(as_expression(inner))
    factors = [*_factors(d, False)]
    return None if factors[0][0].element_hash() == d.element_hash() else _product(factors)


def _compared(op: int, a: ca.SX, b: ca.SX) -> ca.SX | None:
    """Of f(x) - f(y), f(x) + f(y), and f(x) and a number."""
    sign = -1 if op == ca.OP_SUB else 1
    if a.op() == b.op() and a.op() in _ODD | ({ca.OP_EXP} if sign < 0 else set()):
        return a.dep(0) + sign * b.dep(0)
    for f, c, back in ((a, b, 1), (b, a, sign)):
        if c.is_constant() and f.op() in _BACK:
            value = -sign * float(c) if f is a else -float(c) / sign
            is_within = abs(value) < _WITHIN[f.op()] and (f.op() != ca.OP_EXP or value > 0)
            if is_within and isfinite(place := float(_BACK[f.op()](value))):
                return back * (f.dep(0) - place)
    return None


def _product(factors: list[_Factor]) -> ca.SX | None:
    """One whose factors are there once; None where that is nothing new."""
    numbering, kept, sign, is_new = Numbering(), dict[int, tuple[ca.SX, bool, bool]](), 1.0, False
    for base, is_odd, is_below in factors:
        if base.is_constant():
            sign *= (float(base) or 0.0) if is_odd else 1.0
            continue
        number = numbering.number(base)
        is_new |= number in kept
        _, was_odd, was_below = kept.get(number, (base, False, True))
        kept[number] = base, is_odd != was_odd, is_below and was_below
    if not sign:
        return None
    result = as_expression(np.sign(sign))
    for base, is_odd, is_below in kept.values():
        if _is_positive(base) or (is_below and not is_odd):
            is_new = True
        elif is_odd:
            inner = _stripped(base) if base.n_dep() else None
            is_new |= inner is not None
            result = as_expression(result * (base if inner is None else inner))
        else:
            result = as_expression(result * ca.fabs(base))
    return result if is_new and not result.is_constant() else None


def _factors(x: ca.SX, is_below: bool, is_odd: bool = True) -> Iterator[_Factor]:
    """Those of x, or of an even power of it."""
    parts = [x.dep(k) for k in range(x.n_dep())]
    match x.op():
        case ca.OP_MUL:
            yield from (*_factors(parts[0], is_below, is_odd), *_factors(parts[1], is_below, is_odd))
        case ca.OP_DIV:
            yield from (*_factors(parts[0], is_below, is_odd), *_factors(parts[1], not is_below, is_odd))
        case ca.OP_INV:
            yield from _factors(parts[0], not is_below, is_odd)
        case ca.OP_NEG | ca.OP_TWICE:
            yield as_expression(-1.0 if x.op() == ca.OP_NEG else 2.0), is_odd, is_below
            yield from _factors(parts[0], is_below, is_odd)
        case ca.OP_SIGN:
            yield from _factors(parts[0], is_below, is_odd)
        case ca.OP_SQRT if parts[0].op() == ca.OP_FABS:
            yield from _factors(parts[0], is_below, is_odd)
        case ca.OP_SQ | ca.OP_FABS:
            yield from _factors(parts[0], is_below, False)
        case ca.OP_POW | ca.OP_CONSTPOW if parts[1].is_constant() and _is_root(parts, float(parts[1])):
            power = float(parts[1])
            yield from _factors(parts[0], is_below != (power < 0), is_odd and power % 2 == 1)
        case _:
            yield x, is_odd, is_below


def _is_root(parts: list[ca.SX], power: float) -> bool:
    """Whether a power is a whole one, or one of what is positive by itself."""
    return power != 0 and (power.is_integer() or parts[0].op() in (ca.OP_FABS, ca.OP_SQ))


def _is_positive(x: ca.SX, least: float = 0.0) -> bool:
    """Whether it is, wherever; with `least` < 0 whether it is not negative."""
    parts = [x.dep(k) for k in range(x.n_dep())]
    if x.is_constant():
        return float(x) > least
    match x.op():
        case ca.OP_EXP | ca.OP_COSH:
            return True
        case ca.OP_SQ | ca.OP_FABS:
            return least < 0
        case ca.OP_SQRT | ca.OP_TWICE | ca.OP_INV:
            return _is_positive(parts[0], least)
        case ca.OP_ADD:
            return any(_is_positive(a, least) and _is_positive(b, -1.0) for a, b in (parts, parts[::-1]))
    return False
