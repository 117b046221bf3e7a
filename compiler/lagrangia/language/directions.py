"""Parameters that are directions: vectors of numbers by whose length something is divided, or about which frames turn.

Those of no length say nothing: conditions that are divided by it are never true, and a component is not there without a word.
What stands in branches of choices may be meant for others alone, as d/norm(d) where d is not 0: it tells nothing.
"""

from collections.abc import Iterator

from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import children
from lagrangia.language.tree import Binary, Call, Flat, IfExpression, Ref

_SHAPES = ((2,), (3,))


def directions(model: FlatModel) -> list[str]:
    """Their names, in the order of the variables."""
    may_be = {v.name for v in model.variables.values() if v.kind == "parameter" and v.shape in _SHAPES and v.unit in ("", "1")}
    if not may_be:
        return []
    bindings = (v.binding for v in model.variables.values() if v.binding is not None)
    found = {name for node in _certain(*model.stated(), *bindings) for name in _named(node) if name in may_be}
    return [name for name in model.variables if name in found]


def _certain(*roots: Flat) -> Iterator[Flat]:
    """Every node that is computed whatever is chosen: none within branches."""
    stack = list(roots)
    while stack:
        node = stack.pop()
        yield node
        stack += (node.condition,) if isinstance(node, IfExpression) else children(node)


def _named(node: Flat) -> Iterator[str]:
    """Directions that this node alone tells."""
    vectors: tuple[Flat, ...] = ()
    if isinstance(node, Binary) and node.operator == "/" and isinstance(node.right, Call) and node.right.function == "norm":
        vectors = node.right.arguments
    elif isinstance(node, Call) and node.function == "turn":
        vectors = node.arguments[2:3]
    yield from (vector.name for vector in vectors if isinstance(vector, Ref) and not vector.index)
