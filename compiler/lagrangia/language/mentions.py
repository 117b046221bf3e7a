"""Walking flat expressions: what an expression mentions, directly or through the variables it names."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, IfExpression, Ref, Time, Unary

_CHILDREN: Mapping[type, Callable[[Any], tuple[Flat, ...]]] = {
    Unary: lambda node: (node.operand,),
    Binary: lambda node: (node.left, node.right),
    IfExpression: lambda node: (node.condition, node.then, node.otherwise),
    Call: lambda node: node.arguments,
    Array: lambda node: node.items,
}

_LEAVES = frozenset({Ref, FrameRef, Time})


def children(node: Flat) -> tuple[Flat, ...]:
    """The expressions that an expression is made of."""
    inside = _CHILDREN.get(node.__class__)
    return inside(node) if inside is not None else ()


def nodes(*roots: Flat) -> Iterator[Flat]:
    """Every node of the expressions, each shared node once for each place it stands in."""
    stack, known = list(roots), _CHILDREN.get
    while stack:
        node = stack.pop()
        yield node
        if (inside := known(node.__class__)) is not None:
            stack.extend(inside(node))


def reached(roots: Iterable[Flat], bindings: Mapping[str, Flat | None]) -> Iterator[Flat]:
    """Every node of the expressions, going through `bindings` (each once) of the variables they name."""
    seen: set[str] = set()
    pending = list(roots)
    while pending:
        for node in nodes(pending.pop()):
            yield node
            if node.__class__ is Ref and node.name not in seen:
                seen.add(node.name)
                binding = bindings.get(node.name)
                if binding is not None:
                    pending.append(binding)


def leaves(roots: Iterable[Flat], bindings: Mapping[str, Flat | None]) -> list[Ref | FrameRef | Time]:
    """The leaves among them: the same walk, in a third of the time, as most that is asked of large scenes is leaves."""
    seen: set[str] = set()
    pending, found, known = list(roots), list[Ref | FrameRef | Time](), _CHILDREN.get
    while pending:
        stack = [pending.pop()]
        while stack:
            node = stack.pop()
            if (inside := known(node.__class__)) is not None:
                stack.extend(inside(node))
            elif node.__class__ in _LEAVES:
                found.append(node)  # type: ignore[arg-type]
                if node.__class__ is Ref and node.name not in seen:
                    seen.add(node.name)
                    if (binding := bindings.get(node.name)) is not None:
                        pending.append(binding)
    return found


def is_linear(node: Flat, name: str) -> bool:
    """Whether the expression, seen through operators and arrays alone, is linear in the variable."""
    return (_degree(node, name) or 0) <= 1 and _degree(node, name) is not None


def _degree(node: Flat, name: str) -> int | None:
    """0 without the variable, 1 when linear in it, None when neither or unknown."""
    if not any(isinstance(inner, Ref) and inner.name == name for inner in nodes(node)):
        return 0
    match node:
        case Ref():
            return 1
        case Array(items, _):
            return None if any(_degree(item, name) is None for item in items) else 1
        case Unary("-", operand, _):
            return _degree(operand, name)
        case Binary("+" | "-", left, right, _):
            return None if None in (_degree(left, name), _degree(right, name)) else 1
        case Binary("*", left, right, _):
            degrees = _degree(left, name), _degree(right, name)
            return 1 if degrees in ((0, 1), (1, 0)) else None
        case Binary("/", left, right, _):
            return 1 if (_degree(left, name), _degree(right, name)) == (1, 0) else None
    return None


def read_now(roots: Iterable[Flat], bindings: Mapping[str, Flat | None]) -> Iterator[str]:
    """The variables that expressions read at an instant, going through `bindings`, but for those under pre(...)."""
    seen, stack = set[tuple[str, tuple[int, ...]]](), [*roots]
    while stack:
        node = stack.pop()
        if isinstance(node, Ref) and (node.name, node.index) not in seen:
            seen.add((node.name, node.index))
            yield node.name
            binding = bindings.get(node.name)
            for k in node.index:
                binding = binding.items[k - 1] if isinstance(binding, Array) else binding
            if binding is not None:
                stack.append(binding)
        elif not (isinstance(node, Call) and node.function == "pre"):
            stack += children(node)


def rebuilt(node: Flat, change: Callable[[Flat], Flat | None]) -> Flat:
    """An expression with what `change` gives in the places of its parts, from outside in; what that gives None for stays."""
    if (new := change(node)) is not None:
        return new
    match node:
        case Unary(operator, operand, span):
            return Unary(operator, rebuilt(operand, change), span)
        case Binary(operator, left, right, span):
            return Binary(operator, rebuilt(left, change), rebuilt(right, change), span)
        case IfExpression(condition, then, otherwise, span):
            return IfExpression(rebuilt(condition, change), rebuilt(then, change), rebuilt(otherwise, change), span)
        case Call(function, arguments, named, span):
            return Call(function, tuple(rebuilt(x, change) for x in arguments), named, span)
        case Array(items, span):
            return Array(tuple(rebuilt(x, change) for x in items), span)
    return node
