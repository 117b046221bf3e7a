"""Motion -> where its forces may turn within less than a step.

A bump exp(-(x/w)^2), 1/(1 + (x/w)^2) or 1/cosh(x/w), a step tanh(x/w) or x/sqrt(w^2 + x^2) is a smooth function, so that no
step is cut there; but what is 2 mm wide lies between all stages of a step of decimetres. What stands inside tells where to look:
g = -(x/w)^2, -log(1 + (x/w)^2), x/w; it passes through 0 there, or turns round.
"""

from collections.abc import Sequence

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbols_in
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.switches import Switches

_FADING = frozenset({ca.OP_EXP, ca.OP_TANH, ca.OP_COSH, ca.OP_ATAN, ca.OP_ERF, ca.OP_ASINH})
_UNDER = {ca.OP_DIV: 1, ca.OP_INV: 0, ca.OP_SQRT: 0, ca.OP_LOG: 0, ca.OP_POW: 0, ca.OP_CONSTPOW: 0}  # which operand it is
_ASKED = frozenset({"exp", "tanh", "cosh", "sinh", "atan", "erf", "asinh", "sqrt", "log", "pow", "ratio"})


def find_narrow_places(motion: Motion, switches: Switches) -> ca.SX:
    """g (k,) of t, q, v, u, d, p: what stands inside of functions in the forces that fade, or settle, where it is large."""
    if motion.asked.isdisjoint(_ASKED):
        return ca.SX(0, 1)
    known = motion.unsolved or motion
    moving, rest = symbols_in(ca.vertcat(motion.t, motion.q, motion.v)), symbols_in(motion.a)
    if known.felt is not None:
        rest = rest | symbols_in(known.felt.reactions)
    rates, numbering, found = symbols_in(motion.v), Numbering(), dict[tuple[bool, int], Expression]()

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        if op in _FADING:
            inner, key = operands[0], (False, numbers[0])
        elif op in _UNDER:
            inner, key = operands[_UNDER[op]], (True, numbers[_UNDER[op]])
        else:
            return
        if op == ca.OP_SQRT and rates.isdisjoint(symbols_in(inner)):
            return  # of positions: find_roots has them
        if key in found or moving.isdisjoint(symbols := symbols_in(inner)) or not rest.isdisjoint(symbols):
            return
        if op in _FADING:
            found[key] = inner
        elif (least := _least(inner, moving)) is not None:
            found[key] = as_expression(-ca.log(inner / least))

    rebuilt(switches.hold([known.h]), numbering, note)
    return ca.vertcat(ca.SX(0, 1), *found.values())


def _least(x: Expression, moving: frozenset[int]) -> Expression | None:
    """w^2 of w^2 + what is even in a difference that may be 0; None of anything else."""
    steady, others = as_expression(0.0), list[Expression]()
    waiting = [x]
    while waiting:
        term = waiting.pop()
        if moving.isdisjoint(symbols_in(term)):
            steady = steady + term
        elif term.op() == ca.OP_ADD:
            waiting += _operands(term)
        else:
            others.append(term)
    is_sum = bool(others) and all(_is_square(term, moving) for term in others)
    return steady if is_sum and not steady.is_zero() else None


def _is_square(x: Expression, moving: frozenset[int]) -> bool:
    """Whether it is one, or a multiple of one, of what moves."""
    if x.op() == ca.OP_SQ:
        return True
    factors: Sequence[Expression] = _operands(x) if x.op() in (ca.OP_MUL, ca.OP_DIV) else []
    steady = [moving.isdisjoint(symbols_in(factor)) for factor in factors]
    if x.op() == ca.OP_MUL and any(steady):
        return _is_square(factors[steady.index(False)], moving)
    return x.op() == ca.OP_DIV and steady[1] and _is_square(factors[0], moving)


def _operands(x: Expression) -> list[Expression]:
    return [as_expression(x.dep(k)) for k in range(x.n_dep())]
