"""Motion -> groups of coordinates that do not interact, and the motion of each by itself.

Two coordinates interact when one stands in the other's equation, or both in one constraint or one term of the powers. What time
and inputs do to both is no interaction. Each group can be run with a method and steps of its own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import casadi as ca

from lagrangia.base.later import Later
from lagrangia.constraints.initial import InitialConditions
from lagrangia.dynamics.constrained_motion import ConstrainedMotion, ConstraintRows, FreeMotion, bring_down, constrain
from lagrangia.dynamics.motion import Motion, solve_dense
from lagrangia.frames.kinematics import Kinematics
from lagrangia.needs.spectrum import find_spectrum
from lagrangia.run.rules import Facts

MOST_COORDINATES, MOST_ISLANDS = 200, 8  # of scenes that are divided
_SUMS = (ca.OP_ADD, ca.OP_SUB)


def find_islands(motion: Motion) -> list[tuple[int, ...]]:
    """Groups of coordinates, each in ascending order."""
    n = motion.q.numel()
    groups, apart = list(range(n)), n

    def root(i: int) -> int:
        while groups[i] != i:
            groups[i] = groups[groups[i]]
            i = groups[i]
        return i

    for i, j in _interactions(motion):
        if apart == 1:
            break
        first, second = root(i), root(j)
        groups[first] = second
        apart -= first != second
    found: dict[int, list[int]] = {}
    for i in range(n):
        found.setdefault(root(i), []).append(i)
    return [tuple(group) for group in found.values()]


def _interactions(motion: Motion) -> Iterator[tuple[int, int]]:
    """Pairs of coordinates, and of coordinates with themselves; those that are found sooner come first."""
    n, held = motion.q.numel(), motion.constrained
    solved = ca.SX(0, 1) if held else motion.acceleration
    pattern = ca.jacobian_sparsity(ca.vertcat(solved, motion.h, motion.momentum), ca.vertcat(motion.q, motion.v))
    for row, column in zip(*pattern.get_triplet(), strict=True):
        yield row % n, column % n
    for term in (*_terms(motion.dissipated_power), *_terms(held.load_power if held else motion.source_power)):
        among = _coordinates(term, motion)
        yield from ((among[0], other) for other in among[1:])
    for among in filter(None, _constrained(held.rows, motion) if held else []):
        yield from ((among[0], other) for other in among[1:])


def island_motion(kinematics: Kinematics, motion: Motion, groups: Sequence[tuple[int, ...]], k: int) -> Motion:
    """The motion of group k alone. Powers that no coordinate takes part in are the first group's."""
    chosen, held = list(groups[k]), motion.constrained

    def part(power: ca.SX) -> ca.SX:
        own = [term for term in _terms(power) if (_coordinates(term, motion) or groups[0])[0] in groups[k]]
        return ca.sum1(ca.vertcat(*own)) if own else ca.SX(1, 1)

    own = replace(motion, q=motion.q[chosen], v=motion.v[chosen], a=motion.a[chosen],
                  momenta=Later(lambda: motion.momentum[chosen]), inertial=Later(lambda: motion.h[chosen]),
                  acceleration=motion.acceleration[chosen], dissipated_power=part(motion.dissipated_power),
                  source_power=part(held.load_power if held else motion.source_power), constrained=None,
                  way="dense", collected=None)
    return _held(kinematics, own, held, _own_rows(motion, held, chosen), chosen) if held else own


def _held(kinematics: Kinematics, motion: Motion, whole: ConstrainedMotion, own: list[int], chosen: list[int]) -> Motion:
    """An island under its own constraints, of the whole scene's."""
    tree = whole.tree.part(chosen, own) if whole.tree is not None else None
    if not own:
        return replace(motion, acceleration=tree.acceleration if tree else solve_dense(motion.momentum, -motion.h, motion.v))
    holonomic = [i for i in own if i < whole.rows.phi.numel()]
    rows = ConstraintRows(whole.rows.phi[holonomic], whole.rows.rate[own], whole.rows.bias[own])
    free = FreeMotion(motion.q, motion.v, motion.momentum, motion.h, motion.source_power, tree)
    acceleration, source, held = constrain(kinematics, rows, free, whole.evenness.numel() == 0)
    short = bring_down(held, free, whole.partition.part(chosen, own)) if whole.partition is not None else None
    return replace(motion, acceleration=acceleration, source_power=source, constrained=short or held)


def _constrained(rows: ConstraintRows, motion: Motion) -> list[list[int]]:
    """The coordinates of each constraint, in the order of the rows."""
    n, m = motion.q.numel(), rows.rate.numel()
    found: list[set[int]] = [set() for _ in range(m)]
    # Those of gaps as well: in space what vanishes for the turns of a loop has rates that are known to others where it is closed.
    pattern = ca.jacobian_sparsity(ca.vertcat(rows.rate, rows.bias, rows.phi), ca.vertcat(motion.q, motion.v))
    for row, column in zip(*pattern.get_triplet(), strict=True):
        found[row % m].add(column % n)
    return [sorted(among) for among in found]


def _own_rows(motion: Motion, held: ConstrainedMotion, chosen: list[int]) -> list[int]:
    """The constraints of some coordinates."""
    return [i for i, among in enumerate(_constrained(held.rows, motion)) if among and among[0] in chosen]


def weigh_islands(
    kinematics: Kinematics, motions: Sequence[Motion], initial: InitialConditions, groups: Sequence[tuple[int, ...]]
) -> Facts:
    """How fast a few islands are at the start, 1/s, for the rows of run/rules.py."""
    rates = []
    for motion, group in zip(motions, groups, strict=True):
        chosen = list(group)
        spectrum = find_spectrum(kinematics, motion, replace(initial, q=initial.q[chosen], v=initial.v[chosen]))
        if spectrum is None:
            return {"is_known": 0}
        rates.append(spectrum.fastest)
    moving = [rate for rate in rates if rate > 0]
    fastest, slowest = max(moving, default=0.0), min(moving, default=0.0)
    return {"is_known": 1, "islands": len(rates), "resting": len(rates) - len(moving), "fastest": fastest, "slowest": slowest,
            "ratio": fastest / slowest if slowest else 0.0}


def _coordinates(term: ca.SX, motion: Motion) -> list[int]:
    n = motion.q.numel()
    return sorted({i % n for i in ca.jacobian_sparsity(term, ca.vertcat(motion.q, motion.v)).get_triplet()[1]})


def _terms(power: ca.SX) -> list[ca.SX]:
    """The terms of a sum, with their signs."""
    found, pending = [], [(ca.SX(power), False)]
    while pending:
        term, negative = pending.pop()
        if term.is_symbolic() or term.is_constant() or term.op() not in (*_SUMS, ca.OP_NEG):
            if not term.is_zero():
                found.append(-term if negative else term)
            continue
        pending.append((term.dep(0), negative != (term.op() == ca.OP_NEG)))
        if term.op() in _SUMS:
            pending.append((term.dep(1), negative != (term.op() == ca.OP_SUB)))
    return found
