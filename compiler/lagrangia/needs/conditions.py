"""Where forces bend or jump, statement by statement, and what decides it there."""

from collections.abc import Iterator

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Energies, generalised_force
from lagrangia.dynamics.found_conditions import conditions_in
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.switches import sign_of

LENGTH, RATE, PLACE = "a length passes through 0", "a rate turns", "a place decides"


@dataclass(frozen=True)
class Corner:
    """The component, or "" for a statement of the scene's own, and what decides: LENGTH, RATE or PLACE."""

    component: str
    decided_by: str
    span: Span


def find_corners(energies: Energies, motion: Motion) -> tuple[Corner, ...]:
    """One for each statement and what decides there, in the order of the text."""
    numbering = Numbering()
    lengths = {sign_of(x, numbering) for x in motion.lengths}
    movers, rates = ca.vertcat(motion.t, motion.q, motion.v, motion.u), symbols_in(motion.v)
    found: dict[Corner, None] = {}
    for force, component, span in _forces(energies, motion):
        for pair, g in conditions_in([force], movers, motion.v, numbering)[0].items():
            what = LENGTH if pair in lengths else PLACE if rates.isdisjoint(symbols_in(g)) else RATE
            found[Corner(component, what, span)] = None
    return tuple(found)


def _forces(energies: Energies, motion: Motion) -> Iterator[tuple[ca.SX, str, Span]]:
    for terms, moving in ((energies.potential, motion.q), (energies.dissipation, motion.v)):
        for term in terms:
            yield ca.densify(ca.gradient(ca.SX(term.value), moving)), term.component, term.statement.span
    for load in energies.loads:
        yield generalised_force([load], motion.q, motion.v), load.statement.component, load.statement.span
