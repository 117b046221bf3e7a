"""Conditions on rates that forces may hold at their level, as dry friction does: those that act on what these rates move. What a
first-order state decides for others stands on a level, or passes it, as places do."""

from collections.abc import Iterator, Mapping, Sequence

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, places_in, symbols_in
from lagrangia.dynamics.driven_conditions import Pair
from lagrangia.dynamics.held_switches import Holding
from lagrangia.dynamics.motion import Motion

Known = Mapping[Pair, Expression]


def that_may_hold(motion: Motion, rates: Known, places: Known, rests: Known, numbering: Numbering, groups: Sequence[int]
                  ) -> frozenset[Pair]:
    """Of conditions on `rates`, those whose forces may hold them. `places`: the switches of these and of others, and what stands
    for them; `groups`: of rates."""
    if len(set(groups)) <= 1:
        return frozenset(rates)
    felt = _felt(motion)
    shares = frozenset(x for pair in rates for x in symbols_in(places[pair]))
    laws = [motion.felt.laws, motion.felt.values] if motion.felt is not None else []
    h, *laws = rebuilt([motion.h, *laws], numbering, Holding(places, shares, rests, numbering).made)
    acted = [(symbols_in(x), group) for x, group in zip(ca.vertsplit(ca.densify(h)), groups, strict=True)]
    acted += [(symbols_in(x), groups[k]) for x in laws for k in list(felt)[:1]]
    found = list[Pair]()
    for pair, g in rates.items():
        asked, moved = symbols_in(ca.vertcat(places[pair], rests.get(pair, places[pair]))), groups_in(g, motion.v, groups)
        if any(group in moved and not asked.isdisjoint(symbols) for symbols, group in acted):
            found.append(pair)
    return frozenset(found)


def groups_in(g: ca.SX, v: ca.SX, groups: Sequence[int]) -> frozenset[int]:
    """Those of the rates in g."""
    own = symbols_in(g)
    return frozenset(group for x, group in zip(v.elements(), groups, strict=True) if x.__hash__() in own)


def groups_of_rates(motion: Motion) -> tuple[int, ...]:
    """Of each rate, a number that it shares with those that forces on it accelerate, too."""
    groups = list(range(motion.v.numel()))
    for tie in [*_ties(motion), _felt(motion)]:
        joined = {groups[k] for k in tie}
        groups = [min(joined) if x in joined else x for x in groups]
    return tuple(groups)


def _ties(motion: Motion) -> Iterator[set[int]]:
    """The places of rates that the inertia, a constraint, or a contact ties to each other."""
    yield from ({k, *found} for k, found in enumerate(places_in(motion.momentum, motion.v)))
    if motion.constrained is not None:
        yield from places_in(motion.constrained.rows.rate, motion.v)
    yield from _contacts(motion)


def _contacts(motion: Motion) -> list[set[int]]:
    """Of each event, the places of rates on which the force of what rests there acts, and of those of its gap."""
    impacts, acted = motion.impacts, places_in(motion.h, motion.impacts.forces)
    paces = ca.jtimes(impacts.gaps, motion.q, motion.pace) if impacts.gaps.numel() else impacts.gaps
    gaps = zip(places_in(impacts.gaps, motion.v), places_in(paces, motion.v), strict=True)
    return [{row for row, found in enumerate(acted) if k in found}.union(*moving) for k, moving in enumerate(gaps)]


def _felt(motion: Motion) -> set[int]:
    """The places of rates on which forces act that feel reactions, and of those that these come from."""
    if motion.felt is None:
        return set()
    values, held, found = motion.felt.values, motion.constrained, set[int]().union(*places_in(motion.felt.values, motion.a))
    found |= {row for row, amounts in enumerate(places_in(motion.h, motion.felt.amounts)) if amounts}
    if held is not None and ca.depends_on(values, held.symbols):
        found = found.union(*places_in(held.rows.rate, motion.v))
    pressing = set[int]().union(*places_in(values, motion.impacts.forces))
    return found.union(*(contact for k, contact in enumerate(_contacts(motion)) if k in pressing))
