"""What acts late -> the signals of which it is, as functions of the state."""

import casadi as ca

from lagrangia.algebra.scalars import as_expression, column, symbols_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.tree import Flat


@dataclass(frozen=True)
class Delaying:
    """All (delays,): `lags`, of parameters; `values`, of the state: what is read late; `before`, of time and parameters: what it
    was before the start, 0 where nothing is `stated`. `rises`: none of the values is made of another one at once."""

    lags: ca.SX
    values: ca.SX
    before: ca.SX
    stated: tuple[int, ...]
    rises: bool

    @property
    def patterns(self) -> dict[str, tuple[int, ...]]:
        """Lists of places of LagModel."""
        return {"stated": self.stated} if self.stated else {}


def find_delaying(kinematics: Kinematics) -> Delaying:
    """Raises LagError L0901 for what is made of accelerations or forces, L0232 for delays that change."""
    delays, tau = kinematics.graph.model.delays, kinematics.symbols.tau
    unknown = column(*kinematics.symbols.accelerations.values())

    def value(node: Flat) -> ca.SX:
        found = kinematics.evaluator.value(node)
        if isinstance(found, tuple):
            fail("L0901", "not supported yet: the delay of an array", node.span, "delay its elements, each by itself")
        return ca.substitute(as_expression(found), tau, ca.SX(1))

    lags, values, before = [], [], []
    for delay in delays:
        lag, x = value(delay.lag), value(delay.value)
        first = value(delay.before) if delay.before is not None else ca.SX(0)
        if not kinematics.algebra.changing.isdisjoint(symbols_in(lag)):
            fail("L0901", "not supported yet: a delay that changes during the run", delay.lag.span,
                 "let it depend on parameters only")
        if not (kinematics.algebra.changing - {kinematics.symbols.time.__hash__()}).isdisjoint(symbols_in(first)):
            fail("L0232", "what was before the start depends on time and parameters only, smoothly", delay.span)
        forces = [*kinematics.forces.values(), *(f for wrench in kinematics.reactions.values() for f in wrench)]
        if ca.depends_on(x, ca.vertcat(unknown, *forces)):
            fail("L0901", "not supported yet: the delay of accelerations or of forces in joints and contacts", delay.span,
                 "let it be late of positions, rates and loads")
        lags.append(lag)
        values.append(x)
        before.append(first)
    _require_beginning(kinematics, values)
    late = ca.vertcat(ca.SX(0, 1), *[as_expression(kinematics.symbols.values[delay.name]) for delay in delays])
    everything = ca.vertcat(ca.SX(0, 1), *values)
    rises = not (delays and ca.depends_on(everything, late))
    return Delaying(ca.vertcat(ca.SX(0, 1), *lags), everything, ca.vertcat(ca.SX(0, 1), *before),
                    tuple(int(delay.before is not None) for delay in delays), rises)


def _require_beginning(kinematics: Kinematics, values: list[ca.SX]) -> None:
    """Raises LagError L0212 where what was before the start follows from itself."""
    delays = kinematics.graph.model.delays
    open_ones = [k for k, delay in enumerate(delays) if delay.before is None]
    late = [as_expression(kinematics.symbols.values[delay.name]) for delay in delays]
    while free := [k for k in open_ones if not any(ca.depends_on(values[k], late[j]) for j in open_ones)]:
        open_ones = [k for k in open_ones if k not in free]
    if open_ones:
        fail("L0212", "what this was before the start follows from itself", delays[open_ones[0]].span,
             "say what it was: delay(x, T, before = ...)")
