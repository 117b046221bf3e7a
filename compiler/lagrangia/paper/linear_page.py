"""The linear form on paper: M q'' + C q' + K q = f, with multipliers where constraints hold, and then without."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.paper.book import TRANSPOSED_J, Book, bold, column, equal, lengths, matrix
from lagrangia.paper.document import Block, Display, Document, Inline, paragraph, say
from lagrangia.paper.forms import page
from lagrangia.paper.layout import Name, Node, Phrase, Relation, product, total
from lagrangia.paper.linear_matrices import Linear, Table
from lagrangia.paper.singular import singular_point


def linear_form(book: Book, linear: Linear) -> Document:
    """M, C, K and the load about the point; of one coordinate the equation itself."""
    return page(book, [*about_point(book, linear), *linear_blocks(book, linear)])


def about_point(book: Book, linear: Linear) -> list[Block]:
    """About which point the motion is small."""
    return _about(deviations(book, linear), linear)


def linear_blocks(book: Book, linear: Linear, label: str = "", has_where: bool = True) -> list[Block]:
    """The equation and its matrices, which get a letter of the label, and what it is without multipliers."""
    where_ = _where(deviations(book, linear), linear) if has_where else []
    told, prefix = singular_point(book, linear), _prefix(linear)
    book = deviations(book, linear)
    if book.equations.n == 1 and not linear.J:
        system = linear.M, linear.C, linear.K, linear.load
        return [Display((_single(book, system, book.q[0], prefix),), (label,)), *_standstill(linear), *told, *where_]
    has_C, has_K = (_is_there(A) for A in (linear.C, linear.K))
    q, names = replace(bold("q"), prefix=prefix), [replace(x, prefix=prefix) for x in book.q]
    lines: list[Node] = [equal(q, column(names)), *_matrices(book, (linear.M, linear.C, linear.K), has_C, has_K)]
    p = book.presentation
    has_load, has_push = any(x != 0 for x in linear.load), any(x != 0 for x in linear.pushed)
    lines += matrix(bold("J"), [[p.coefficient(x) for x in row] for row in linear.J], "J") if linear.J else []
    lines += matrix(bold("f"), [[p.sum(x)] for x in linear.load], "f") if has_load else []
    lines += matrix(bold("e"), [[p.sum(x)] for x in linear.pushed], "e") if has_push else []
    whole = [_system(q, linear, has_C, has_K, bold("f") if has_load else p.sum(sp.S.Zero))]
    if linear.J:
        is_rate = not book.equations.scene.holonomic
        whole.append(equal(product([bold("J"), replace(q, marks=int(is_rate))]), bold("e") if has_push else p.sum(sp.S.Zero)))
    blocks: list[Block] = [Display(tuple(whole), (label, *[""] * (len(whole) - 1))), paragraph(say("with")),
                           Display(tuple(lines))]
    return [*blocks, *_without(book, linear, prefix), *_standstill(linear), *told, *where_]


def _prefix(linear: Linear) -> str:
    return "Δ" if any(x != 0 for x in linear.point) else ""


def deviations(book: Book, linear: Linear) -> Book:
    """The book in whose formulas the symbols of coordinates and supports stand for what they deviate from the point."""
    symbols, prefix = book.presentation.symbols, _prefix(linear)
    moved = dict.fromkeys((*symbols.coordinates, *symbols.rates, *symbols.accelerations), prefix)
    for g in book.equations.scene.given:
        if linear.resting.get(g.symbol, 0) != 0:
            moved[g.symbol] = "Δ"
    named = dict(symbols.names) | {x: replace(symbols.names[x], prefix=mark) for x, mark in moved.items() if x in symbols.names}
    digits = 6 if linear.is_numeric else symbols.digits
    return replace(book, presentation=replace(book.presentation, symbols=replace(symbols, names=named, digits=digits)))


def _is_there(table: Table) -> bool:
    return any(x != 0 for row in table for x in row)


def _matrices(book: Book, tables: tuple[Table, Table, Table], has_C: bool, has_K: bool) -> list[Node]:
    lines: list[Node] = []
    for name, A, wanted in zip("MCK", tables, (True, has_C, has_K), strict=True):
        lines += matrix(bold(name), [[book.presentation.coefficient(x) for x in row] for row in A], name) if wanted else []
    return lines


def _system(q: Name, linear: Linear, has_C: bool, has_K: bool, right: Node) -> Node:
    left: list[tuple[int, Node]] = [(1, product([bold("M"), replace(q, marks=2)]))]
    left += [(1, product([bold("C"), replace(q, marks=1)]))] if has_C else []
    left += [(1, product([bold("K"), q]))] if has_K else []
    moved = "Δ" if any(x != 0 for x in linear.multipliers) else ""
    left += [(1, product([TRANSPOSED_J, replace(bold("lambda"), prefix=moved)]))] if linear.J else []
    return equal(total(left), right)


def _single(book: Book, system: tuple[Table, Table, Table, tuple[Expr, ...]], q: Name, prefix: str) -> Node:
    """m x'' + c x' + k x = f."""
    M, C, K, load = system
    p = book.presentation
    pairs = [(A[0][0], replace(q, marks=marks, prefix=prefix)) for A, marks in ((M, 2), (C, 1), (K, 0))]
    terms = []
    for x, name in pairs:
        is_negative = all(term.as_coeff_Mul()[0] < 0 for term in sp.Add.make_args(x))
        size = -x if is_negative else x
        if x != 0:
            terms.append((-1 if is_negative else 1, product([*([p.coefficient(size)] if size != 1 else []), name])))
    return equal(total(terms), p.sum(load[0]))


def _without(book: Book, linear: Linear, prefix: str) -> list[Block]:
    """The constraints solved, and what is left of the equations."""
    r, p = linear.reduced, book.presentation
    if r is None:
        return []
    names = [replace(book.q[k], prefix=prefix) for k in r.independent]
    follow = [equal(replace(q, prefix=prefix), p.sum(x)) for k, (q, x) in enumerate(zip(book.q, r.follow, strict=True))
              if k not in r.independent]
    blocks: list[Block] = [paragraph(say("The constraints give")), Display(tuple(follow))]
    if len(r.independent) == 1:
        line = _single(book, (r.M, r.C, r.K, r.load), book.q[r.independent[0]], prefix)
        return [*blocks, paragraph(say("and without multipliers the equation of motion is")), Display((line,))]
    has_C, has_K, has_load = _is_there(r.C), _is_there(r.K), any(x != 0 for x in r.load)
    x = replace(bold("x"), prefix=prefix)
    left: list[tuple[int, Node]] = [(1, product([bold(name), replace(x, marks=marks)]))
                                    for name, marks, wanted in (("M", 2, True), ("C", 1, has_C), ("K", 0, has_K)) if wanted]
    lines = [equal(x, column(names)), *_matrices(book, (r.M, r.C, r.K), has_C, has_K)]
    lines += matrix(bold("f"), [[p.sum(y)] for y in r.load], "f") if has_load else []
    whole = equal(total(left), bold("f") if has_load else p.sum(sp.S.Zero))
    return [*blocks, paragraph(say("and without multipliers the equations of motion are")), Display((whole,)),
            paragraph(say("with")), Display(tuple(lines))]


# -------------------------------------------------------------------- the point


def _about(book: Book, linear: Linear) -> list[Block]:
    """The point; with multipliers, which hold the scene there, in lines of its own."""
    is_moved = any(x != 0 for x in linear.point)
    how: list[Inline] = [say(", found with the parameters' values")] if linear.is_numeric else []

    def about(place: list[Inline]) -> Phrase:
        where = [" ", *place] if place else []
        return say("Small motion about the equilibrium{0}{1}:", where, how) if linear.is_equilibrium else \
            say("Small motion about a point that is no equilibrium{0}{1}:", [",", *where] if where else [], how)

    places = _values(book, book.q, linear.point)
    if not is_moved:
        names: list[Inline] = []
        for q in book.q:
            names += [" = " if names else "", q]
        parts: list[Inline] = [*names, " = 0"]
    else:
        parts = [part for k, place in enumerate(places) for part in ((", ", place) if k else (place,))]
    if not any(x != 0 for x in linear.multipliers):
        return [paragraph(about(parts)), *_resting(book, linear)]
    lam = [book.presentation.symbols.names[x] for x in book.equations.multipliers]
    held = Display((*(places if is_moved else []), *_values(book, lam, linear.multipliers)))
    return [paragraph(about([] if is_moved else [*parts, say(", with the multipliers")])), held, *_resting(book, linear)]


def _resting(book: Book, linear: Linear) -> list[Block]:
    """Where supports stand that move about another place than 0."""
    moved = {x: value for x, value in linear.resting.items() if value != 0 and x in book.names}
    if not moved:
        return []
    lines = [equal(book.names[x], total([(1, book.sum(value)), (1, replace(book.names[x], prefix="Δ"))]))
             for x, value in moved.items()]
    return [paragraph(say("What is given moves about a place of its own:")), Display(tuple(lines))]


def _values(book: Book, names: Sequence[Node], values: Sequence[Expr]) -> list[Relation]:
    """x_0 = ..."""
    bases = [name for name in names if isinstance(name, Name)]
    return [Relation(Name(name.base, f"{name.sub} 0".strip()), book.presentation.sum(x))
            for name, x in zip(bases, values, strict=True)]


def _standstill(linear: Linear) -> list[Block]:
    """What is left out of M, C, K and J."""
    words = say("Coefficients that vary with time are taken at a standstill: with supports at rest, and without loads.")
    return [paragraph(words)] if linear.varies else []


def _where(book: Book, linear: Linear) -> list[Block]:
    """Given functions and formulas of the parameters that stand in the matrices; numbers need none."""
    r = linear.reduced
    tables = [linear.M, linear.C, linear.K, linear.J, (linear.load, linear.pushed), *((r.M, r.C, r.K, (r.load,)) if r else ())]
    used = {y for table in tables for row in table for x in row for y in x.free_symbols}
    given = [g for g in book.equations.scene.given if used & {*g.moving}]
    used |= {y for g in given for y in g.value.free_symbols}
    functions = [equal(book.names[g.symbol], book.sum(g.value)) for g in given]
    formulas = [equal(book.names[p.symbol], book.sum(exact_throughout(p.formula))) for p in book.equations.scene.parameters
                if p.symbol in used and p.formula is not None]
    roots = lengths(book) if not linear.is_numeric else []
    return [paragraph(say("where")), Display((*functions, *formulas, *roots))] if functions or formulas or roots else []


def values_of(book: Book) -> Mapping[Expr, float]:
    """Numbers for every parameter, and for constant loads."""
    scene = book.equations.scene
    found = {p.symbol: book.values[p.name] for p in scene.parameters if math.isfinite(book.values.get(p.name, math.nan))}
    found |= {g.symbol: float(g.value.subs(list(found.items()))) for g in scene.given if not g.value.has(scene.t)
              and g.value.subs(list(found.items())).is_number}
    return found
