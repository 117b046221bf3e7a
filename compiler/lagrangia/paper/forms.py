"""The forms in which people write a mechanism's equations: each a Document made from one Book."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.dynamics.energies import Term
from lagrangia.paper.book import (
    TRANSPOSED_J,
    Book,
    bold,
    column,
    constraints_block,
    coordinates_table,
    equal,
    events_block,
    generic,
    matrix,
    names_block,
    where,
)
from lagrangia.paper.document import Block, Display, Document, Heading, display, paragraph, say
from lagrangia.paper.equations import load_force, split_potential
from lagrangia.paper.euler_equations import eulers_equations, kinematic_block, kinematic_lines
from lagrangia.paper.layout import Grid, Name, Node, Relation, Total, added, product, total
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.reduction import constants_and_rest
from lagrangia.paper.singular import singular_places
from lagrangia.paper.typeset import line

_LONGEST_QUOTIENT = 90


def title(book: Book) -> str:
    """The name of the model."""
    return book.equations.scene.kinematics.graph.model.name


def opening(book: Book) -> list[Block]:
    """The description of the model, as the first words of a page."""
    description = book.equations.scene.kinematics.graph.model.description
    return [paragraph(f"{description}.")] if description else []


def page(book: Book, blocks: list[Block]) -> Document:
    """A page of the model: what it is, its names, the blocks, where its coordinates are singular, its events."""
    return Document(title(book), (*opening(book), *names_block(book), *blocks, *singular_places(book), *events_block(book)))


# -------------------------------------------------------------------- energies


def energies_form(book: Book) -> Document:
    """Energies, forces and constraints."""
    return page(book, [*energy_blocks(book), *force_blocks(book), *constraints_block(book), *where(book)])


def energy_blocks(book: Book) -> list[Block]:
    """T, V and D, component by component and in all."""
    e = book.equations
    energies, model = e.scene.energies, e.scene.kinematics.graph.model
    field, elastic = split_potential(energies, model)
    blocks: list[Block] = [Heading(say("Kinetic energy"), 2), *_energy(book, "T", energies.kinetic, e.T)]
    if e.V_elastic != 0 or e.V_field != 0:
        blocks += [Heading(say("Potential energy"), 2)]
    if e.V_elastic != 0 and e.V_field != 0:
        blocks += display([equal(book.own("V"), total([(1, book.own("V", "e")), (1, book.own("V", "f"))]))])
    both = e.V_elastic != 0 and e.V_field != 0
    if e.V_elastic != 0:
        blocks += [paragraph(say("Elastic:")), *_energy(book, "V", elastic, e.V_elastic, "e" if both else "")]
    if e.V_field != 0:
        blocks += [paragraph(say("Of gravity:")), *_energy(book, "V", field, e.V_field, "f" if both else "")]
    if e.D != 0:
        blocks += [Heading(say("Dissipation function"), 2), *_energy(book, "D", energies.dissipation, e.D)]
    return blocks


def _energy(book: Book, base: str, terms: tuple[Term, ...], whole: Expr, sub: str = "") -> list[Block]:
    """The terms as they are stated, and their sum."""
    shown = [term for term in terms if book.equations.ring.tidy(exact_throughout(term.value)) != 0]
    several: dict[str, list[Term]] = {}
    for term in shown:
        several.setdefault(term.component, []).append(term)
    lines: list[Node] = []
    names: list[Node] = []
    for component, mine in several.items():
        name = book.own(base, component_sub(component))
        names.append(name)
        lines.append(equal(name, added(*(book.gentle(term.value) for term in mine))))
    if len(lines) == 1:
        right = lines[0].right if isinstance(lines[0], Relation) else lines[0]
        summed = book.sum(whole)
        return display([equal(book.own(base, sub), right if right == summed else Relation(right, summed))])
    return [*display(lines), *display([equal(book.own(base, sub), Relation(added(*names), book.sum(whole)))])]


def component_sub(component: str) -> str:
    """A component's name as an index."""
    return component.replace(".", " ").replace("[", " ").replace("]", "")


def force_blocks(book: Book) -> list[Block]:
    """The generalised forces f_k = sum F . dr/dq_k of the loads."""
    e = book.equations
    if not e.scene.energies.loads:
        return []
    lines = [equal(force_name(book, k), book.sum(f)) for k, f in enumerate(e.f)]
    blocks: list[Block] = [Heading(say("Generalised forces"), 2)]
    several = len(e.scene.energies.loads) > 1
    for load in e.scene.energies.loads if several else ():
        parts = [(k, e.ring.tidy(load_force(load, e.scene, k))) for k in range(e.n)]
        shown = [equal(force_name(book, k), book.sum(x)) for k, x in parts if x != 0]
        blocks += [paragraph(say("Of {0}:", load.statement.component)), *display(shown)]
    return [*blocks, *([paragraph(say("In all:"))] if several else []), Display(tuple(lines))]


def force_name(book: Book, k: int) -> Name:
    """The name of the generalised force on the k-th coordinate."""
    q = book.q[k]
    return Name("f", " ".join(filter(None, (q.base, q.sub))))


# -------------------------------------------------------------------- Lagrange's equations


def equations_of(book: Book) -> list[Node]:
    """Lagrange's equations, one for each coordinate."""
    e = book.equations
    return [book.presentation.equation(e.left[k] + e.reactions[k], e.f[k], k) for k in range(e.n)]


def lagrange_form(book: Book) -> Document:
    """Lagrange's equations, first in general and then written out."""
    is_needed = len(book.equations.scene.turned) < book.equations.n
    first: list[Block] = [paragraph(say("Lagrange's equations")), Display((generic(book),))] if is_needed else []
    return page(book, [*first, *eulers_equations(book), paragraph(say("give")), Display(tuple(equations_of(book))),
                       *kinematic_block(book), *constraints_block(book), *where(book), *constants_and_rest(book)])


# -------------------------------------------------------------------- matrices


def matrix_blocks(book: Book) -> list[Block]:
    """M, h, f and J with the equation that they stand in."""
    e, p = book.equations, book.presentation
    M = [[p.coefficient(x) for x in row] for row in e.M]
    acceleration = column([book.rate(k, 2) for k in range(e.n)])
    is_constant = not any(p.symbols.moves(x) for row in e.M for x in row)
    left: list[Node] = [product([bold("M", 0, "" if is_constant else "q"), bold("q", 2)])]
    left += [bold("h")] if any(x != 0 for x in e.h) else []
    left += [product([TRANSPOSED_J, bold("lambda")])] if e.rows else []
    right: Node = bold("f") if any(x != 0 for x in e.f) else book.sum(sp.S.Zero)
    blocks: list[Block] = [Display((equal(total([(1, x) for x in left]), right),)), paragraph(say("with"))]
    lines = [equal(bold("q", 2), acceleration), *matrix(bold("M"), M, "M")]
    lines += matrix(bold("h"), [[book.sum(x)] for x in e.h], "h") if any(x != 0 for x in e.h) else []
    lines += matrix(bold("f"), [[book.sum(x)] for x in e.f], "f") if any(x != 0 for x in e.f) else []
    lines += matrix(bold("J"), [[book.sum(x) for x in row] for row in e.J], "J") if e.rows else []
    return [*blocks, Display(tuple(lines))]


def matrix_form(book: Book) -> Document:
    """The equations as matrices: M, h, J."""
    return page(book, [*matrix_blocks(book), *kinematic_block(book), *constraints_block(book), *where(book)])


def first_order_form(book: Book) -> Document:
    """q' = v, or of attitudes Q' = Q (0, w)/2, and v' = M^-1 (f - h); with several coordinates and a full M by its determinant,
    or M v' = f - h, as where M is singular."""
    e = book.equations
    named = {v: q if k in e.scene.turned else Name("v", " ".join(filter(None, (q.base, q.sub))))
             for k, (v, q) in enumerate(zip(e.scene.v, book.q, strict=True))}
    names = dict(book.presentation.symbols.names) | named
    p = replace(book.presentation, symbols=replace(book.presentation.symbols, names=names))
    rates = [replace(named[v], marks=1) for v in e.scene.v]
    lines: list[Node] = [equal(book.rate(k), named[v]) for k, v in enumerate(e.scene.v) if k not in e.scene.turned]
    lines += kinematic_lines(book)
    right = [e.ring.tidy(f - h - r) for f, h, r in zip(e.f, e.h, e.reactions, strict=True)]
    is_diagonal = all(e.M[i][j] == 0 for i in range(e.n) for j in range(i))
    if any(e.M[k][k] == 0 for k in range(e.n)):  # a place without mass has no acceleration that follows from forces
        blocks = _descriptor(book, p, lines, rates, right)
    elif is_diagonal:
        blocks = _diagonal(book, p, lines, rates, right)
    elif e.n == 2:
        (a, b), (_, d) = e.M
        delta = e.ring.tidy(a * d - b * b)
        r1, r2 = (_fresh(book, "rbw", label) for label in "12")
        M = [[_fresh(book, "MA", f"{i + 1}{j + 1}") for j in range(2)] for i in range(2)]
        solved = [total([(1, product([M[1][1], r1])), (-1, product([M[0][1], r2]))]),
                  total([(1, product([M[0][0], r2])), (-1, product([M[0][1], r1]))])]
        lines += [equal(rate, p.over(top, Name("Delta"))) for rate, top in zip(rates, solved, strict=True)]
        squares = total([(1, product([M[0][0], M[1][1]])), (-1, p.square(M[0][1]))])
        inside = [equal(r1, p.sum(right[0])), equal(r2, p.sum(right[1])), equal(M[0][0], p.coefficient(a)),
                  equal(M[0][1], p.coefficient(b)), equal(M[1][1], p.coefficient(d)),
                  equal(Name("Delta"), Relation(squares, p.coefficient(delta)))]
        blocks = [Display(tuple(lines)), paragraph(say("with")), Display(tuple(inside))]
    else:
        blocks = _descriptor(book, p, lines, rates, right)
    return page(book, [*blocks, *constraints_block(book), *where(book)])


def _diagonal(book: Book, p: Presentation, lines: list[Node], rates: list[Name], right: list[Expr]) -> list[Block]:
    """Each rate by its quotient, with names for the parts of one that would not fit on a line."""
    inside: list[Node] = []
    for k, rate in enumerate(rates):
        quotient = p.quotient(right[k], book.equations.M[k][k])
        if len(line(quotient)) > _LONGEST_QUOTIENT and not isinstance(quotient, Total):
            label = str(k + 1) if len(rates) > 1 else ""
            r, M = _fresh(book, "rbw", label), _fresh(book, "MA", label * 2)
            inside += [equal(r, p.sum(right[k])), equal(M, p.coefficient(book.equations.M[k][k]))]
            quotient = p.over(r, M)
        lines.append(equal(rate, quotient))
    more: list[Block] = [paragraph(say("with")), Display(tuple(inside))] if inside else []
    return [Display(tuple(lines)), *more]


def _fresh(book: Book, letters: str, sub: str) -> Name:
    """A name for a part of a formula: no name stands for two things."""
    taken = {(x.base, x.sub) for x in book.presentation.symbols.names.values()}
    return next((Name(base, sub) for base in letters if (base, sub) not in taken), Name(f"{letters[0]}_{letters[0]}", sub))


def _descriptor(book: Book, p: Presentation, lines: list[Node], rates: list[Name], right: list[Expr]) -> list[Block]:
    M = [[p.coefficient(x) for x in row] for row in book.equations.M]
    r = [[p.sum(x)] for x in right]
    whole = [equal(product([bold("M"), bold("v", 1)]), bold("r")), equal(bold("v", 1), column(rates)),
             *matrix(bold("M"), M, "M"), *matrix(bold("r"), r, "r")]
    return [Display(tuple(lines)), paragraph(say("and")), Display(tuple(whole))]


FORMS: Mapping[str, Callable[[Book], Document]] = {
    "energies": energies_form, "lagrange": lagrange_form, "matrix": matrix_form, "first-order": first_order_form,
}
__all__ = ["FORMS", "Grid", "Total", "coordinates_table"]
