"""Recursions over many alike elements, as those along a chain of bodies: one step is derived, the others are stamped out.

A step written with scalars takes the time of as many calls of CasADi as it has operations. As a Function of what changes from one
element to the next it is inlined, all elements in one call, in a tenth of the time; expressions are the same. Where elements, or
what is handed on, differ in what is a number among them, each is a step of its own.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import Expression, as_expression, symbol
from lagrangia.base.records import dataclass

_FEWEST = 24  # elements: a Function for fewer takes longer than it saves
Numbers: TypeAlias = "tuple[float | None, ...]"  # of scalars; None for expressions
Step: TypeAlias = "Callable[[list[Scalar], list[Scalar]], tuple[list[Scalar], list[Scalar]]]"


def scan(step: Step, state: list[Scalar], inputs: Sequence[list[Scalar]]) -> tuple[list[Scalar], list[list[Scalar]]]:
    """(state, inputs) -> (state, results), for one element after the other: the last state, and the results of each."""
    results: list[list[Scalar]] = []
    kinds = [_numbers(values) for values in inputs] if len(inputs) >= _FEWEST else []
    k = 0
    while k < len(inputs):
        end = _end(kinds, k)
        stamp = _stamp(step, _numbers(state), kinds[k]) if end - k >= _FEWEST else None
        if stamp is not None:
            state, found = stamp.along(state, inputs[k:end])
            results += found
            k = end
        else:
            state, one = step(state, inputs[k])
            results.append(one)
            k += 1
    return state, results


def _end(kinds: Sequence[Numbers], k: int) -> int:
    """The place behind the last of those that are alike from k on."""
    end = k
    while end < len(kinds) and kinds[end] == kinds[k]:
        end += 1
    return end


def _numbers(values: Sequence[Scalar]) -> Numbers:
    return tuple(None if isinstance(x, ca.SX) else float(x) for x in values)


@dataclass(frozen=True)
class _Stamp:
    """A step of elements in which the same are numbers."""

    function: ca.Function  # of what are expressions among the state and the inputs, and of the results
    state: Numbers
    inputs: Numbers
    results: Numbers

    def along(self, state: list[Scalar], inputs: Sequence[list[Scalar]]) -> tuple[list[Scalar], list[list[Scalar]]]:
        """The state behind the last element, and the results of each."""
        count = len(inputs)
        given = [x for values in inputs for x, number in zip(values, self.inputs, strict=True) if number is None]
        begin = ca.vertcat(*(x for x, number in zip(state, self.state, strict=True) if number is None))
        whole = self.function.mapaccum("along", count)
        states, found = whole.call([begin, ca.reshape(ca.vertcat(ca.SX(0, 1), *given), -1, count)])
        rest = iter(_scalars(found))
        results = [[next(rest) if number is None else number for number in self.results] for _ in range(count)]
        last = iter(_scalars(states[:, -1]))
        return [next(last) if number is None else number for number in self.state], results


def _scalars(matrix: ca.SX) -> list[Expression]:
    found: list[Expression] = matrix.elements()
    for x in found:
        x.__class__ = Expression
    return found


def _stamp(step: Step, state: Numbers, inputs: Numbers) -> _Stamp | None:
    """None for a step behind which other parts of the state are numbers than before it, or all are."""
    values = [[symbol("x") if number is None else number for number in numbers] for numbers in (state, inputs)]
    arguments = [ca.vertcat(ca.SX(0, 1), *(x for x in part if isinstance(x, ca.SX))) for part in values]
    after, results = step(*values)
    if _numbers(after) != state or None not in state or None not in inputs:
        return None
    made = [ca.vertcat(ca.SX(0, 1), *(as_expression(x) for x in part if isinstance(x, ca.SX))) for part in (after, results)]
    return _Stamp(ca.Function("step", arguments, [ca.densify(x) for x in made]), state, inputs, _numbers(results))
