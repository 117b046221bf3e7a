"""Parameters that nothing reads but other parameters and starts: given along with all of these they change nothing."""

from collections.abc import Iterable, Iterator

from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import Flat, Ref

Readers = dict[str, list[str]]


def find_readers(model: FlatModel) -> Readers:
    """Of each such parameter what reads it, by names: of parameters their own, of starts "start(NAME)". What anything else reads
    is left out; what nothing reads at all, too."""
    parameters = {v.name for v in model.variables.values() if v.kind == "parameter"}
    found: dict[str, dict[str, None]] = {}
    others: list[Flat] = [*model.stated(), *(state.rate for state in model.states.values())]
    for variable in model.variables.values():
        is_parameter = variable.kind == "parameter"
        if variable.binding is not None and not is_parameter:
            others.append(variable.binding)
        own = variable.binding if is_parameter else None
        for reader, side in ((variable.name, own), (f"start({variable.name})", variable.start)):
            for name in _named([side], parameters) if side is not None else ():
                found.setdefault(name, {})[reader] = None
    if found:
        for name in _named(others, parameters):
            found.pop(name, None)
    return {name: list(readers) for name, readers in found.items()}


def _named(sides: Iterable[Flat], parameters: set[str]) -> Iterator[str]:
    return (node.name for node in nodes(*sides) if node.__class__ is Ref and node.name in parameters)
