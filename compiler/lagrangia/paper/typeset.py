"""Layout -> Unicode text for a terminal."""

from decimal import Decimal
from fractions import Fraction

from lagrangia.base.records import dataclass
from lagrangia.paper.layout import (
    LETTERS,
    Apply,
    Bracket,
    Cases,
    Grid,
    Listing,
    Name,
    Node,
    Numeral,
    Pieces,
    Power,
    Product,
    Quotient,
    Relation,
    Root,
    Slope,
    Total,
    Words,
)

_SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_SUBSCRIPT = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_VULGAR = {(1, 2): "½", (1, 3): "⅓", (2, 3): "⅔", (1, 4): "¼", (3, 4): "¾", (1, 5): "⅕", (1, 6): "⅙", (1, 8): "⅛", (3, 8): "⅜"}
FUNCTIONS = {"sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "ln", "min", "max"}


def decimal(value: Fraction, digits: int) -> str:
    """A number to so many digits."""
    try:
        return f"{float(value):.{digits}g}"
    except OverflowError:
        return f"{Decimal(value.numerator) / Decimal(value.denominator):.{digits}g}"


@dataclass(frozen=True)
class Box:
    """Lines of text of one width; `axis` is the line that stands beside others."""

    lines: tuple[str, ...]
    axis: int = 0

    @property
    def width(self) -> int:
        """In columns of the terminal."""
        return len(self.lines[0])

    def __str__(self) -> str:
        return "\n".join(line.rstrip() for line in self.lines)


def beside(*boxes: Box) -> Box:
    """The boxes in a row, on a common axis."""
    above = max(box.axis for box in boxes)
    below = max(len(box.lines) - box.axis for box in boxes)
    padded = [[" " * box.width] * (above - box.axis) + list(box.lines) + [" " * box.width] * (below - len(box.lines) + box.axis)
              for box in boxes]
    return Box(tuple("".join(row) for row in zip(*padded, strict=True)), above)


def text(node: Node) -> Box:
    """Unicode text, on one line but for matrices and cases."""
    match node:
        case Grid(rows):
            return _text_grid(rows)
        case Cases(items, words):
            return _text_cases(items, words)
        case Relation(left, right, symbol):
            return beside(text(left), Box((f" {symbol} ",)), text(right))
        case Product(items) if any(_is_tall(item) for item in items):
            spaced = [box for item in items for box in (Box((" ",)), text(item))]
            return beside(*spaced[1:])
        case Total(items) if any(_is_tall(item) for _, item in items):
            spaced = [box for k, (sign, item) in enumerate(items) for box in (Box((sign_text(sign, k),)), text(item))]
            return beside(*spaced)
        case _:
            return Box((line(node),))


def _is_tall(node: Node) -> bool:
    return isinstance(node, Grid | Cases) or (isinstance(node, Product) and any(map(_is_tall, node.items)))


def sign_text(sign: int, place: int) -> str:
    """The sign before a term of a sum; of the first one only a minus."""
    return ("− " if sign < 0 else "") if place == 0 else (" − " if sign < 0 else " + ")


def line(node: Node) -> str:
    """A formula without matrices on one line."""
    match node:
        case Name():
            return _text_name(node)
        case Words(words):
            return words
        case Numeral(value, digits):
            return _text_decimal(value, digits) if digits else _text_number(value)
        case Product(items):
            return " ".join(map(_text_factor, items))
        case Total(items):
            return "".join(sign_text(sign, k) + line(item) for k, (sign, item) in enumerate(items))
        case Quotient(top, bottom):
            return f"{_text_factor(top)}/{_text_tight(bottom)}"
        case Power(base, exponent):
            return _text_tight(base) + _text_exponent(exponent)
        case Apply():
            return _text_applied(node)
        case Root(inside):
            return f"√{line(inside)}" if isinstance(inside, Name | Numeral) else f"√({line(inside)})"
        case Bracket(inside):
            return f"({line(inside)})"
        case Listing(items):
            return f"({', '.join(map(line, items))})"
        case Slope(top, bottom, is_total):
            d = "d" if is_total else "∂"
            return f"{d}{line(top) if top else ''}/{d}{line(bottom)}"
        case Relation(left, right, symbol):
            return f"{line(left)} {symbol} {line(right)}"
        case Pieces(items):
            parts = " ".join(f"{sign} {line(item)}" if sign else line(item) for sign, item in items)
            for loose, tight in (("( ", "("), ("(− ", "(−"), (" )", ")"), (") ²", ")²"), (") /", ")/"), (") ^", ")^")):
                parts = parts.replace(loose, tight)
            return parts.rstrip()
        case _:
            return " ".join(text(node).lines)


def _text_applied(node: Apply) -> str:
    function, argument = node.function, node.argument
    if function == "abs":
        return f"|{line(argument)}|"
    raised = str(node.power).translate(_SUPERSCRIPT) if node.power != 1 else ""
    if isinstance(argument, Bracket | Listing):
        return f"{function}{raised}{line(argument)}"
    is_short = isinstance(argument, Name) and not argument.argument and function in FUNCTIONS
    return f"{function}{raised} {line(argument)}" if is_short else f"{function}{raised}({line(argument)})"


def _text_name(name: Name) -> str:
    base = bold_letter(name.base) if name.is_bold else LETTERS.get(name.base, name.base)
    sub = ",".join(LETTERS.get(part, part) for part in name.sub.split())
    shown = sub.translate(_SUBSCRIPT) if sub.isdigit() else f"_{sub}" if sub else ""
    return name.prefix + base + shown + "'" * name.marks + (f"({name.argument})" if name.argument else "")


def bold_letter(base: str) -> str:
    """A letter in the bold of Unicode's mathematical alphabets."""
    if base in LETTERS:
        return {"lambda": "𝛌", "Phi": "𝚽"}.get(base, LETTERS[base])
    return "".join(chr(0x1D400 + ord(c) - 65) if c.isupper() else chr(0x1D41A + ord(c) - 97) for c in base)


def _text_number(value: Fraction) -> str:
    if value.denominator == 1:
        return str(value.numerator)
    return _VULGAR.get((value.numerator, value.denominator), f"{value.numerator}/{value.denominator}")


def _text_decimal(value: Fraction, digits: int) -> str:
    mantissa, _, exponent = decimal(value, digits).partition("e")
    return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}" if exponent else mantissa


def _text_factor(node: Node) -> str:
    return f"({line(node)})" if isinstance(node, Total) else line(node)


def is_loose(node: Node) -> bool:
    """Needs brackets before an exponent or under a line."""
    if isinstance(node, Apply) and node.function == "abs":
        return False
    if isinstance(node, Numeral) and node.digits:
        return "e" in decimal(node.value, node.digits)
    return isinstance(node, Total | Product | Quotient | Apply) or (isinstance(node, Numeral) and node.value.denominator != 1)


def _text_tight(node: Node) -> str:
    return f"({line(node)})" if is_loose(node) else line(node)


def _text_exponent(node: Node) -> str:
    if node == Words("T"):
        return "ᵀ"
    if isinstance(node, Numeral) and node.value.denominator == 1:
        return str(node.value.numerator).translate(_SUPERSCRIPT)
    return f"^{_text_tight(node)}"


def _text_grid(rows: tuple[tuple[Node, ...], ...]) -> Box:
    cells = [[line(cell) for cell in row] for row in rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
    inner = ["  ".join(cell.center(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
    count = len(inner)
    if count == 1:
        return Box((f"[ {inner[0]} ]",))
    left = ["⎡", *"⎢" * (count - 2), "⎣"]
    right = ["⎤", *"⎥" * (count - 2), "⎦"]
    return Box(tuple(f"{a} {b} {c}" for a, b, c in zip(left, inner, right, strict=True)), (count - 1) // 2)


def _text_cases(items: tuple[tuple[Node, Node | None], ...], words: tuple[str, str]) -> Box:
    values = [line(value) for value, _ in items]
    width = max(map(len, values))
    lines = [f"{value.ljust(width)}  {f'{words[0]} {line(when)}' if when is not None else words[1]}"
             for value, (_, when) in zip(values, items, strict=True)]
    longest = max(map(len, lines))
    braces = ["{"] if len(lines) == 1 else ["⎰", "⎱"] if len(lines) == 2 else ["⎧", *"⎨" * (len(lines) - 2), "⎩"]
    return Box(tuple(f"{brace} {item.ljust(longest)}" for brace, item in zip(braces, lines, strict=True)), (len(lines) - 1) // 2)


