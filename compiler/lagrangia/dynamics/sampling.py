"""What is held between instants -> the values that it has from an instant on, as functions of the state there."""

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import as_expression, column
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.samplers import in_order


@dataclass(frozen=True)
class Sampling:
    """`fires` (held,): 1 of those whose instant it is, else 0; `values` (held,): what is held from there on, in the order of
    the modes; `places`, `samplers`: these modes, and whose they are. `first`: what is held before any instant, of parameters
    alone."""

    fires: ca.SX
    values: ca.SX
    places: tuple[int, ...]
    samplers: tuple[int, ...]
    first: ca.SX


def find_sampling(kinematics: Kinematics) -> Sampling:
    """Raises LagError L0901 for what is made of accelerations or forces, which are not known beforehand."""
    model, modes, tau = kinematics.graph.model, kinematics.algebra.modes, kinematics.symbols.tau
    names = [name for mode in modes if mode.of_sampler is not None
             for name, symbol in kinematics.symbols.held.items() if symbol.__hash__() == mode.hash]
    fires = {name: ca.SX.sym(f"fires_{name}") for name in names}
    unknown = column(*kinematics.symbols.accelerations.values())
    found: dict[str, Scalar] = {}
    for held in in_order(model) if model.samplers else ():
        knowing = kinematics.knowing(found)
        value = knowing.evaluator.value(held.value)
        if isinstance(value, tuple):
            fail("L0303", f"an array of {len(value)} for a number", held.span)
        value = ca.substitute(as_expression(value), tau, ca.SX(1))
        forces = [*knowing.forces.values(), *(x for wrench in knowing.reactions.values() for x in wrench)]
        if ca.depends_on(value, ca.vertcat(unknown, *forces)):
            fail("L0901", "not supported yet: a held value of accelerations or of forces in joints and contacts", held.span,
                 "let it follow from positions, rates and loads")
        found[held.name] = ca.if_else(fires[held.name], value, kinematics.symbols.held[held.name])
    places = tuple(k for k, mode in enumerate(modes) if mode.of_sampler is not None)
    samplers = tuple(mode.of_sampler[0] for mode in modes if mode.of_sampler is not None)
    values = ca.vertcat(ca.SX(0, 1), *[found[name] for name in names])
    first = ca.vertcat(ca.SX(0, 1), *[modes[k].value for k in places])
    return Sampling(ca.vertcat(ca.SX(0, 1), *fires.values()), values, places, samplers, first)
