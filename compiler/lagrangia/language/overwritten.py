"""Values in functions that are overwritten before anything reads them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from lagrangia.base.diagnostics import Report, Span
from lagrangia.language.implied_ranges import references
from lagrangia.language.tree import (
    Assignment,
    ClassDefinition,
    Declaration,
    Expression,
    Extends,
    ForBlock,
    IfBlock,
    Number,
    Reference,
    Results,
    WhileBlock,
)


def find_overwritten(function: ClassDefinition, names: Iterable[str], report: Report, code: str) -> None:
    """A warning for each assignment to one of the `names`, and value of a declaration, that nothing reads before the next."""
    if any(isinstance(e, Extends) for e in function.elements):
        return
    declared = [e for e in function.elements if isinstance(e, Declaration) and "input" not in e.prefixes]
    search = _Search({e.name for e in declared} & {*names})
    clauses = [clause for section in function.sections for clause in section.clauses]
    state = search.before(clauses, _State({e.name for e in declared if "output" in e.prefixes}))
    for element in reversed(declared):
        if element.binding is not None and element.name in search.names and element.name not in state.live:
            search.lost.append((element.binding.span, f"'{element.name}'"))
        state.read((element.binding, element.dimensions, element.arguments))
    for span, what in sorted(search.lost, key=lambda found: found[0].start):
        report.warning(code, f"nothing reads this value of {what} before the next one, or the end", span, "leave it out")


@dataclass
class _State:
    """Going backwards: `live` names are read later, before they have another value; so are all elements but the `done` ones."""

    live: set[str]
    done: set[str] = field(default_factory=set)

    def read(self, syntax: Any) -> None:
        """What stands here is read."""
        found = {reference.parts[0].name for reference in references(syntax)}
        self.live |= found
        self.done = {element for element in self.done if element.partition("[")[0] not in found}


class _Search:
    """Liveness of names, from the last statement to the first (A. Aho et al., Compilers, 2006, 9.2.5)."""

    def __init__(self, names: set[str]) -> None:
        self.names, self.lost = names, list[tuple[Span, str]]()

    def before(self, clauses: Sequence[Any], after: _State) -> _State:
        """The state in front of the clauses."""
        state = _State({*after.live}, {*after.done})
        for clause in reversed(clauses):
            if isinstance(clause, Assignment):
                self._assign(clause, state)
            elif isinstance(clause, IfBlock):
                branches = [self.before(branch, state) for branch in (clause.then, clause.otherwise)]
                state = _State(branches[0].live | branches[1].live, branches[0].done & branches[1].done)
                state.read(clause.condition)
            elif isinstance(clause, ForBlock | WhileBlock):  # the next pass may read what this one leaves
                state.read(clause)
                self.before(clause.body, state)
            else:
                state.read(clause)
        return state

    def _assign(self, clause: Assignment, state: _State) -> None:
        items = clause.target.items if isinstance(clause.target, Results) else (clause.target,)
        targets = [item for item in items if isinstance(item, Reference)]
        if targets and all(self._is_lost(target, state) for target in targets):
            self.lost.append((clause.span, " and ".join(f"'{target}'" for target in targets)))
        for target in targets:
            if _is_whole(target):
                state.live.discard(target.parts[0].name)
            elif (key := _key(target)) is not None:
                state.done.add(key)
        state.read((clause.value, tuple(part.subscripts for target in targets for part in target.parts)))

    def _is_lost(self, target: Reference, state: _State) -> bool:
        name = target.parts[0].name
        return name in self.names and (name not in state.live or _key(target) in state.done)


def _is_whole(target: Reference) -> bool:
    return len(target.parts) == 1 and not target.parts[0].subscripts


def _key(target: Reference) -> str | None:
    """v[1, 2] of an element whose subscripts are numbers; None for others."""
    subscripts: tuple[Expression, ...] = target.parts[0].subscripts
    if len(target.parts) > 1 or not subscripts or not all(isinstance(k, Number) for k in subscripts):
        return None
    return f"{target.parts[0].name}[{', '.join(k.span.text for k in subscripts)}]"
