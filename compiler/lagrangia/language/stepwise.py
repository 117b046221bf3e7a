"""Which quantities change at events alone: those that are Integer or Boolean, and all that is made of discrete variables and of
what samples hold."""

from collections.abc import Iterable, Mapping, Set

from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Flat, Ref

_STILL = ("parameter", "constant")


def find_stepwise(model: FlatModel, names: Iterable[str]) -> dict[str, str]:
    """The type of each of them, Real, Integer or Boolean, by its name; those of arrays are named as arrays are."""
    stepped = {name for name, state in model.states.items() if state.is_kept}
    stepped |= {name for name, variable in model.variables.items() if variable.kind == "held"}
    bindings = {name: variable.binding for name, variable in model.variables.items() if name not in stepped} if stepped else {}
    found = {}
    for name in names:
        variable = model.variables.get(name) or model.variables.get(name.partition("[")[0])
        if variable is None or variable.kind not in ("variable", "held"):
            continue
        if variable.type_name != "Real" or (stepped and _steps(variable.name, stepped, bindings, model)):
            found[name] = variable.type_name
    return found


def _steps(name: str, stepped: Set[str], bindings: Mapping[str, Flat | None], model: FlatModel) -> bool:
    """Whether a variable reads what steps, and nothing that moves otherwise."""
    read = {leaf.name if isinstance(leaf, Ref) else "" for leaf in leaves([Ref(name, (), model.span)], bindings)}
    others = read - stepped
    return others != read and all(
        x in model.variables and (bindings.get(x) is not None or model.variables[x].kind in _STILL) for x in others)
