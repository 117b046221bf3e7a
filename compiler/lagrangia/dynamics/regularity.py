"""Whether M can be factored alone, and J M^-1 J^T keeps its digits: as a function of the parameters, for these may change."""

from functools import reduce

import casadi as ca

from lagrangia.algebra.scalars import symbols_in
from lagrangia.constraints.parameters import default_parameters, parameter_symbols
from lagrangia.dynamics.kkt import diagonal_of
from lagrangia.frames.kinematics import Kinematics

# Smallest pivot of the scaled mass matrix that still counts as mass, and the largest ratio of the masses that one constraint
# ties together that J M^-1 J^T bears.
_SINGULAR, _UNEVEN = 1e-11, 1e6
_HUGE = 1e300
_ROUNDING = 1e-26  # of squares: of axes in space that turn and come back
# Of two positions. Their numbers are the fractions of steps times squares, of which no three pairs lie on a line as those of
# multiples do: a straight rope does not feel its pulleys.
_STEPS = 5**0.5 / 2, 2**0.5


def find_evenness(kinematics: Kinematics, mass: ca.SX, pivots: ca.SX, J: ca.SX) -> ca.SX:
    """At general positions, as a function of the parameters: above 1 all over, unless some coordinates that a constraint ties
    together move next to no mass, or none: M loses rank there, or J M^-1 J^T its digits.

    Masses do that at every position. What happens at one of two only is a matter of the place: a link across its path, say.

    mass (n,): the diagonal of M; pivots (n,): those of its factors, relative to it in any order of the coordinates.
    """
    p = parameter_symbols(kinematics)
    known = symbols_in(p) if p.numel() else frozenset()
    mass, pivots, J = kinematics.unturned([mass, pivots, J])
    free = [s for s in ca.symvar(ca.veccat(mass, pivots, J)) if s.__hash__() not in known]
    looks = [_placed([pivots, ca.vertcat(ca.SX(0, 1), *((J * J) @ ca.diag(1 / mass)).nonzeros())], free, step)
             for step in _STEPS[: 2 if free else 1]]
    relative, shares = (reduce(ca.fmax, found) for found in zip(*looks, strict=True))
    rows: list[list[ca.SX]] = [[] for _ in range(J.size1())]
    for entry, row in enumerate(J.sparsity().row()):
        rows[row].append(shares[entry])
    tied = [row for row in rows if row]
    largest = [reduce(ca.fmax, row) for row in tied]
    nothing = [_ROUNDING * most if kinematics.geometry.by_rates else ca.SX(0) for most in largest]
    least = [reduce(ca.fmin, [ca.if_else(x > none, x, _HUGE) for x in row]) for row, none in zip(tied, nothing, strict=True)]
    spreads = [_UNEVEN * smallest / most for smallest, most in zip(least, largest, strict=True)]
    return ca.vertcat(relative / _SINGULAR, *spreads)


def _placed(expressions: list[ca.SX], free: list[ca.SX], step: float) -> list[ca.SX]:
    values = [ca.SX(0.3 + 2.5 * (step * k * k % 1)) for k in range(1, len(free) + 1)]
    found: list[ca.SX] = ca.substitute(expressions, free, values) if free else expressions
    return found


def relative_pivots(M: ca.SX) -> ca.SX:
    """Of the factors of M, scaled to a diagonal of 1."""
    scale = ca.diag(1 / ca.sqrt(diagonal_of(M)))
    return ca.ldl(scale @ M @ scale, True)[0]


def is_even(kinematics: Kinematics, evenness: ca.SX) -> bool:
    """With the parameters as declared."""
    p, declared = default_parameters(kinematics)
    numbers = ca.evalf(ca.substitute(evenness, p, ca.SX(declared)) if p.numel() else evenness)
    return all(x > 1 for x in numbers.full().ravel())
