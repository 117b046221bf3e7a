"""How much a class is sure to bring, counted before it is made: each class is looked at once, however often it is used."""

from collections.abc import Callable, Sequence
from dataclasses import field
from math import prod

from lagrangia.base.diagnostics import LagError
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.tree import Argument, ClassDefinition, Declaration, Expression, Extends, Number


@dataclass
class Foreseen:
    """Counts by the ids of classes, which are kept."""

    table: ClassTable
    components: dict[int, tuple[ClassDefinition, int]] = field(default_factory=dict)
    classes: dict[int, tuple[ClassDefinition, int]] = field(default_factory=dict)

    def components_of(self, declaration: Declaration) -> int:
        """At least how many components each element of a declaration is made of, itself among them: 1 where another class may
        take its place, 0 where it is none or something is wrong with it."""
        try:
            if self.table.base_type(declaration.type_name, declaration.type_span) is not None:
                return 0
            definition = self.table.lookup(declaration.type_name, declaration.type_span)
        except LagError:
            return 0
        if "replaceable" in declaration.prefixes | definition.prefixes or _redeclare(declaration.arguments):
            return 1
        return _once(self.components, definition, lambda: 1 + sum(map(self._of_element, definition.elements)))

    def _of_element(self, element: Declaration | Extends) -> int:
        if isinstance(element, Declaration):
            is_sure = element.condition is None and not element.prefixes & {"outer", "redeclare"}
            count = _elements(element.dimensions) if is_sure else 0
            return count * self.components_of(element) if count else 0
        base = self._base(element)
        if base is None or _redeclare(element.arguments) or any(a.is_left_out for a in element.arguments):
            return 0
        return _once(self.components, base, lambda: 1 + sum(map(self._of_element, base.elements))) - 1

    def classes_of(self, definition: ClassDefinition) -> int:
        """How many classes a class inherits, itself among them, each as often as it does."""
        bases = (self._base(e) for e in definition.elements if isinstance(e, Extends))
        return _once(self.classes, definition, lambda: 1 + sum(self.classes_of(base) for base in bases if base is not None))

    def _base(self, element: Extends) -> ClassDefinition | None:
        try:
            return None if element.type_name == "Frame" else self.table.lookup(element.type_name, element.span)
        except LagError:
            return None


def _once(known: dict[int, tuple[ClassDefinition, int]], definition: ClassDefinition, count: Callable[[], int]) -> int:
    """1 inside itself: classes that contain or extend themselves are told elsewhere."""
    if id(definition) not in known:
        known[id(definition)] = definition, 1
        known[id(definition)] = definition, count()
    return known[id(definition)][1]


def _elements(sizes: Sequence[Expression]) -> int:
    """Of sizes written in numbers; 0 where one is not."""
    return prod(max(0, int(size.value)) if isinstance(size, Number) else 0 for size in sizes)


def _redeclare(arguments: tuple[Argument, ...]) -> bool:
    return any(a.redeclared is not None or _redeclare(a.arguments) for a in arguments)
