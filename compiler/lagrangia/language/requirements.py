"""What has to hold wherever an expression is reckoned: assertions in functions, for each call of them.

Each comparison of an assertion becomes a result of its function, the difference of both sides; where the function is called the
condition is put together from calls of these. One in a branch, of the function or around the call, has to hold where the branch
is taken alone.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from lagrangia.base.diagnostics import LagError, Report, Span, fail
from lagrangia.language.events import COMPARED, level_of
from lagrangia.language.flat import Guard
from lagrangia.language.folding import fold, folded
from lagrangia.language.function_variables import Assertion
from lagrangia.language.instances import Scope
from lagrangia.language.known_calls import MadeFunctions
from lagrangia.language.loops import Work
from lagrangia.language.tree import Binary, Boolean, Call, Expression, Flat, IfExpression, Local, Number, Unary


def require_level(condition: Flat) -> None:
    """That a condition, one that `implied` put together too, has a level. Raises LagError L0225."""
    try:
        level_of(condition)
    except LagError as error:
        span = error.diagnostics[0].span or condition.span
        if not _lies_in(span, condition.span):
            fail("L0225", "an assertion stands under this condition, which has to compare with <, <=, > or >= then", span,
                 f"the assertion is at {condition.span}; what is known when the scene is compiled, as an Integer parameter, may "
                 "compare in any way")
        fail("L0225", "an assertion of what moves, or of parameters, compares with <, <=, > or >=: this does not", span,
             "write: abs(x) <= 1; conditions go together with and, or, not")


def _lies_in(inner: Span, outer: Span) -> bool:
    return inner.source is outer.source and outer.start <= inner.start < outer.end


def implied(under: Sequence[Flat], condition: Flat) -> Flat:
    """What holds where the condition does, and where one of those that it stands under does not."""
    for one in reversed(under):
        condition = Binary("or", Unary("not", one, one.span), condition, condition.span)
    return condition


def undecided(condition: Flat, known: Callable[[Flat], float | bool | None]) -> Flat:
    """What a condition comes to where parts of it are `known`."""
    match condition:
        case Binary("and" | "or" as operator, left, right, span):
            sides = undecided(left, known), undecided(right, known)
            for one, other in (sides, sides[::-1]):
                if isinstance(one, Boolean):
                    return other if one.value == (operator == "and") else one
            return Binary(operator, *sides, span)
        case Unary("not", operand, span):
            inner = undecided(operand, known)
            return Boolean(not inner.value, span) if isinstance(inner, Boolean) else Unary("not", inner, span)
    value = known(condition)
    return Boolean(value, condition.span) if isinstance(value, bool) else condition


class Requirements(Protocol):
    """What names.py does with conditions."""

    report: Report
    made: MadeFunctions
    work: Work
    guards: list[Guard]
    under: list[Flat]  # conditions of the if expressions that are being read
    moment: str  # what happens at one moment alone and is being read; "" for what holds all the time

    def flatten(self, node: Expression, scope: Scope) -> Flat:
        """An expression with full names. Raises LagError."""

    def choose(self, node: IfExpression[Expression], scope: Scope) -> Flat:
        """An if expression, or the branch of it that is known to be taken."""
        condition = self.flatten(node.condition, scope)
        known = fold(condition)
        if isinstance(known, bool):
            return self.flatten(node.then if known else node.otherwise, scope)
        then = self._where(condition, node.then, scope)
        otherwise = self._where(Unary("not", condition, condition.span), node.otherwise, scope)
        return IfExpression(condition, then, otherwise, node.span)

    def _where(self, condition: Flat, node: Expression, scope: Scope) -> Flat:
        """An expression that counts where a condition holds alone."""
        self.under.append(condition)
        try:
            return self.flatten(node, scope)
        finally:
            self.under.pop()

    def known_part(self, node: Expression, scope: Scope) -> Flat | None:
        """The value of an expression, where it is known when the scene is compiled."""
        return folded(self.made.with_known_calls(self.flatten(node, scope), self.work))

    def without_known(self, condition: Flat) -> Flat:
        """A condition without the parts of it that are known when the scene is compiled: true or false alone where that settles
        it, in the whole's place."""
        return replace(undecided(condition, lambda part: fold(self.made.with_known_calls(part, self.work))), span=condition.span)

    def require(self, one: Assertion, cells: Mapping[str, Flat], span: Span, scope: Scope) -> None:
        """That an assertion of a function holds for what a call gives it. Raises LagError L0225, L0238, L0902."""
        whole = self.without_known(implied(self.under, with_cells(one.condition, cells)))
        holds = whole.value if isinstance(whole, Boolean) else None
        is_warning = one.kind == "warning"
        if holds is None and self.moment:
            fail("L0902", f"not supported yet: {self.moment} that calls a function with an assertion", span,
                 f"the assertion is at {one.condition.span}")
        if holds is None:
            require_level(whole)
            self.guards.append(Guard(whole, one.text, "warning" if is_warning else "error", scope.instance.path, span))
        elif not holds and is_warning:
            self.report.warning("L0238", one.text, span, f"{one.condition.span.text} does not hold, at {one.condition.span}")
        elif not holds:
            fail("L0238", one.text, span, f"{one.condition.span.text} does not hold, at {one.condition.span}")


def with_cells(condition: Flat, cells: Mapping[str, Flat]) -> Flat:
    """An assertion's condition with what a call gives the inputs."""
    match condition:
        case Binary("and" | "or" as operator, left, right, span):
            return Binary(operator, with_cells(left, cells), with_cells(right, cells), span)
        case Unary(operator, operand, span):
            return Unary(operator, with_cells(operand, cells), span)
        case Binary(operator, Call() as gap, right, span):
            return Binary(operator, replace(gap, arguments=tuple(
                cells[x.name] if isinstance(x, Local) else x for x in gap.arguments)), right, span)
    return condition


def measured(condition: Flat, result: Callable[[Flat], Flat]) -> Flat:
    """A condition in a function as others see it: each comparison is one of a result, which `result` calls, with 0. Raises
    LagError L0225."""
    known = fold(condition)
    if isinstance(known, bool):
        return Boolean(known, condition.span)
    match condition:
        case Binary("and" | "or" as operator, left, right, span):
            return Binary(operator, measured(left, result), measured(right, result), span)
        case Unary("not", operand, span):
            return Unary("not", measured(operand, result), span)
        case Binary(operator, left, right, span) if operator in (*COMPARED, "==", "<>"):
            return Binary(operator, result(Binary("-", left, right, span)), Number(0.0, None, span), span)
    require_level(condition)  # which raises: this compares nothing
    return condition
