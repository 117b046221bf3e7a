"""Texts that are put together: "n = " + String(n) (Modelica 3.6, sections 3.7.1.2 and 10.6)."""

from collections.abc import Callable

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.folding import fold
from lagrangia.language.tree import Array, Binary, Boolean, Call, EnumerationLiteral, Expression, Flat, Number, String, Unary

_DIGITS = 6  # of a number, unless significantDigits says otherwise
_OPTIONS = ("significantDigits", "minimumLength", "leftJustified")


def text_of(call: Call[Flat]) -> String:
    """String(x) of what is known when the scene is compiled. Raises LagError L0210, L0215."""
    given = dict(call.named)
    if len(call.arguments) != 1 or given.keys() - set(_OPTIONS):
        fail("L0215", "String takes a number, true or false, or a value of an enumeration", call.span,
             f"write: String(x), or with {', '.join(_OPTIONS)}")
    (value,) = call.arguments
    text = _written(value, int(_number(given.get("significantDigits"), _DIGITS)))
    if text is None:
        fail("L0210", "a text is made of what is known when the scene is compiled", value.span,
             "numbers, constants and Integer or Boolean parameters; what an assertion says may name others")
    width = int(_number(given.get("minimumLength"), 0))
    is_left = fold(given["leftJustified"]) if "leftJustified" in given else True
    return String(text.ljust(width) if is_left else text.rjust(width), call.span)


def joined(left: Flat, right: Flat, span: Span) -> String:
    """a + b of texts. Raises LagError L0302."""
    for side in (left, right):
        if not isinstance(side, String):
            fail("L0302", "a text and something else cannot be added", side.span, 'write: "n = " + String(n)')
    assert isinstance(left, String) and isinstance(right, String)
    return String(left.value + right.value, span)


def said_by(node: Expression, known: Callable[[Expression], Flat | None]) -> str | None:
    """What a text says that may be made of numbers which a run alone knows: these are named, as their values stand beside it
    where it is told. None for what is no text; `known` is the value of an expression, None where a run alone knows it."""
    if isinstance(node, Binary) and node.operator == "+":
        sides = [said_by(side, known) for side in (node.left, node.right)]
        return None if None in sides else "".join(side or "" for side in sides)
    if isinstance(node, Call) and node.function == "String" and node.arguments and known(node.arguments[0]) is None:
        return " ".join(node.arguments[0].span.text.split())
    value = known(node)
    return value.value if isinstance(value, String) else None


def _written(value: Flat, digits: int) -> str | None:
    if isinstance(value, String):
        return value.value
    if isinstance(value, EnumerationLiteral):
        return value.name
    number = fold(value)
    if isinstance(number, bool) or isinstance(value, Boolean):
        return "true" if number else "false"
    if number is None:
        return None
    return str(int(number)) if _is_whole(value) else f"{number:.{max(1, digits)}g}"


def _is_whole(value: Flat) -> bool:
    """Whether an expression is an Integer, of which each digit counts."""
    match value:
        case Number(_, _, _, is_integer):
            return is_integer
        case Unary("-", operand, _):
            return _is_whole(operand)
        case Binary("+" | "-" | "*", left, right, _):
            return _is_whole(left) and _is_whole(right)
        case Call("floor" | "ceil", _, (), _):
            return True
        case Call("abs" | "mod" | "min" | "max" | "sum" | "product", arguments, (), _) | Array(arguments, _):
            return all(map(_is_whole, arguments))
    return False


def _number(value: Flat | None, usual: int) -> float:
    """Of an option. Raises LagError L0210."""
    found = fold(value) if value is not None else float(usual)
    if found is None:
        fail("L0210", "this must be known when the scene is compiled", value.span if value is not None else None)
    return float(found)
