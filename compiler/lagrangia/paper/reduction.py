"""What is left where all coordinates but one are cyclic: their rates by constant momenta, and an effective potential.

M_cc = L D L^T of the cyclic coordinates; with r = L^-1 p their rates are L^-T D^-1 r, and E = M q'^2/2 + V + sum r^2/(2 d).
Source: E.J. Routh, A Treatise on the Stability of a Given State of Motion (1877).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.paper.book import WIDEST_MATRIX, WIDEST_TYPESET, Book, constants_block, equal
from lagrangia.paper.document import Block, Display, display, paragraph, say
from lagrangia.paper.layout import Bracket, Name, Node, Numeral, Power, Product, Quotient, Relation, Total, added, product
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.typeset import text
from lagrangia.paper.widths import typeset_width

_TWO = Numeral(Fraction(2))


def constants_and_rest(book: Book, level: int = 2) -> list[Block]:
    """Constants of the motion, and what they leave to move where that is one coordinate."""
    return [*constants_block(book, level), *_reduced(book)]


def _reduced(book: Book) -> list[Block]:
    e = book.equations
    cyclic = [c.coordinate for c in book.constants if c.name == "momentum" and c.coordinate is not None]
    is_closed = any(c.name == "energy" and c.why == "conservative" for c in book.constants)
    left = [k for k in range(e.n) if k not in cyclic]
    if len(left) != 1 or not cyclic or not is_closed or e.rows or any(e.M[left[0]][j] != 0 for j in cyclic):
        return []
    factors = _factored(book, sorted(cyclic, key=lambda j: bool(e.M[j][j].free_symbols & set(e.scene.q))))
    return _laid_out(book, left[0], *factors) if factors is not None else []


def _factored(book: Book, order: list[int]) -> tuple[list[int], dict[tuple[int, int], Expr], dict[int, Expr]] | None:
    """L below its diagonal and D; None where a pivot that others are divided by is a sum."""
    e, tidy = book.equations, book.equations.ring.tidy
    S = {(i, j): e.M[i][j] for i in order for j in order}
    L: dict[tuple[int, int], Expr] = {}
    for place, i in enumerate(order[:-1]):
        if len(e.ring.terms(S[i, i])) != 1:
            return None
        for j in order[place + 1 :]:
            L[j, i] = tidy(S[j, i] / S[i, i])
        for j in order[place + 1 :]:
            for k in order[place + 1 :]:
                S[j, k] = tidy(S[j, k] - L[j, i] * S[i, k])
    return order, L, {i: S[i, i] for i in order}


def _laid_out(book: Book, left: int, order: list[int], L: dict[tuple[int, int], Expr], D: dict[int, Expr]) -> list[Block]:
    e, s = book.equations, book.presentation.symbols
    names = {j: Name("p", " ".join(filter(None, (book.q[j].base, book.q[j].sub)))) for j in order}
    p = {j: sp.Symbol(f"momentum {j}", real=True) for j in order}
    known = Presentation(replace(s, names=dict(s.names) | {p[j]: names[j] for j in order}), book.presentation.most_products,
                         book.presentation.ring)
    r: dict[int, Expr] = {}
    for j in order:
        r[j] = e.ring.tidy(p[j] - sum((L[j, i] * r[i] for i in order if (j, i) in L), sp.S.Zero))
    V = e.ring.tidy(e.V_elastic + e.V_field)
    moving = product([_scaled(book.presentation.coefficient, e.M[left][left], sp.S.Half), Power(book.rate(left), _TWO)])

    def lines(inertia: Mapping[int, Node]) -> list[Node]:
        found: list[Node] = []
        for j in reversed(order):
            others = [known.sum(e.ring.tidy(-L[i, j] * e.scene.v[i])) for i in order if (i, j) in L]
            found.append(equal(book.rate(j), added(Quotient(known.sum(r[j]), inertia[j]), *others)))
        squares = [Quotient(Power(_bracketed(known.sum(r[j])), _TWO), twice(j, inertia[j])) for j in reversed(order)]
        found.append(equal(effective, added(*([book.sum(V)] if V != 0 else []), *squares)))
        return [*found, equal(book.own("E"), added(moving, effective))]

    def twice(j: int, inertia: Node) -> Node:
        return product([_TWO, inertia]) if isinstance(inertia, Name) else _scaled(known.sum, D[j], sp.Integer(2))

    effective = book.own("V", "eff")
    whole: dict[int, Node] = {j: known.sum(D[j]) for j in order}
    short = {j: Name("J", names[j].sub) if _factor(x) is not x else x for j, x in whole.items()}
    told = lines(whole)
    inside: list[Block] = []
    if not all(map(_fits, told)):
        told = lines(short)
        inside = [paragraph(say("with")), *display([equal(short[j], whole[j]) for j in order if short[j] is not whole[j]])]
        if not all(_fits(part) for line in told for part in _terms(line)):  # quotients are not broken
            return []
    words = say("As these momenta are constant, {0} alone is left to move, in an effective potential:", book.q[left])
    return [paragraph(words), Display(tuple(told)), *inside]


def _terms(line: Node) -> list[Node]:
    """Of a relation, what lines are broken between."""
    right = line.right if isinstance(line, Relation) else line
    return [term for _, term in right.items] if isinstance(right, Total) else [right]


def _fits(x: Node) -> bool:
    return text(x).width <= WIDEST_MATRIX and typeset_width(x) <= WIDEST_TYPESET


def _scaled(shown: Callable[[Expr], Node], x: Expr, by: Expr) -> Node:
    """A number times x: before it, or multiplied out where x begins with a number."""
    node = shown(x)
    first = node.items[0] if isinstance(node, Product) else node
    return shown(x * by) if isinstance(first, Numeral) else product([Numeral(Fraction(int(by.p), int(by.q))), _factor(node)])


def _bracketed(node: Node) -> Node:
    return Bracket(node) if isinstance(node, Total) else node


def _factor(node: Node) -> Node:
    return Bracket(node) if isinstance(node, Total) and len(node.items) > 1 else node
