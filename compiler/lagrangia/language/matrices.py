"""Functions and operators of arrays, written out: fill, transpose, [a, b; c, d], A*x (Modelica 3.6, chapter 10)."""

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from itertools import chain
from math import prod

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.elements import Size, element, length
from lagrangia.language.folding import fold, folded
from lagrangia.language.loops import Work
from lagrangia.language.mentions import children, nodes
from lagrangia.language.tree import Array, Binary, Call, Flat, Number, Unary

_MOST_ELEMENTS = 100_000
_LARGE = 10_000  # multiplications of a product that are counted among a model's operations
_WRITTEN_OUT = "products of matrices, one within the other, are written out to"
_NAME_IT = "give what stands inside a name of its own: parameter Real y[n] = A*x, or Real y[n] = A*x; and write A*y"
_BY_VECTORS = "products with vectors take fewer: y = A*x and A*y in place of A*A*x, each with a name of its own"
_PLAIN = {".+": "+", ".-": "-", ".*": "*", "./": "/", ".^": "^"}
EACH = frozenset(_PLAIN)  # operators that act on element after element


def shape_of(node: Flat, size: Size) -> tuple[int, ...]:
    """The sizes of an expression's dimensions, () of a number."""
    n = length(node, size)
    if n is None:
        return ()
    return (n,) if n == 0 else (n, *shape_of(element(node, 1, size), size))


def written_out(node: Flat, size: Size) -> Flat:
    """An array as {a, b, ...}, in all of its dimensions; a number as it is."""
    n = length(node, size)
    return node if n is None else Array(tuple(written_out(element(node, k, size), size) for k in range(1, n + 1)), node.span)


def rows_of(node: Flat, size: Size) -> list[tuple[Flat, ...]]:
    """Of a matrix; a vector is one column, a number one element."""
    full = written_out(node, size)
    items = full.items if isinstance(full, Array) else (full,)
    return [item.items if isinstance(item, Array) else (item,) for item in items]


def _matrix(rows: Sequence[Sequence[Flat]], span: Span) -> Array[Flat]:
    return Array(tuple(Array(tuple(row), span) for row in rows), span)


# ------------------------------------------------------------ operators


def product(left: Flat, right: Flat, size: Size, span: Span, work: Work) -> Flat:
    """left*right where one of them is a matrix. Raises LagError L0303, L0209."""
    a, b = shape_of(left, size), shape_of(right, size)
    if not a or not b:
        return each(".*", left, right, size, span)
    if len(a) > 2 or len(b) > 2 or a[-1] != b[0]:
        fail("L0303", f"{spoken(a)} cannot be multiplied by {spoken(b)}", span,
             "the columns of the first are as many as the rows of the second; of element after element the product is .*")
    rows = [_items(left, size)] if len(a) == 1 else rows_of(left, size)
    columns = [_items(right, size)] if len(b) == 1 else list(zip(*rows_of(right, size), strict=True))
    if len(rows) * len(columns) * a[-1] > _LARGE:
        work.spend(2 * len(rows) * len(columns) * a[-1], span, "products of matrices are written out to", _BY_VECTORS)
    work.spend(_repeated(rows, columns), span, _WRITTEN_OUT, _NAME_IT)
    found = [[_inner(row, column, span) for column in columns] for row in rows]
    if len(a) == 1:
        return Array(tuple(found[0]), span)
    return Array(tuple(row[0] for row in found), span) if len(b) == 1 else _matrix(found, span)


def _repeated(rows: Sequence[Sequence[Flat]], columns: Sequence[Sequence[Flat]]) -> int:
    """How many operations within the elements of two matrices their product repeats, as each row meets all columns."""
    return len(columns) * _operations(*chain(*rows)) + len(rows) * _operations(*chain(*columns))


def _operations(*values: Flat) -> int:
    return sum(1 for node in nodes(*values) if children(node))


def _inner(row: Sequence[Flat], column: Sequence[Flat], span: Span) -> Flat:
    terms: list[Flat] = [Binary("*", x, y, span) for x, y in zip(row, column, strict=True)]
    found = reduce(lambda x, y: Binary("+", x, y, span), terms) if terms else Number(0.0, None, span)
    is_plain = all(isinstance(x, Number) and x.unit is None for x in (*row, *column))
    return (folded(found) if is_plain else None) or found


def matrix_power(base: Flat, exponent: Flat, size: Size, span: Span, work: Work) -> Flat:
    """A^n of a square matrix, n a whole number from 0 on. Raises LagError L0303, L0209."""
    shape, n = shape_of(base, size), fold(exponent)
    if len(shape) != 2 or shape[0] != shape[1] or not isinstance(n, float | int) or not 0 <= n <= 100 or n != int(n):
        fail("L0303", f"{spoken(shape)} has no such power", span, "a square matrix has, of whole numbers; of element after "
             "element the power is .^")
    found: Flat = _identity(shape[0], span)
    for _ in range(int(n)):
        found = product(found, base, size, span, work)
    return found


def each(operator: str, left: Flat, right: Flat, size: Size, span: Span) -> Flat:
    """Element after element; a number goes with all. Raises LagError L0303."""
    a, b = length(left, size), length(right, size)
    if a is None and b is None:
        return Binary(_PLAIN[operator], left, right, span)
    if a is not None and b is not None and a != b:
        fail("L0303", f"{spoken(shape_of(left, size))} and {spoken(shape_of(right, size))} do not go together", span)
    pairs = ((element(left, k, size), element(right, k, size)) for k in range(1, (a if a is not None else b or 0) + 1))
    return Array(tuple(each(operator, x, y, size, span) for x, y in pairs), span)


def side_by_side(rows: Sequence[Sequence[Flat]], size: Size, span: Span) -> Array[Flat]:
    """[a, b; c, d], whose parts may be matrices, columns and numbers. Raises LagError L0303."""
    found: list[tuple[Flat, ...]] = []
    for row in rows:
        parts = [rows_of(part, size) for part in row]
        heights = {len(part) for part in parts}
        if len(heights) > 1:
            fail("L0303", f"parts of {' and '.join(map(str, sorted(heights)))} rows stand side by side",
                 row[0].span.to(row[-1].span))
        found += [tuple(x for line in lines for x in line) for lines in zip(*parts, strict=True)]
    widths = {len(row) for row in found}
    if len(widths) > 1:
        fail("L0303", f"rows of {' and '.join(map(str, sorted(widths)))} elements stand in one matrix", span,
             "rows are separated by ';', elements by ','")
    return _matrix(found, span)


def spoken(shape: tuple[int, ...]) -> str:
    """Sizes for people."""
    if not shape:
        return "a number"
    return f"an array of {shape[0]}" if len(shape) == 1 else f"a matrix of {' by '.join(map(str, shape))}"


# ------------------------------------------------------------ functions


def _count(node: Flat, least: int = 0) -> int:
    value = fold(node)
    if value is None:
        fail("L0210", "a size must be known when the scene is compiled", node.span,
             "use numbers, constants and Integer or Boolean parameters")
    if isinstance(value, bool) or value != int(value) or not least <= value <= _MOST_ELEMENTS:
        fail("L0209", f"a size is a whole number from {least} to {_MOST_ELEMENTS}, not {value:g}", node.span)
    return int(value)


def _integer(value: int, span: Span) -> Number:
    return Number(float(value), None, span, True)


def _fill(call: Call[Flat], size: Size) -> Flat:
    value, *sizes = call.arguments
    counts = [_count(n) for n in sizes]
    _refuse_many(counts, call.span)
    return reduce(lambda inner, n: Array((inner,) * n, call.span), reversed(counts), value)


def _refuse_many(counts: Sequence[int], span: Span) -> None:
    if prod(counts) > _MOST_ELEMENTS:
        fail("L0209", f"an array of more than {_MOST_ELEMENTS} elements", span)


def _filled(value: float) -> Callable[[Call[Flat], Size], Flat]:
    return lambda call, size: _fill(Call("fill", (Number(value, None, call.span, True), *call.arguments), (), call.span), size)


def _identity(n: int, span: Span) -> Array[Flat]:
    _refuse_many((n, n), span)
    return _matrix([[_integer(int(i == j), span) for j in range(n)] for i in range(n)], span)


def _linspace(call: Call[Flat], size: Size) -> Flat:
    first, last, n = call.arguments
    count, span = _count(n, 2), call.span
    step: Flat = Binary("/", Binary("-", last, first, span), _integer(count - 1, span), span)
    inner: list[Flat] = [Binary("+", first, Binary("*", _integer(k, span), step, span), span) for k in range(1, count - 1)]
    return Array((first, *inner, last), span)


def _size(call: Call[Flat], size: Size) -> Flat:
    shape = shape_of(call.arguments[0], size)
    if len(call.arguments) == 1:
        return Array(tuple(_integer(n, call.span) for n in shape), call.span)
    k = _count(call.arguments[1], 1)
    if k > len(shape):
        fail("L0303", f"{spoken(shape)} has no dimension {k}", call.span)
    return _integer(shape[k - 1], call.span)


def _transpose(call: Call[Flat], size: Size) -> Flat:
    _need(call, size, 2)
    return _matrix(list(zip(*rows_of(call.arguments[0], size), strict=True)), call.span)


def _diagonal(call: Call[Flat], size: Size) -> Flat:
    _need(call, size, 1)
    items, span = _items(call.arguments[0], size), call.span
    return _matrix([[x if i == j else _integer(0, span) for j in range(len(items))] for i, x in enumerate(items)], span)


def _outer(call: Call[Flat], size: Size) -> Flat:
    _need(call, size, 1)
    a, b = (_items(x, size) for x in call.arguments)
    return _matrix([[Binary("*", x, y, call.span) for y in b] for x in a], call.span)


def _skew(call: Call[Flat], size: Size) -> Flat:
    _need(call, size, 1, 3)
    (x, y, z), span, zero = _items(call.arguments[0], size), call.span, _integer(0, call.span)
    return _matrix([[zero, Unary("-", z, span), y], [z, zero, Unary("-", x, span)], [Unary("-", y, span), x, zero]], span)


def cross_of_three(call: Call[Flat], size: Size) -> Flat:
    """cross(a, b) in space; in the plane it is the number that frames/evaluation.py computes."""
    _need(call, size, 1, 3)
    a, b = (_items(x, size) for x in call.arguments)
    span = call.span

    def minor(i: int, j: int) -> Flat:
        return Binary("-", Binary("*", a[i], b[j], span), Binary("*", a[j], b[i], span), span)

    return Array((minor(1, 2), minor(2, 0), minor(0, 1)), span)


def _items(node: Flat, size: Size) -> tuple[Flat, ...]:
    full = written_out(node, size)
    return full.items if isinstance(full, Array) else (full,)


def _cat(call: Call[Flat], size: Size) -> Flat:
    k, *parts = call.arguments
    if _count(k, 1) > 2 or not parts:
        fail("L0303", "cat(1, ...) joins rows or vectors, cat(2, ...) columns", call.span)
    if _count(k, 1) == 2:
        return side_by_side([parts], size, call.span)
    ranks = {len(shape_of(part, size)) for part in parts}
    if ranks == {1}:
        return Array(tuple(x for part in parts for x in _items(part, size)), call.span)
    return side_by_side([[part] for part in parts], size, call.span)


def _scalar(call: Call[Flat], size: Size) -> Flat:
    found = _vector(call, size)
    if len(found.items) != 1:
        fail("L0303", f"{spoken(shape_of(call.arguments[0], size))} is no single number", call.span)
    return found.items[0]


def _vector(call: Call[Flat], size: Size) -> Array[Flat]:
    def all_of(node: Flat) -> tuple[Flat, ...]:
        return tuple(x for item in node.items for x in all_of(item)) if isinstance(node, Array) else (node,)

    return Array(all_of(written_out(call.arguments[0], size)), call.span)


def _need(call: Call[Flat], size: Size, rank: int, count: int | None = None) -> None:
    for argument in call.arguments:
        shape = shape_of(argument, size)
        if len(shape) != rank or (count is not None and shape[0] != count):
            wanted = "a matrix" if rank == 2 else f"an array of {count}" if count is not None else "an array"
            fail("L0303", f"{call.function} takes {wanted}, not {spoken(shape)}", argument.span)


# By name how many arguments a function takes (None: any number from the first), and what it makes of them.
ARRAY_FUNCTIONS: Mapping[str, tuple[tuple[int, ...] | None, Callable[[Call[Flat], Size], Flat]]] = {
    "fill": (None, _fill), "zeros": (None, _filled(0.0)), "ones": (None, _filled(1.0)),
    "identity": ((1,), lambda call, size: _identity(_count(call.arguments[0]), call.span)),
    "linspace": ((3,), _linspace), "size": ((1, 2), _size), "transpose": ((1,), _transpose), "diagonal": ((1,), _diagonal),
    "ndims": ((1,), lambda call, size: _integer(len(shape_of(call.arguments[0], size)), call.span)),
    "outerProduct": ((2,), _outer), "skew": ((1,), _skew), "cat": (None, _cat), "scalar": ((1,), _scalar),
    "vector": ((1,), _vector), "matrix": ((1,), lambda call, size: _matrix(rows_of(call.arguments[0], size), call.span)),
    "array": (None, lambda call, size: Array(call.arguments, call.span)),
}
