"""Values that are arrays: tuples of scalars, or of such tuples, all of one size."""

from collections.abc import Callable
from typing import Any

from lagrangia.algebra.duals import Scalar
from lagrangia.base.diagnostics import Span, fail


def array_of(items: tuple[Any, ...], span: Span) -> tuple[Any, ...]:
    """Raises LagError L0303 where some are numbers and others vectors, or these of other sizes."""
    if len({len(item) if isinstance(item, tuple) else -1 for item in items}) > 1:
        fail("L0303", "numbers and vectors, or vectors of other sizes, do not stand in one array", span)
    return items


def map_scalars(function: Callable[[Scalar], Scalar], value: Any) -> Any:
    """The function of each number."""
    return tuple(map_scalars(function, item) for item in value) if isinstance(value, tuple) else function(value)


def zip_scalars(function: Callable[[Scalar, Scalar], Scalar], a: Any, b: Any, span: Span) -> Any:
    """The function of each pair of numbers. Raises LagError L0303 for other sizes."""
    if isinstance(a, tuple) != isinstance(b, tuple) or (isinstance(a, tuple) and len(a) != len(b)):
        fail("L0303", f"{_size(a)} and {_size(b)} do not go together", span)
    return tuple(zip_scalars(function, x, y, span) for x, y in zip(a, b, strict=True)) if isinstance(a, tuple) else function(a, b)


def need_vectors(arguments: list[Any], count: int, span: Span, size: int | None = None) -> None:
    """The first `count` arguments must be vectors of one size. Raises LagError L0303."""
    for value in arguments[:count]:
        if not isinstance(value, tuple) or len(value) != (size or len(arguments[0])):
            wanted = f" of {size} components" if size else " of equal size" if count > 1 else ""
            fail("L0303", f"{'vectors' if count > 1 else 'a vector'}{wanted} {'are' if count > 1 else 'is'} needed here", span)


def _size(value: Any) -> str:
    return f"an array of {len(value)}" if isinstance(value, tuple) else "a number"
