"""What an FMU knows beside the scene's functions and lists, by the names of the members of LagFmu (runtime/fmi/fmu.h)."""

import math
from collections.abc import Mapping, Sequence

from lagrangia.fmu.elements import element_lists
from lagrangia.fmu.variables import KEPT, FmuModel, held_of
from lagrangia.run.requirements import tell_requirement
from lagrangia.run.rules import Moment, solver_by

_GROUPS = ("real", "integer", "boolean", "string", *KEPT)


def sizes_of(model: FmuModel) -> Mapping[str, int]:
    """Integers of LagModel, with the solver of its FMU."""
    scene = model.scene
    return {**scene.sizes, "solver": int(solver_by(Moment.FMU, {"is_linear": "linear" not in scene.refused}))}


def constants(model: FmuModel) -> Mapping[str, Sequence[float | bool | str | None]]:
    """Structural values by their groups, each counted by the member `n_<group>s`."""
    return {group: [variable.start for variable in model.of(group)] for group in _GROUPS}


def extents_of(model: FmuModel) -> list[int]:
    """By value reference: how many numbers it stands for in FMI 3; 0 within an array."""
    found = [1] * len(model.variables)
    for array in model.arrays:
        found[array.reference : array.reference + array.size] = [array.size] + [0] * (array.size - 1)
    return found


def integers(model: FmuModel) -> Mapping[str, Sequence[int]]:
    """Lists of whole numbers, and of what is 0 or 1."""
    names = {variable.name: place for place, variable in enumerate(model.of("state"))}
    return {"kept": [names[held_of(v.name)] for v in model.of(*KEPT)], "state_settable": model.state_settable,
            "parameter_settable": model.settable, "extents": extents_of(model), **element_lists(model)}


def guards_of(model: FmuModel) -> list[str]:
    """What is said where assertions do not hold, and at the ends of runs."""
    return [str(guard["text"]) for guard in model.scene.notes.get("guards", ())]


def requirements_of(model: FmuModel) -> list[str]:
    """What is said where parameters do not meet what is required of them."""
    return [tell_requirement(known) for known in model.scene.notes.get("requirements", ())]


def vectors(model: FmuModel) -> Mapping[str, Sequence[float]]:
    """Those of doubles."""
    given, limits = constants(model), model.of("parameter")
    return {
        "state_start": model.state_start, "nominal": model.nominal, "parameter_start": model.given,
        "input_start": [float(v.start or 0.0) for v in model.of("input")],
        "minimum": [-math.inf if v.minimum is None else v.minimum for v in limits],
        "maximum": [math.inf if v.maximum is None else v.maximum for v in limits],
        "reals": [float(x or 0.0) for x in given["real"]], "integers": [float(x or 0) for x in given["integer"]],
        "booleans": [float(bool(x)) for x in given["boolean"]],
    }
