"""Calls of a drawing section -> figures."""

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.figures import WORDS
from lagrangia.language.flat import Figure
from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import Call, Expression


def figure_of(call: Expression, scope: Scope, place: Span, names: Names) -> Figure:
    """Raises LagError L0229 for what is no word of figures.py."""
    if not isinstance(call, Call) or call.function not in WORDS:
        name = call.function if isinstance(call, Call) else call.span.text
        fail("L0229", f"'{name}' is nothing that can be drawn", call.span,
             suggest(name, WORDS) or f"one of {', '.join(WORDS)}")
    arguments = tuple(names.flatten(argument, scope) for argument in call.arguments)
    options = {name: names.flatten(value, scope) for name, value in call.named}
    return Figure(call.function, arguments, options, scope.instance.path, place)
