"""Formulas as they stand on paper: a small tree of products, sums, fractions and matrices, in the order a reader wants.

SymPy orders sums and products to its own liking; here the order is kept. typeset.py prints the tree as text, LaTeX or MathML.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TypeAlias

from lagrangia.base.records import dataclass

_DEEPEST = 3  # brackets in brackets that are opened to break a line
_INDENT = 4  # of lines that go on
_LOWER = ("alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigmaf sigma tau upsilon phi "
          "chi psi omega").split()
_SCRIPT = {"D": "𝒟", "E": "ℰ", "H": "ℋ", "L": "ℒ", "T": "𝒯", "V": "𝒱"}
LETTERS = {name: chr(code) for name, code in zip(_LOWER, range(0x3B1, 0x3CA), strict=True)} | {
    "vartheta": "ϑ", "ell": "ℓ", "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ",
    "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω"} | {f"script {letter}": shown for letter, shown in _SCRIPT.items()}


@dataclass(frozen=True)
class Name:
    """A symbol: theta'', k_1, M(t). `marks` counts the primes or dots; vectors and matrices are bold."""

    base: str
    sub: str = ""
    marks: int = 0
    argument: str = ""
    is_bold: bool = False
    prefix: str = ""


@dataclass(frozen=True)
class Words:
    """Plain text in a formula."""

    text: str


@dataclass(frozen=True)
class Phrase:
    """Words of the pages' own in English, {0} and {1} for what comes from the scene, until phrases.spoken tells them."""

    text: str
    values: tuple["Node | str | tuple[Node | str, ...]", ...] = ()


@dataclass(frozen=True)
class Letter:
    """The letter of another formula, by the label that it has until document.lettered puts the letter in: (a)."""

    label: str


@dataclass(frozen=True)
class Numeral:
    """An exact number, or with `digits` a decimal one of so many significant digits."""

    value: Fraction
    digits: int = 0


@dataclass(frozen=True)
class Product:
    """Factors side by side."""

    items: tuple["Node", ...]


@dataclass(frozen=True)
class Total:
    """A sum of terms, each with its sign."""

    items: tuple[tuple[int, "Node"], ...]


@dataclass(frozen=True)
class Quotient:
    """A fraction."""

    top: "Node"
    bottom: "Node"


@dataclass(frozen=True)
class Power:
    """A base with an exponent."""

    base: "Node"
    exponent: "Node"


@dataclass(frozen=True)
class Apply:
    """A function of an argument: sin theta, with `power` sin^2 theta."""

    function: str
    argument: "Node"
    power: int = 1


@dataclass(frozen=True)
class Root:
    """A square root."""

    inside: "Node"


@dataclass(frozen=True)
class Bracket:
    """What stands in parentheses."""

    inside: "Node"


@dataclass(frozen=True)
class Listing:
    """(a, b, c)"""

    items: tuple["Node", ...]


@dataclass(frozen=True)
class Grid:
    """A matrix, or a column."""

    rows: tuple[tuple["Node", ...], ...]


@dataclass(frozen=True)
class Cases:
    """Values with their conditions; the last condition may be None: otherwise."""

    items: tuple[tuple["Node", "Node | None"], ...]
    words: tuple[str, str] = ("for", "otherwise")


@dataclass(frozen=True)
class Slope:
    """d top / d bottom; partial unless `is_total`. Without a top it is the operator."""

    top: "Node | None"
    bottom: "Node"
    is_total: bool = False


@dataclass(frozen=True)
class Relation:
    """left = right, or any other symbol between them."""

    left: "Node"
    right: "Node"
    symbol: str = "="


@dataclass(frozen=True)
class Pieces:
    """A formula, or a part of one, as signs and terms in a row: what a long line is broken into."""

    items: tuple[tuple[str, "Node"], ...]


Node: TypeAlias = (Name | Words | Phrase | Letter | Numeral | Product | Total | Quotient | Power | Apply | Root | Bracket | Grid
                   | Cases | Slope | Relation | Pieces | Listing)

ZERO, ONE = Numeral(Fraction(0)), Numeral(Fraction(1))


def product(items: Sequence[Node]) -> Node:
    """The product of the items; sums in it get brackets."""
    items = [Bracket(x) if isinstance(x, Total) else x for x in items]
    return items[0] if len(items) == 1 else Product(tuple(items)) if items else ONE


def total(items: Sequence[tuple[int, Node]]) -> Node:
    """The sum of signed terms; none is 0."""
    return Total(tuple(items)) if len(items) > 1 or (items and items[0][0] < 0) else items[0][1] if items else ZERO


def added(*nodes: Node) -> Node:
    """The sum of nodes, sums among them opened, zeros left out."""
    items: list[tuple[int, Node]] = []
    for node in nodes:
        items += node.items if isinstance(node, Total) else () if node == ZERO else [(1, node)]
    return total(items)


def broken(node: Node, size: Callable[[Node], float], width: float) -> list[Node]:
    """A relation of long sums as lines of no more than `width`, as far as its terms allow; one with a matrix stays whole."""
    if size(node) <= width or not isinstance(node, Relation) or has_grid(node):
        return [node]
    pieces = [*_pieces(node.left, ""), *_pieces(node.right, node.symbol)]
    for _ in range(_DEEPEST):
        pieces = [part for piece in pieces
                  for part in (_opened(piece, size) if _size(piece, size) > width - _INDENT else [piece])]
    lines: list[list[tuple[str, Node]]] = [[]]
    length = 0.0
    for piece in pieces:
        this = _size(piece, size)
        if lines[-1] and length + this > width:
            lines.append([])
            length = _INDENT
        lines[-1].append(piece)
        length += this
    return [Pieces(tuple(items)) for items in lines]


def has_grid(node: Node) -> bool:
    """Whether a matrix or cases stand in a formula."""
    return isinstance(node, Grid | Cases) or (isinstance(node, Relation) and (has_grid(node.left) or has_grid(node.right))) or \
        any(has_grid(item) for item in getattr(node, "items", ()) if not isinstance(item, tuple | int))


def _size(piece: tuple[str, Node], size: Callable[[Node], float]) -> float:
    return size(piece[1]) + len(piece[0]) + 2


def _opened(piece: tuple[str, Node], size: Callable[[Node], float]) -> list[tuple[str, Node]]:
    """The longest bracket of a product, its power or the top of a fraction, by its terms."""
    sign, node = piece
    if isinstance(node, Pieces):
        return _opened_within(sign, node, size)
    items = node.items if isinstance(node, Product) else (node,)
    sums = {k: found for k, item in enumerate(items) for found in [_sum_in(item)] if found is not None}
    if not sums:
        return [piece]
    where = max(sums, key=lambda k: size(sums[k][1]))
    leading, inside, closing = sums[where]
    before, after = (*items[:where], *leading), items[where + 1 :]
    (first_sign, first), *rest = _pieces(inside, "")
    opening = f"({first_sign}"
    start = Pieces((("", product(before)), (opening, first))) if before else Pieces(((opening, first),))
    *middle, (last_sign, last) = rest
    end = Pieces((("", last), (")", product([*closing, *after]) if closing or after else Words(""))))
    return [(sign, start), *middle, (last_sign, end)]


def _opened_within(sign: str, node: Pieces, size: Callable[[Node], float]) -> list[tuple[str, Node]]:
    """The longest of some pieces opened; the others stay where they are."""
    where = max(range(len(node.items)), key=lambda k: size(node.items[k][1]))
    first, *rest = _opened(node.items[where], size)
    before, after = (*node.items[:where], first), node.items[where + 1 :]
    if not rest:
        return [(sign, node)]
    *middle, (last_sign, last) = rest
    return [(sign, Pieces(before)), *middle, (last_sign, Pieces((("", last), *after)) if after else last)]


def _sum_in(node: Node) -> tuple[list[Node], Total, list[Node]] | None:
    """What leads to the sum of a bracket, its power or a fraction, the sum, and what stands behind its closing bracket."""
    match node:
        case Total() | Bracket(Total()):
            found = node.inside if isinstance(node, Bracket) else node
            return ([], found, []) if isinstance(found, Total) else None
        case Power(Bracket(Total() as inside), exponent):
            return [], inside, [Power(Words(""), exponent)]
        case Quotient(Total() as inside, bottom) | Quotient(Bracket(Total() as inside), bottom):
            return [], inside, [Quotient(Words(""), bottom)]
        case Apply("δ", Bracket(Total() as inside)):
            return [Name("δ")], inside, []
    return None


def _pieces(node: Node, first: str) -> list[tuple[str, Node]]:
    if isinstance(node, Relation):
        return [*_pieces(node.left, first), *_pieces(node.right, node.symbol)]
    items = node.items if isinstance(node, Total) else ((1, node),)
    signs = ["−" if sign < 0 else "+" for sign, _ in items]
    signs[0] = first + (" −" if first and items[0][0] < 0 else "−" if items[0][0] < 0 else "")
    return [(sign, Bracket(item) if isinstance(item, Total) else item) for sign, (_, item) in zip(signs, items, strict=True)]


def negative(node: Node) -> Node:
    """With its sign turned; of a sum, each term's."""
    if node == ZERO:
        return node
    return total([(-sign, item) for sign, item in node.items]) if isinstance(node, Total) else Total(((-1, node),))
