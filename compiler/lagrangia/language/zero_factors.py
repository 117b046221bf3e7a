"""Products with a 0 that somebody wrote: what stands beside it is named, and read by nothing."""

import re
from collections.abc import Iterable
from typing import Any

from lagrangia.base.diagnostics import Report
from lagrangia.language.syntax_parts import parts_of
from lagrangia.language.tree import Binary, Call, ClassDefinition, EnergyTerm, Number, Reference, Unary

_LOOKS_LIKE_ONE = re.compile(r"(?<![\w.])0(\.0*)?\s*(\[[^\]]*\]\s*)?[*/]|\*\s*[-(\s]*0(\.0*)?(?![\w.])")


def find_zero_factors(own: Iterable[ClassDefinition], report: Report, code: str) -> None:
    """A warning for each product of people's own, in a class, that is 0 whatever it names."""
    for definition in own:
        if not _LOOKS_LIKE_ONE.search(definition.span.text):
            continue
        pending, found = list[Any]([definition.elements, definition.sections]), list[tuple[Binary[Any], Any]]()
        while pending:
            node = pending.pop()
            if isinstance(node, Binary) and (other := _beside_zero(node)) is not None and _names(other):
                found.append((node, other))
            else:
                is_told = isinstance(node, EnergyTerm) and isinstance(node.value, Binary)  # as an energy of 0
                pending += parts_of(node.value if is_told else node)
        for node, other in sorted(found, key=lambda pair: pair[0].span.start):
            report.warning(code, f"this is 0, whatever '{other.span.text}' is", node.span, "leave it out, or write 0")


def _beside_zero(node: Binary[Any]) -> Any:
    if node.operator == "*" and _is_zero(node.right):
        return node.left
    return node.right if node.operator in ("*", "/") and _is_zero(node.left) else None


def _is_zero(node: Any) -> bool:
    while isinstance(node, Unary) and node.operator == "-":
        node = node.operand
    return isinstance(node, Number) and node.value == 0


def _names(node: Any) -> bool:
    """Whether it is more than a number."""
    return isinstance(node, Reference | Call) or any(_names(part) for part in parts_of(node))
