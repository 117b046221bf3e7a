"""Branches that somebody wrote and that never count: a condition stands twice in a chain, or both branches are the same."""

import re
from collections.abc import Iterable
from typing import Any

from lagrangia.base.diagnostics import Report, Span
from lagrangia.language.syntax_parts import parts_of
from lagrangia.language.tree import ClassDefinition, IfBlock, IfExpression

_MAY_HAVE_SOME = re.compile(r"\bif\b")


def find_idle_branches(own: Iterable[ClassDefinition], report: Report, code: str) -> None:
    """A warning for each, in classes and functions of people's own."""
    for definition in own:
        if not _MAY_HAVE_SOME.search(definition.span.text):
            continue
        pending, seen = list[Any]([definition.elements, definition.sections]), set[Span]()
        while pending:
            node = pending.pop()
            if isinstance(node, IfExpression | IfBlock) and node.span not in seen:
                _look_at_chain(node, seen, report, code)
            pending += parts_of(node)


def _look_at_chain(first: Any, seen: set[Span], report: Report, code: str) -> None:
    """An `if` with all its branches, whose spans become seen."""
    link, known = first, set[str]()
    while isinstance(link, IfExpression | IfBlock):
        seen.add(link.span)
        condition = _words(link.condition)
        if condition in known:
            report.warning(code, f"this branch is never taken: '{link.condition.span.text}' stands in one before it",
                           link.condition.span, "leave it out, or give it another condition")
        known.add(condition)
        if isinstance(link, IfExpression):
            if _words(link.then) == _words(link.otherwise):
                report.warning(code, f"both branches are '{link.then.span.text}': the condition has no effect", link.span,
                               "write it once")
            link = link.otherwise
        else:
            link = link.otherwise[0] if len(link.otherwise) == 1 else None


def _words(node: Any) -> str:
    """Its text without blanks about signs; as it is where there are texts in it."""
    text: str = node.span.text
    return text if '"' in text or "'" in text else re.sub(r"\s*([^\w\s])\s*", r"\1", text)
