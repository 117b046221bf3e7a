"""Whether M can be factored alone, and J M^-1 J^T keeps its digits: as a function of the parameters, for these may change."""

from functools import reduce

import casadi as ca

from lagrangia.kinematics import Kinematics
from lagrangia.parameters import default_parameters

# Smallest pivot of the scaled mass matrix that still counts as mass, and the largest ratio of the masses that one constraint
# ties together that J M^-1 J^T bears.
_SINGULAR, _UNEVEN = 1e-11, 1e6
_HUGE = 1e300


def find_evenness(kinematics: Kinematics, M: ca.SX, J: ca.SX) -> ca.SX:
    """At general positions, as a function of the parameters: above 1 all over, unless some coordinates that a constraint ties
    together move next to no mass, or none: M loses rank there, or J M^-1 J^T its digits."""
    p, _ = default_parameters(kinematics)
    known = {x.__hash__() for x in ca.symvar(p)} if p.numel() else set()
    free = [s for s in ca.symvar(ca.veccat(M, J)) if s.__hash__() not in known]
    values = [ca.SX(0.3 + 0.41 * (k % 7)) for k in range(len(free))]
    mass, slopes = ca.substitute([M, J], free, values) if free else (M, J)
    diagonal = ca.vertcat(*[mass[k, k] for k in range(mass.size1())])
    scale = ca.diag(1 / ca.sqrt(diagonal))
    pivots = ca.ldl(scale @ mass @ scale, True)[0] / _SINGULAR
    shares = (slopes * slopes) @ ca.diag(1 / diagonal)
    rows: list[list[ca.SX]] = [[] for _ in range(J.size1())]
    for r, k in zip(*J.sparsity().get_triplet(), strict=True):
        rows[r].append(shares[r, k])
    least = [reduce(ca.fmin, [ca.if_else(x > 0, x, _HUGE) for x in row]) for row in rows if row]
    spreads = [_UNEVEN * smallest / reduce(ca.fmax, row) for smallest, row in zip(least, filter(None, rows), strict=True)]
    return ca.vertcat(pivots, *spreads)


def is_even(kinematics: Kinematics, evenness: ca.SX) -> bool:
    """With the parameters as declared."""
    p, declared = default_parameters(kinematics)
    numbers = ca.evalf(ca.substitute(evenness, p, ca.SX(declared)) if p.numel() else evenness)
    return all(x > 1 for x in numbers.full().ravel())
