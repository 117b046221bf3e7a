"""Conditions on rates that forces may hold at their level, as dry friction does: those that act on what these rates move. What a
first-order state decides for others stands on a level, or passes it, as places do."""

from collections.abc import Mapping

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, symbols_in
from lagrangia.dynamics.driven_conditions import Pair
from lagrangia.dynamics.held_switches import Holding
from lagrangia.dynamics.motion import Motion

Known = Mapping[Pair, Expression]


def that_may_hold(motion: Motion, rates: Known, places: Known, rests: Known, numbering: Numbering) -> frozenset[Pair]:
    """Of conditions on `rates`, those whose forces may hold them; all where constraints or contacts pass forces on, or these feel
    some. `places`: the switches of these and of others, and what stands for them."""
    groups = _groups(motion)
    passes_on = motion.constrained is not None or motion.felt is not None or motion.impacts.forces.numel() > 0
    if passes_on or len(set(groups)) <= 1:
        return frozenset(rates)
    shares = frozenset(x for pair in rates for x in symbols_in(places[pair]))
    (h,) = rebuilt([motion.h], numbering, Holding(places, shares, rests, numbering).made)
    acted = [(symbols_in(x), group) for x, group in zip(ca.vertsplit(ca.densify(h)), groups, strict=True)]
    found = list[Pair]()
    for pair, g in rates.items():
        asked, own = symbols_in(ca.vertcat(places[pair], rests.get(pair, places[pair]))), symbols_in(g)
        moved = {group for x, group in zip(motion.v.elements(), groups, strict=True) if x.__hash__() in own}
        if any(group in moved and not asked.isdisjoint(symbols) for symbols, group in acted):
            found.append(pair)
    return frozenset(found)


def _groups(motion: Motion) -> list[int]:
    """Of each rate, a number that it shares with those that forces on it accelerate, too."""
    groups = list(range(motion.v.numel()))
    for i, j in zip(*ca.jacobian_sparsity(motion.momentum, motion.v).get_triplet(), strict=True):
        first, second = sorted((groups[i], groups[j]))
        groups = [first if x == second else x for x in groups]
    return groups
