"""assert(condition, text, level): of what is known when the scene is compiled (Modelica 3.6, section 8.3.7)."""

from collections.abc import Sequence

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.language.folding import fold
from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import Call, Expression, Reference, String

_WRITE = 'write: assert(n > 2, "three or more links");'
_LEVELS = ("AssertionLevel.error", "AssertionLevel.warning")


def check_assertion(call: Call[Expression], scope: Scope, place: Span, names: Names, report: Report) -> None:
    """An error, or a warning L0238, where it does not hold. Raises LagError L0215, L0302, L0901 where the motion decides."""
    condition, text, level = _parts(call, place)
    said = names.flatten(text, scope)
    if not isinstance(said, String):
        fail("L0302", "what an assertion says is a text", text.span, _WRITE)
    is_warning = False
    if level is not None:
        if not isinstance(level, Reference) or str(level) not in _LEVELS:
            fail("L0215", f"the level of an assertion is {' or '.join(_LEVELS)}", level.span)
        is_warning = str(level) == _LEVELS[1]
    holds = fold(names.flatten(condition, scope))
    if holds is None:
        fail("L0901", "not supported yet: an assertion that parameters or the motion decide", condition.span,
             "of Integer, Boolean and constant values it is checked; a parameter has limits: Mass m(min = 0)")
    if not isinstance(holds, bool):
        fail("L0302", "a condition is true or false", condition.span, _WRITE)
    if not holds and is_warning:
        report.warning("L0238", said.value, place, "the assertion does not hold")
    elif not holds:
        report.error("L0238", said.value, place, "the assertion does not hold")


def _parts(call: Call[Expression], place: Span) -> tuple[Expression, Expression, Expression | None]:
    given: Sequence[Expression] = call.arguments
    named = dict(call.named)
    if wrong := named.keys() - {"condition", "message", "level"}:
        fail("L0215", f"assert has no argument '{min(wrong)}'", place, _WRITE)
    values = [*given, *(named[name] for name in ("condition", "message", "level")[len(given) :] if name in named)]
    if not 2 <= len(values) <= 3:
        fail("L0215", f"assert takes a condition and a text, not {len(values)} argument{'s' * (len(values) != 1)}", place, _WRITE)
    return values[0], values[1], values[2] if len(values) == 3 else None
