"""Layout -> MathML Core, as browsers render it without a script."""

from fractions import Fraction
from html import escape

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
from lagrangia.paper.typeset import FUNCTIONS, bold_letter, decimal, is_loose
from lagrangia.paper.widths import is_tall


def mathml(node: Node) -> str:
    """MathML Core, as browsers render it without a script."""
    match node:
        case Name():
            return _mathml_name(node)
        case Words(words):
            return f"<mtext>{escape(words)}</mtext>"
        case Numeral(value, digits):
            return _mathml_number(value, digits)
        case Product(items):
            return _row('<mspace width="0.17em"/>'.join(_mathml_factor(item) for item in items))
        case Total(items):
            return _row("".join(_mathml_sign(sign, k) + mathml(item) for k, (sign, item) in enumerate(items)))
        case Quotient(top, bottom):
            return f"<mfrac>{mathml(top)}{mathml(bottom)}</mfrac>"
        case Power(base, exponent):
            return f"<msup>{_mathml_tight(base)}{mathml(exponent)}</msup>"
        case Apply(function, argument, power):
            if function == "abs":
                return _fenced(mathml(argument), "|", "|", is_tall(argument))
            name = f"<mi>{escape(function)}</mi>"
            raised = f"<msup>{name}<mn>{power}</mn></msup>" if power != 1 else name
            is_bare = isinstance(argument, Bracket | Listing) or (isinstance(argument, Name) and function in FUNCTIONS)
            inside = mathml(argument) if is_bare else _bracketed(argument)
            return _row(f'{raised}<mspace width="0.12em"/>{inside}')
        case Root(inside):
            return f"<msqrt>{mathml(inside)}</msqrt>"
        case Bracket(inside):
            return _bracketed(inside)
        case Listing(items):
            return _fenced('<mo separator="true">,</mo>'.join(map(mathml, items)), tall=is_tall(node))
        case _:
            return _mathml_large(node)


def _mathml_large(node: Node) -> str:
    match node:
        case Grid(rows):
            return _fenced(_table(rows), "[", "]")
        case Cases(items, (where, otherwise)):
            conditions = [f"<mtext>{where}&#160;</mtext>{mathml(when)}" if when is not None else f"<mtext>{otherwise}</mtext>"
                          for _, when in items]
            lines = [f"<mtr><mtd>{mathml(value)}</mtd><mtd>{when}</mtd></mtr>"
                     for (value, _), when in zip(items, conditions, strict=True)]
            return _row(f'<mo stretchy="true">{{</mo><mtable>{"".join(lines)}</mtable>')
        case Slope(top, bottom, is_total):
            d = '<mi mathvariant="normal">d</mi>' if is_total else "<mo>∂</mo>"
            return f"<mfrac>{_row(d + (mathml(top) if top is not None else ''))}{_row(d + mathml(bottom))}</mfrac>"
        case Relation(left, right, symbol):
            return _row(f"{mathml(left)}<mo>{escape(symbol)}</mo>{mathml(right)}")
        case Pieces(items):
            return _row("".join("".join(_sign(s) for s in signs.split()) + mathml(item)
                                for signs, item in items))
        case _:
            raise AssertionError(node)


def _sign(sign: str) -> str:
    form = {"(": "prefix", ")": "postfix"}.get(sign, "infix")
    return f'<mo form="{form}" stretchy="false">{escape(sign)}</mo>'


def _table(rows: tuple[tuple[Node, ...], ...]) -> str:
    lines = ["".join(f"<mtd>{mathml(cell)}</mtd>" for cell in row) for row in rows]
    return "<mtable>" + "".join(f"<mtr>{line}</mtr>" for line in lines) + "</mtable>"


def _row(inside: str) -> str:
    return f"<mrow>{inside}</mrow>"


def _bracketed(inside: Node) -> str:
    return _fenced(mathml(inside), tall=is_tall(inside))


def _fenced(inside: str, left: str = "(", right: str = ")", tall: bool = True) -> str:
    """Brackets stretch around what is tall alone: others get wide gaps of it."""
    grows = "true" if tall else "false"
    return _row(f'<mo form="prefix" stretchy="{grows}">{left}</mo>{inside}<mo form="postfix" stretchy="{grows}">{right}</mo>')


def _mathml_word(base: str) -> str:
    shown = LETTERS.get(base, base)
    return f"<mi>{escape(shown)}</mi>"  # of several letters: upright by itself


def _mathml_name(name: Name) -> str:
    base = f"<mi>{bold_letter(name.base)}</mi>" if name.is_bold else _mathml_word(name.base)
    if name.marks:
        base = f'<mover>{base}<mo stretchy="false">{"˙¨"[name.marks - 1]}</mo></mover>'
    if name.sub:
        sub = _row('<mo separator="true">,</mo>'.join(
            f"<mn>{part}</mn>" if part.isdigit() else _mathml_word(part) for part in name.sub.split()))
        base = f"<msub>{base}{sub}</msub>"
    base = _row(f'<mi mathvariant="normal">{name.prefix}</mi>{base}') if name.prefix else base
    return _row(base + _fenced(f"<mi>{name.argument}</mi>", tall=False)) if name.argument else base


def _mathml_number(value: Fraction, digits: int) -> str:
    if digits:
        mantissa, _, exponent = decimal(value, digits).partition("e")
        shown = f"<mn>{mantissa}</mn>"
        return _row(f"{shown}<mo>·</mo><msup><mn>10</mn><mn>{int(exponent)}</mn></msup>") if exponent else shown
    if value.denominator == 1:
        return f"<mn>{value.numerator}</mn>"
    return f'<mfrac displaystyle="false"><mn>{value.numerator}</mn><mn>{value.denominator}</mn></mfrac>'


def _mathml_sign(sign: int, place: int) -> str:
    if place == 0:
        return '<mo form="prefix">−</mo>' if sign < 0 else ""
    return f"<mo>{'−' if sign < 0 else '+'}</mo>"


def _mathml_factor(node: Node) -> str:
    return _bracketed(node) if isinstance(node, Total) else mathml(node)


def _mathml_tight(node: Node) -> str:
    return _bracketed(node) if is_loose(node) else mathml(node)
