"""Steps of the derivation: T from speeds, then with the rates put in, then in all; V and D as they are stated."""

from fractions import Fraction

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.dynamics.energies import Term
from lagrangia.paper.book import Book, equal, time_derivative
from lagrangia.paper.document import Block, Display, Heading, display, paragraph, say
from lagrangia.paper.forms import component_sub
from lagrangia.paper.layout import Bracket, Name, Node, Numeral, Power, Product, Relation, Total, added, product
from lagrangia.paper.points import in_speeds, points_of, with_speeds
from lagrangia.paper.typeset import line
from lagrangia.paper.virtual import dissipative_pull


def kinetic(book: Book) -> list[Block]:
    """Body by body in speeds, with the rates put in, collected."""
    terms, T = book.parts.kinetic, book.own("T")
    values, speeds = in_speeds(book, terms, points_of(book))
    p = with_speeds(book.presentation, speeds)
    whole = book.sum(book.equations.T)
    if book.level == "short":
        return [Heading(say("Kinetic energy"), 2), Display((equal(T, whole),), ("T",))]
    by_body = [p.stated(x) for x in values]
    put_in = [book.presentation.stated(exact_throughout(t.value)) for t in terms]
    names = [_component(book, "T", t, k, terms) for k, t in enumerate(terms)]
    blocks: list[Block] = [Heading(say("Kinetic energy"), 2)]
    if len(terms) > 1:
        blocks += [paragraph(say("Body by body:")), Display(tuple(equal(n, x) for n, x in zip(names, by_body, strict=True)))]
        changed = [(n, x) for n, x, y in zip(names, put_in, by_body, strict=True) if x != y]
        blocks += [paragraph(say("with the velocities put in:")), *display([equal(n, x) for n, x in changed])] if changed else []
        return [*blocks, paragraph(say("In all:")), Display((equal(T, Relation(added(*names), whole)),), ("T",))]
    lines = [x for x in dict.fromkeys([*by_body, *put_in]) if not _is_same(x, whole)]
    blocks += display([equal(T, x) for x in lines])
    return [*blocks, *([paragraph(say("In all:"))] if lines else []), Display((equal(T, whole),), ("T",))]


def _is_same(one: Node, other: Node) -> bool:
    """But for the order of the terms."""
    terms = [set(x.items) if isinstance(x, Total) else {(1, x)} for x in (one, other)]
    return terms[0] == terms[1]


def _component(book: Book, letter: str, term: Term, k: int, terms: tuple[Term, ...]) -> Name:
    """T_bar; of several of one component T_bar,1; of the model itself T_1."""
    mine = [x for x in terms if x.component == term.component]
    label = component_sub(term.component)
    place = str(mine.index(term) + 1) if len(mine) > 1 or not label else ""
    return book.own(letter, " ".join(filter(None, (label, place))))


def potential(book: Book) -> list[Block]:
    """V = V_e + V_f, each spring by its stretch, weights and sources; a collected V only where it is shorter."""
    p = book.parts
    if not (p.elastic or p.weights or p.sources):
        return []
    V, both = book.own("V"), bool(p.elastic and (p.weights or p.sources))
    lines: list[Node] = []
    stated: list[Node] = []
    for sub, value in (("e", p.stated_elastic), ("f", p.field)):
        if value != 0:
            laid = book.presentation.stated(value)
            stated.append(laid)
            lines += [equal(book.own("V", sub), laid)] if both else []
    blocks: list[Block] = [Heading(say("Potential energy"), 2)]
    if both:
        names = [book.own("V", "e"), book.own("V", "f")]
        blocks += [paragraph(say("Elastic, and of what acts from outside (weights, sources):")), Display(tuple(lines))]
        blocks += [Display((equal(V, Relation(added(*names), added(*stated))),), ("V",))]
    else:
        blocks += [Display((equal(V, added(*stated)),), ("V",))]
    collected, whole = book.sum(p.V_elastic + p.V_field), added(*stated)
    if len(line(collected)) < len(line(whole)):
        blocks += [paragraph(say("collected:")), Display((equal(V, collected),))]
    return blocks


def dissipation(book: Book) -> list[Block]:
    """D: each damper by the rate of its stretch, carried out, and the sum with its squares."""
    terms, D = book.parts.dissipation, book.own("D")
    if not terms:
        return []
    value = book.parts.stated_dissipation
    rates: list[Node] = []
    for t in terms:
        shown = _by_stretch(book, t)
        rates += [shown] if shown is not None else []
    blocks: list[Block] = [Heading(say("Dissipation function"), 2)]
    if book.level != "short" and len(rates) == len(terms) and any(x != book.presentation.stated(value) for x in rates):
        blocks += [paragraph(say("Each damper by the rate of its stretch:")), Display((equal(D, added(*rates)),))]
    blocks += [Display((equal(D, book.presentation.stated(value)),), ("D",))]
    if _is_quadratic(book, value):
        blocks += [paragraph(say("For linear dampers {0} is half the power that they take out.", D))]
    return blocks


def _is_quadratic(book: Book, value: Expr) -> bool:
    v = book.equations.scene.v
    return not any(book.equations.ring.slope(book.equations.ring.slope(value, x), y).free_symbols & set(v) for x in v for y in v)


def _by_stretch(book: Book, term: Term) -> Node | None:
    """c/2 [d/dt (stretch)]^2, where D is a square of its rate."""
    pull, u = dissipative_pull(book, term)
    if pull is None or u is None:
        return None
    stretch = book.sum(pull.along)
    if isinstance(stretch, Name):
        return book.presentation.stated(exact_throughout(term.value))
    factor = exact_throughout(term.value) / u**2
    if factor.free_symbols & set(book.equations.scene.v):
        return None
    square = Power(Bracket(time_derivative(Bracket(stretch))), Numeral(Fraction(2)))
    coefficient = book.sum(factor)
    return product([*(coefficient.items if isinstance(coefficient, Product) else (coefficient,)), square])


