"""What parameters have to be beyond the limits of their types: one tape, asked wherever they are set (runs, sweeps, FMUs)."""

from collections.abc import Iterator, Mapping

import casadi as ca

from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.records import dataclass
from lagrangia.compile.divisors import what_divides
from lagrangia.constraints.parameters import lengths_of_directions, parameter_symbols, possible_inertias, usual_inertias
from lagrangia.dynamics.impacts import Impacts
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.kinematics import Kinematics


@dataclass(frozen=True)
class Requirement:
    """1 where it is met and else 0, of all parameters; `said`: what is told where it is not, `parameters`: whose values then are
    told, too, `place`: where they are declared, or what is wrong stands, with its `excerpt` and `advice`. Else the run is
    refused, or goes on where it is `only_told`."""

    holds: ca.SX
    said: str
    parameters: tuple[str, ...] = ()
    place: str = ""
    only_told: bool = False
    excerpt: str = ""
    advice: str = ""

    @property
    def told(self) -> dict[str, object]:
        """As Scene.notes has it."""
        return {"said": self.said, "parameters": [*self.parameters], "place": self.place, "excerpt": self.excerpt,
                "advice": self.advice}


def find_requirements(kinematics: Kinematics, motion: Motion) -> tuple[Requirement, ...]:
    """Directions before what is divided by their lengths."""
    of_values = [*lengths_of_directions(kinematics), *possible_inertias(kinematics)]
    is_allowed = "L0746" in kinematics.graph.model.allowed
    usual = () if is_allowed else usual_inertias(kinematics)
    return (*(Requirement(holds, said, place=str(span)) for holds, said, span in of_values),
            *_of_events(kinematics, motion.impacts), *_of_divisors(kinematics, motion),
            *(Requirement(holds, said, place=str(span), only_told=True) for holds, said, span in usual))


def _of_divisors(kinematics: Kinematics, motion: Motion) -> Iterator[Requirement]:
    """That forces are not divided by 0."""
    declared = {name: v for v in kinematics.graph.model.variables.values() if v.kind == "parameter" for name, _ in v.elements()}
    names = _names(kinematics)
    for holds, divisor, place in what_divides(kinematics, motion):
        asked = _named_in(names, divisor)
        span = place or declared[asked[0]].span
        said = "division by zero" if place else "a force is divided by a root that vanishes with its rates, where it jumps,"
        advice = "give it another value, or write what holds then as a choice: if x <> 0 then .../x else ..." if place else ""
        yield Requirement(holds, said, asked, str(span), excerpt=span.excerpt, advice=advice)


def _of_events(kinematics: Kinematics, impacts: Impacts) -> Iterator[Requirement]:
    """That each stays what it was taken for when its scene was compiled, a contact or a kick."""
    names = _names(kinematics)
    for when, comparisons in zip(kinematics.graph.model.whens, impacts.recognized, strict=False):
        for x in comparisons:
            yield Requirement(x.holds, f"the event at '{when.condition.span.text}' {'becomes' if x.makes else 'ceases to be'} a "
                              "contact, which holds what rests there,", _named_in(names, x.holds))


def _names(kinematics: Kinematics) -> dict[int, str]:
    """Of the elements of parameters, by the hashes of their symbols."""
    names = [name for v in kinematics.graph.model.variables.values() if v.kind == "parameter" for name, _ in v.elements()]
    return {x.__hash__(): name for name, x in zip(names, parameter_symbols(kinematics).elements(), strict=True)}


def _named_in(names: Mapping[int, str], x: ca.SX) -> tuple[str, ...]:
    """Those that it depends on, in their order."""
    own = symbols_in(x)
    return tuple(name for symbol, name in names.items() if symbol in own)
