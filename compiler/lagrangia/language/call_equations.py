"""Calls that stand as equations and are none."""

from typing import NoReturn

from lagrangia.base.diagnostics import Span, fail, nearest
from lagrangia.language.assertions import refuse_ending
from lagrangia.language.foreign_words import FOREIGN_CALLS
from lagrangia.language.tree import Call, Expression


def refuse_call(call: Call[Expression], span: Span) -> NoReturn:
    """Raises LagError L0222, L0901: what is meant, and where it stands."""
    if call.function == "reinit":
        fail("L0222", "reinit stands in a when", span, "write: when x < 0 then reinit(der(x), value); end when;")
    if call.function == "terminate":
        refuse_ending(span)
    if (last := call.function.rpartition(".")[2]) in FOREIGN_CALLS:
        fail("L0901", f"not of this language: {call.function}(...)", span, FOREIGN_CALLS[last])
    if call.function == "equilibrium":
        fail("L0222", "a start at rest stands in a section of its own", span, "write: initial equation equilibrium();")
    near = nearest(call.function, ["connect"])
    fail("L0222", f"{call.function}(...) is no equation", span,
         f"did you mean '{near}'?" if near else "an equation has a '=' between two expressions, or is connect(a, b)")
