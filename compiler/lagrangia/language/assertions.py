"""assert(condition, text, level) and terminate(text) (Modelica 3.6, section 8.3.7 and 8.3.8).

What is known when the scene is compiled is checked at once; of all else a run takes care, as guards.
"""

from collections.abc import Mapping, Sequence
from typing import Literal

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.language.discrete import compared
from lagrangia.language.flat import Guard
from lagrangia.language.folding import fold
from lagrangia.language.function_variables import Assertion
from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.requirements import require_level
from lagrangia.language.texts import said_by
from lagrangia.language.tree import Boolean, Call, Expression, Reference
from lagrangia.language.whole_numbers import WholeNumbers

_WRITE = 'write: assert(n > 2, "three or more links");'
_ENDS = 'write: when x > 1 then terminate("it is there"); end when;'
LEVELS: Mapping[str, Literal["error", "warning"]] = {"AssertionLevel.error": "error", "AssertionLevel.warning": "warning"}


def read_assertion(call: Call[Expression], scope: Scope, place: Span, names: Names, whole: WholeNumbers) -> Assertion:
    """What an assertion says. Raises LagError L0215, L0302."""
    condition, text, level = _parts(call, place)
    said = _text(text, scope, names, "what an assertion says is a text", _WRITE)
    kind = LEVELS.get(str(level), "error")
    if level is not None and not (isinstance(level, Reference) and str(level) in LEVELS):
        fail("L0215", f"the level of an assertion is {' or '.join(LEVELS)}", level.span)
    flat = names.flatten(condition, scope)
    holds = fold(flat)
    if holds is not None and not isinstance(holds, bool):
        fail("L0302", "a condition is true or false", condition.span, _WRITE)
    return Assertion(flat if holds is not None else compared(flat, whole), said, kind)


def guard_of(call: Call[Expression], scope: Scope, place: Span, names: Names, report: Report, whole: WholeNumbers
             ) -> list[Guard]:
    """The guard of an assertion that parameters or the motion decide; of another one, an error or a warning L0238 where it does
    not hold. Raises LagError L0215, L0225, L0302."""
    one = read_assertion(call, scope, place, names, whole)
    flat, said, is_warning = names.without_known(one.condition), one.text, one.kind == "warning"
    if not isinstance(flat, Boolean):
        require_level(flat)
        return [Guard(flat, said, one.kind, scope.instance.path, place)]
    if not flat.value and is_warning:
        report.warning("L0238", said, place, "the assertion does not hold")
    elif not flat.value:
        report.error("L0238", said, place, "the assertion does not hold")
    return []


def ending_of(call: Call[Expression], scope: Scope, place: Span, names: Names) -> str:
    """What terminate(text) says. Raises LagError L0215, L0302."""
    if len(call.arguments) != 1 or call.named:
        fail("L0215", f"terminate takes a text, not {len(call.arguments) + len(call.named)} arguments", place, _ENDS)
    return _text(call.arguments[0], scope, names, "what is said at the end is a text", _ENDS)


def refuse_ending(place: Span) -> None:
    """Of a terminate that stands in no `when`. Raises LagError L0222."""
    fail("L0222", "terminate stands in a when", place, _ENDS)


def _text(node: Expression, scope: Scope, names: Names, what: str, hint: str) -> str:
    said = said_by(node, lambda part: names.known_part(part, scope))
    if said is None:
        fail("L0302", what, node.span, hint)
    return said


def _parts(call: Call[Expression], place: Span) -> tuple[Expression, Expression, Expression | None]:
    given: Sequence[Expression] = call.arguments
    named = dict(call.named)
    if wrong := named.keys() - {"condition", "message", "level"}:
        fail("L0215", f"assert has no argument '{min(wrong)}'", place, _WRITE)
    values = [*given, *(named[name] for name in ("condition", "message", "level")[len(given) :] if name in named)]
    if not 2 <= len(values) <= 3:
        fail("L0215", f"assert takes a condition and a text, not {len(values)} argument{'s' * (len(values) != 1)}", place, _WRITE)
    return values[0], values[1], values[2] if len(values) == 3 else None
