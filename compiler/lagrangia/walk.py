"""Walking flat expressions: what an expression mentions, directly or through the variables it names."""

from collections.abc import Iterable, Iterator, Mapping

from lagrangia.tree import Array, Binary, Call, Flat, FrameRef, IfExpression, Ref, Time, Unary


def children(node: Flat) -> tuple[Flat, ...]:
    match node:
        case Unary(_, operand, _):
            return (operand,)
        case Binary(_, left, right, _):
            return (left, right)
        case IfExpression(condition, then, otherwise, _):
            return (condition, then, otherwise)
        case Call(_, arguments, _, _):
            return arguments
        case Array(items, _):
            return items
    return ()


def nodes(*roots: Flat) -> Iterator[Flat]:
    """Every node of the expressions, each shared node once for each place it stands in."""
    stack = list(roots)
    while stack:
        node = stack.pop()
        yield node
        stack.extend(children(node))


def leaves(roots: Iterable[Flat], bindings: Mapping[str, Flat | None]) -> list[Ref | FrameRef | Time]:
    """The leaves reached from the expressions, going through `bindings` (each once) of the variables they name."""
    found: list[Ref | FrameRef | Time] = []
    seen: set[str] = set()
    pending = list(roots)
    while pending:
        for node in nodes(pending.pop()):
            if isinstance(node, Ref | FrameRef | Time):
                found.append(node)
            if isinstance(node, Ref) and node.name not in seen:
                seen.add(node.name)
                binding = bindings.get(node.name)
                if binding is not None:
                    pending.append(binding)
    return found
