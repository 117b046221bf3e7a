"""What parameters have to be beyond the limits of their types: one tape, asked wherever they are set (runs, sweeps, FMUs)."""

from collections.abc import Iterator

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import lengths_of_directions, parameter_symbols, possible_inertias, usual_inertias
from lagrangia.dynamics.impacts import Impacts
from lagrangia.frames.kinematics import Kinematics


@dataclass(frozen=True)
class Requirement:
    """1 where it is met and else 0, of all parameters; `said`: what is told where it is not, `parameters`: whose values then are
    told, too, `place`: where they are declared. Else the run is refused, or goes on where it is `only_told`."""

    holds: ca.SX
    said: str
    parameters: tuple[str, ...] = ()
    place: str = ""
    only_told: bool = False

    @property
    def told(self) -> dict[str, object]:
        """As Scene.notes has it."""
        return {"said": self.said, "parameters": [*self.parameters], "place": self.place}


def find_requirements(kinematics: Kinematics, impacts: Impacts) -> tuple[Requirement, ...]:
    """Directions before what is divided by their lengths."""
    of_values = [*lengths_of_directions(kinematics), *possible_inertias(kinematics)]
    is_allowed = "L0746" in kinematics.graph.model.allowed
    usual = () if is_allowed else usual_inertias(kinematics)
    return (*(Requirement(holds, said, place=str(span)) for holds, said, span in of_values), *_of_events(kinematics, impacts),
            *(Requirement(holds, said, place=str(span), only_told=True) for holds, said, span in usual))


def _of_events(kinematics: Kinematics, impacts: Impacts) -> Iterator[Requirement]:
    """That each stays what it was taken for when its scene was compiled, a contact or a kick."""
    model, symbols = kinematics.graph.model, parameter_symbols(kinematics).elements()
    names = [name for v in model.variables.values() if v.kind == "parameter" for name, _ in v.elements()]
    for when, comparisons in zip(model.whens, impacts.recognized, strict=False):
        for x in comparisons:
            asked = tuple(name for name, symbol in zip(names, symbols, strict=True) if ca.depends_on(x.holds, symbol))
            yield Requirement(x.holds, f"the event at '{when.condition.span.text}' {'becomes' if x.makes else 'ceases to be'} a "
                              "contact, which holds what rests there,", asked)
