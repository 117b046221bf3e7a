"""Recursions over many alike elements, as those along a chain of bodies: one step is derived, the others are stamped out.

A step written with scalars takes the time of as many calls of CasADi as it has operations. As a Function of what changes from one
element to the next it is inlined, all elements in one call, in a tenth of the time; expressions are the same. Where elements, or
what is handed on, differ in what is a number among them, each is a step of its own.
"""

from collections.abc import Callable, Sequence
from itertools import chain, compress
from math import inf, nan
from typing import TypeAlias

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import Expression, as_expression, cells, column, symbol
from lagrangia.base.records import dataclass

_FEWEST = 24  # elements: a Function for fewer takes longer than it saves
_AT_ONCE = 32  # elements in one call; to make a Function of all takes as long as they do
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


def each(work: Callable[[list[Scalar]], list[Scalar]], inputs: Sequence[list[Scalar]]) -> list[list[Scalar]]:
    """`work` of every element by itself: of many, in which the same are numbers, by columns, which gives the same expressions. It
    asks only whether what it is given are numbers."""
    groups: dict[Numbers, list[int]] = {}
    for k, values in enumerate(inputs):
        groups.setdefault(_numbers(values), []).append(k)
    found: list[list[Scalar]] = [[]] * len(inputs)
    for numbers, places in groups.items():
        if len(places) < _FEWEST:
            for k in places:
                found[k] = work(inputs[k])
            continue
        table = zip(*(inputs[k] for k in places), strict=True)
        made = work([_together(values) if number is None else number for number, values in zip(numbers, table, strict=True)])
        for k, row in zip(places, zip(*(_apart(x, len(places)) for x in made), strict=True), strict=True):
            found[k] = [*row]
    return found


def _together(values: Sequence[Scalar]) -> Expression:
    """A column; what all have in common stays one scalar."""
    return as_expression(values[0] if all(x is values[0] for x in values) else column(*values))


def _apart(x: Scalar, count: int) -> Sequence[Scalar]:
    return cells(x) if isinstance(x, ca.SX) and not x.is_scalar() else [x] * count


def _end(kinds: Sequence[Numbers], k: int) -> int:
    """The place behind the last of those that are alike from k on."""
    end = k
    while end < len(kinds) and kinds[end] == kinds[k]:
        end += 1
    return end


def _numbers(values: Sequence[Scalar]) -> Numbers:
    return tuple([None if isinstance(x, ca.SX) else float(x) for x in values])


@dataclass(frozen=True)
class _Stamp:
    """A step of elements in which the same are numbers."""

    function: ca.Function  # of what are expressions among the state and the inputs, and of the results
    state: Numbers
    inputs: Numbers
    row: Callable[[list[Expression], int, list[Scalar]], list[Scalar]]  # of what was made, where an element begins, its inputs

    def along(self, state: list[Scalar], inputs: Sequence[list[Scalar]]) -> tuple[list[Scalar], list[list[Scalar]]]:
        """The state behind the last element, and the results of each."""
        count, width = len(inputs), self.inputs.count(None)
        is_open = [number is None for number in self.inputs]
        given = chain.from_iterable(compress(values, is_open) for values in inputs)
        table = ca.reshape(column(*given), width, count)
        begin = column(*(x for x, number in zip(state, self.state, strict=True) if number is None))
        found: list[ca.SX] = []
        many = self.function.mapaccum("along", _AT_ONCE)
        for columns in ca.horzsplit(table, _AT_ONCE):
            together = many if columns.size2() == _AT_ONCE else self.function.mapaccum("along", columns.size2())
            states, made = together.call([begin, columns])
            begin = states[:, -1]
            found.append(made)
        size, rest = self.function.numel_out(1), iter(cells(begin))
        stamped = cells(ca.horzcat(*found))
        results = [self.row(stamped, k * size, values) for k, values in enumerate(inputs)]
        return [next(rest) if number is None else number for number in self.state], results


def _stamp(step: Step, state: Numbers, inputs: Numbers) -> _Stamp | None:
    """None for a step behind which other parts of the state are numbers than before it, or all are."""
    values = [[symbol("x") if number is None else number for number in numbers] for numbers in (state, inputs)]
    arguments = [column(*(x for x in part if isinstance(x, ca.SX))) for part in values]
    after, results = step(*values)
    if _numbers(after) != state or None not in state or None not in inputs:
        return None
    texts = {id(x): f"own[{k}]" for k, x in enumerate(values[1]) if isinstance(x, ca.SX)}
    found: list[Scalar] = []
    for x in results:
        if isinstance(x, ca.SX) and id(x) not in texts:
            texts[id(x)] = f"made[at+{len(found)}]"
            found.append(x)
    columns = [column(*(x for x in part if isinstance(x, ca.SX))) for part in (after, found)]
    text = ", ".join(texts.get(id(x)) or repr(float(x)) for x in results)
    row = eval(f"lambda made, at, own: [{text}]", {"inf": inf, "nan": nan})
    return _Stamp(ca.Function("step", arguments, [ca.densify(x) for x in columns]), state, inputs, row)
