"""Loops, unrolled: the values that iterators take."""

from collections.abc import Iterable
from typing import Protocol

from lagrangia.base.diagnostics import Diagnostic, Span, TooMuchError, fail
from lagrangia.base.records import dataclass
from lagrangia.language.instances import Scope, StructuralValues
from lagrangia.language.tree import Array, Expression, Iterator, Range, Reference

_OF_NUMBERS = "numbers in equal distances: linspace(0, 2, 5), or {0.5*i for i in 0:4}"
_UNROLLED = "the loops and sums of this model unroll to"
_MOST_ITERATIONS = 100_000  # of one loop
_MOST_OPERATIONS = 300_000  # of all loops of a model, each times the clauses in it: some 10 us each


@dataclass
class Work:
    """How many clauses, elements, and operations of functions the loops of a model were unrolled to."""

    operations: int = 0

    def spend(self, count: int, span: Span, how: str = _UNROLLED, hint: str = "those inside each other multiply") -> None:
        """Raises TooMuchError L0209 before more is unrolled than can be looked at in good time."""
        self.operations += count
        if self.operations > _MOST_OPERATIONS:
            what = f"{how} more than {_MOST_OPERATIONS} operations"
            raise TooMuchError([Diagnostic("error", "L0209", what, span, "", (hint,))])


class Loops(StructuralValues, Protocol):
    """What runs over iterators, of names.py."""

    work: Work

    def count_of_literals(self, node: Reference) -> int | None:
        """How many values an enumeration has; None for what is none."""

    def loop(self, iterators: tuple[Iterator, ...], scope: Scope, size: int = 1) -> Iterable[Scope]:
        """The scopes of all passes of a loop over so many clauses, the last iterator running fastest. Raises LagError
        L0209, L0214."""
        scopes = [scope]
        for iterator in iterators:
            if iterator.range is None:
                fail("L0214", f"the range of '{iterator.name}' is missing", iterator.span, "write: for i in 1:n")
            passes: list[Scope] = []
            for outer in scopes:
                passes += [outer.bind(iterator.name, value) for value in self._values(iterator.range, outer)]
                if len(passes) > _MOST_ITERATIONS:
                    fail("L0209", f"a loop of more than {_MOST_ITERATIONS} passes", iterator.span)
            scopes = passes
        self.work.spend(len(scopes) * size, iterators[0].span)
        return scopes

    def _values(self, node: Expression, scope: Scope) -> list[int]:
        if isinstance(node, Range):
            return self._range(node, scope)
        if isinstance(node, Reference) and (count := self.count_of_literals(node)) is not None:
            return list(range(1, count + 1))
        if isinstance(node, Array):
            return [self.integer(item, scope, "a loop's value") for item in node.items]
        fail("L0214", "a loop runs over a range or a list of integers", node.span, "write: for i in 1:n")

    def _range(self, node: Range, scope: Scope) -> list[int]:
        start, stop = (self.integer(e, scope, "the end of a range") for e in (node.start, node.stop))
        step = self.integer(node.step, scope, "the step of a range", _OF_NUMBERS) if node.step is not None else 1
        if step == 0 or (stop - start) // step > _MOST_ITERATIONS:
            fail("L0209", f"a range of more than {_MOST_ITERATIONS} values", node.span)
        return list(range(start, stop + (1 if step > 0 else -1), step))
