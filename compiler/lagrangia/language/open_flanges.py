"""Ends of drive trains that are connected to nothing: what has one passes no force on, and changes nothing."""

from collections.abc import Mapping

from lagrangia.base.diagnostics import Report
from lagrangia.language.classes import ClassTable
from lagrangia.language.flat import FlatModel
from lagrangia.language.instances import FrameSlot, Instance
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Flat, Ref
from lagrangia.language.unread import inside


def find_open_flanges(model: FlatModel, root: Instance, _table: ClassTable) -> Report:
    """A warning for each component of the library with an end whose position nothing else feels: a spring, a gear or a clutch
    between a shaft and nothing; and for each that has no mass and is connected to nothing at all, as Fixed."""
    report, idle = Report(), {}
    parts = _parts(model)
    if parts:
        idle = _useless(model, parts) | _alone(model, parts)
    for instance in inside(root) if idle else ():
        if instance.path in idle and not any(isinstance(member, FrameSlot) for member in instance.members.values()):
            end = idle[instance.path]
            kind = instance.definition.name
            report.warning("L0224", f"{kind} '{instance.path}' changes nothing: '{end}' is connected to nothing that holds it",
                           instance.span, f"write: connect({instance.path}.{end}, ...); with a shaft, a mass or Fixed, or leave "
                           f"'{instance.path}' out")
    return report


def _parts(model: FlatModel) -> dict[str, list[str]]:
    """The components of the library that have ends, with the variables of these."""
    parts: dict[str, list[str]] = {}
    for name, kind in model.flanges.items():
        if kind:
            parts.setdefault(name.rsplit(".", 2)[0], []).append(name)
    return parts


def _useless(model: FlatModel, parts: Mapping[str, list[str]]) -> dict[str, str]:
    """Components with an end that moves by itself and that no other component feels, and then those that lead to these alone."""
    free = {name for name in model.flanges if model.variables[name].kind == "coordinate"}
    if not free:
        return {}
    felt: dict[str, set[str]] = {name: set() for name in free}
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    read = [binding for name, binding in bindings.items() if binding is not None and not _is_inside(name, parts)
            and not (name in model.flanges and isinstance(binding, Ref))]  # ends between components are other names alone
    for component, values in [*_stated(model).items(), ("", read)]:
        for leaf in leaves(values, bindings):
            if isinstance(leaf, Ref) and leaf.name in free:
                felt[leaf.name].add(component)
    idle: dict[str, str] = {}
    while found := {component: name for name, by in felt.items() if len(by) == 1 for component in by if component in parts}:
        for component, name in found.items():
            own = (end for end in parts[component] if end == name or _is_other_name(end, name, bindings))
            idle[component] = _end(next(own, name))
        for by in felt.values():
            by.difference_update(found)
    return idle


def _is_inside(name: str, parts: Mapping[str, list[str]]) -> bool:
    """Whether a variable is one of these components, or of a part of one."""
    path = name.rpartition(".")[0]
    while path and path not in parts:
        path = path.rpartition(".")[0]
    return bool(path)


def _is_other_name(name: str, of: str, bindings: Mapping[str, Flat | None]) -> bool:
    while isinstance(value := bindings.get(name), Ref):
        name = value.name
    return name == of


def _stated(model: FlatModel) -> Mapping[str, list[Flat]]:
    """What each component states of energies, forces and constraints; under no name what is looked at besides."""
    stated: dict[str, list[Flat]] = {"": list(model.looks())}
    for energy in model.energies:
        stated.setdefault("" if energy.kind == "kinetic" else energy.component, []).append(energy.value)
    for work in model.works:
        stated.setdefault(work.component, []).extend((work.force, work.position))
    for equation in model.constraints:
        stated.setdefault(equation.component, []).extend((equation.left, equation.right))
    return stated


def _alone(model: FlatModel, parts: Mapping[str, list[str]]) -> dict[str, str]:
    """Components that state no energy, and none of whose ends is connected, or named elsewhere."""
    joined = {name for pair in model.connections for name in pair}
    stating = {energy.component for energy in model.energies} | {work.component for work in model.works}
    apart = {end for component, ends in parts.items() if component not in stating and joined.isdisjoint(ends) for end in ends}
    if not apart:
        return {}
    elsewhere = [(x.name, x.binding) for x in model.variables.values() if x.binding is not None]
    elsewhere += [(f"{component}.", value) for component, values in _stated(model).items() for value in values]
    named = {leaf.name.rsplit(".", 2)[0] for path, value in elsewhere for leaf in leaves([value], {})
             if isinstance(leaf, Ref) and leaf.name in apart and not path.startswith(f"{leaf.name.rsplit('.', 2)[0]}.")}
    return {component: _end(ends[0]) for component, ends in parts.items() if ends[0] in apart and component not in named}


def _end(variable: str) -> str:
    """The port that a variable is of."""
    return variable.rsplit(".", 2)[1]
