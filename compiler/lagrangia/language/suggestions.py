"""What a wrong name is likely to mean: a parameter or port by its spelling, its quantity or its description."""

import re
from collections.abc import Collection, Mapping

from lagrangia.base.diagnostics import nearest
from lagrangia.language.classes import ClassTable
from lagrangia.language.tree import ClassDefinition, Declaration

_MOST_LISTED = 12
_OF_HEAT = frozenset(("useHeatPort", "heatPort"))  # of Modelica's components


def explain(table: ClassTable, definition: ClassDefinition, word: str, given: Collection[str] = ()) -> list[str]:
    """Hints for a name that a model does not have; `given` are the other names that were used with it."""
    own = table.declared(definition)
    if word in _OF_HEAT:
        return ["heat has no ports here: " + ("'lossPower' is what becomes heat, and the account of energies counts it"
                                              if "lossPower" in own else "the account of energies counts what becomes heat")]
    if near := nearest(word, own):
        return [f"did you mean '{near}'?"]
    if meant := _meant(own, word):
        return [f"did you mean {_described(meant)}?"]
    return [*_inventory(own), *_elsewhere(table, own, word, {*given} - {word})]


def _meant(declared: Mapping[str, Declaration], word: str) -> Declaration | None:
    """The declaration whose quantity or description says the word: Mass m for `mass`, c "damping constant" for `damping`."""
    ranked = [(rank, declaration) for declaration in declared.values() if (rank := _rank(declaration, word.lower())) is not None]
    return min(ranked, key=lambda pair: pair[0])[1] if ranked else None


def _rank(declaration: Declaration, word: str) -> int | None:
    """0 for the best reading. A single letter says too little to be looked for in descriptions."""
    quantity, said = declaration.type_name.lower(), re.findall(r"\w+", declaration.description.lower())
    if quantity == word:
        return 0
    if len(word) > 1 and word in said[:1]:
        return 1
    if len(word) > 2 and any(part.startswith(word) for part in said):
        return 2
    return 3 if quantity.startswith(word) else None


def _elsewhere(table: ClassTable, own: Mapping[str, Declaration], word: str, given: set[str]) -> list[str]:
    """The library's model with the same ports that has such a parameter, and as many of the others given as possible."""
    found = []
    for other in table.library.values():
        declared = table.declared(other)
        if other.kind != "model" or other.is_partial or not _ports(own) or _ports(declared) != _ports(own):
            continue
        if meant := declared.get(word) or _meant(declared, word):
            found.append((len(given - declared.keys()), len(declared), other.name, meant))
    return [f"did you mean a {name}, with {_described(meant)}?" for _, _, name, meant in sorted(found, key=lambda f: f[:3])[:1]]


def component_of(table: ClassTable, variable: Declaration, given: Collection[str]) -> list[str]:
    """Hints where what is of a quantity, as Torque, is given names that no variable has: the library's model that asks for such
    a quantity and has as many of these names as possible, if it has any."""
    quantity, found = variable.type_name, []
    if quantity not in table.library:
        return []
    for other in table.library.values():
        declared = table.declared(other)
        asked = [x.name for x in declared.values() if x.binding is None and x.condition is None]
        asks = any(declared[name].type_name == quantity for name in asked)
        if other.kind == "model" and not other.is_partial and asks and _ports(declared):
            found.append((len({*given} - declared.keys()), len(asked), len(declared), other.name, asked))
    if not found or min(found)[0] == len({*given}):
        return []
    *_, name, asked = min(found)
    return [f"{quantity} is a quantity: a variable of it has no ports",
            f"a component that has one: {name} {variable.name}({', '.join(f'{x} = ...' for x in asked)})"]


def _ports(declared: Mapping[str, Declaration]) -> set[str]:
    return {name for name, declaration in declared.items() if declaration.type_name == "Frame"}


def _inventory(own: Mapping[str, Declaration]) -> list[str]:
    if len(own) > _MOST_LISTED:
        return []
    ports = sorted(_ports(own))
    numbers = [_described(declaration) for name, declaration in own.items() if name not in ports]
    return [f"{start} {', '.join(names)}" for start, names in (("it has", numbers), ("its ports are", ports)) if names]


def _described(declaration: Declaration) -> str:
    return f"'{declaration.name}'" + (f" ({declaration.description})" if declaration.description else "")
