"""Steps of the derivation: positions and virtual displacements, and the principle of virtual work in the scene's terms."""

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.paper.book import Book, equal, multiplier_term, time_derivative
from lagrangia.paper.document import Block, Display, Heading, display, paragraph, say
from lagrangia.paper.layout import Bracket, Listing, Name, Node, Product, added, negative, product, total
from lagrangia.paper.numbered import force_of
from lagrangia.paper.points import Point, Speed, in_speeds, points_of, spin_name
from lagrangia.paper.terms import Signed
from lagrangia.paper.typeset import line
from lagrangia.paper.virtual import (
    Pull,
    by_displacements,
    delta,
    displacement,
    dissipative_pull,
    elastic_pull,
    load_pulls,
    work_of,
)


def positions(book: Book) -> list[Block]:
    """r, r' and delta r of each point; what stays 0, and an angle that is a coordinate, are left out."""
    lines = [x for point in points_of(book) for x in _place(book, point)]
    if not lines:
        return []
    words = say("The points that energies and forces depend on, their velocities, and their virtual displacements at a fixed "
                "time:")
    return [Heading(say("Positions, velocities, virtual displacements"), 2), paragraph(words), Display(tuple(lines))]


def _place(book: Book, point: Point) -> list[Node]:
    place, twist = point.place, point.velocity
    labels = [component.name for component in book.equations.scene.kinematics.graph.model.space.components]
    moving = [k for k, x in enumerate(place) if book.presentation.symbols.moves(x)]
    lines: list[Node] = []
    if len(moving) == 1:
        (k,) = moving
        name = Name(labels[k], point.sub)
        lines += _three(book, name, place[k], twist[k])
    elif moving:
        name = Name("r", point.sub)
        whole: list[Node] = [equal(name, Listing(tuple(book.sum(x) for x in place))),
                             equal(_dotted(name), Listing(tuple(book.presentation.motion(x) for x in twist))),
                             equal(_virtual(name), Listing(tuple(displacement(book, x) for x in place)))]
        is_long = any(len(line(x)) > _LONGEST_VECTOR for x in whole)
        lines += [x for k in moving for x in _three(book, Name(labels[k], point.sub), place[k], twist[k])] if is_long else whole
    if point.angle is None:
        told = [(spin_name(point.sub, k), w) for k, w in enumerate(point.spin, 1) if w != 0 and w not in book.equations.scene.v]
        return [*lines, *(equal(name, book.presentation.motion(w)) for name, w in told)]
    if book.presentation.symbols.moves(point.angle) and point.spin[0] not in book.equations.scene.v:
        lines += _three(book, Name(labels[-1], point.sub), point.angle, point.spin[0])
    return lines


def _three(book: Book, name: Name, value: Expr, rate: Expr) -> list[Node]:
    return [equal(name, book.sum(value)), equal(_dotted(name), book.presentation.motion(rate)),
            equal(_virtual(name), displacement(book, value))]


def _dotted(name: Name) -> Name:
    return Name(name.base, name.sub, 1)


def _virtual(name: Name) -> Name:
    return Name(name.base, name.sub, prefix="δ")


# -------------------------------------------------------------------- the principle


def principle(book: Book) -> list[Block]:
    """D'Alembert's principle, its parts in this scene, and the same in the coordinates."""
    F, r = Name("F", "i"), Name("r", "i")
    lost = Bracket(total([(1, F), (-1, product([Name("m", "i"), Name("r", "i", 2)]))]))
    general = equal(product([Name("Sigma"), lost, _DOT, _virtual(r)]), total([]))
    why = say("Ideal joints do no virtual work, so that by d'Alembert's principle")
    blocks: list[Block] = [Heading(say("The principle of virtual work"), 2), paragraph(why), Display((general,))]
    parts = _works(book)
    names = [name for name, _ in parts]
    blocks += [paragraph(say("The parts of this virtual work are here")),
               *display([equal(name, value) for name, value in parts]),
               paragraph(say("and their sum is 0: {0}.", equal(added(*names), total([])))), *_in_coordinates(book)]
    return [*blocks, *(_both_sides(book) if book.level == "lecture" else [])]


_DOT = Name("·")


def _works(book: Book) -> list[tuple[Name, Node]]:
    """Inertial, elastic, of weights and sources, of dampers, of what is applied, as far as they are there."""
    p = book.parts
    found = [(book.virtual_work("in"), _inertial(book))]
    if p.elastic:
        found.append((book.virtual_work("e"), added(*(_pulled(book, elastic_pull(book, t), t.value) for t in p.elastic))))
    if p.weights or p.sources:
        works = [_pulled(book, None, t.value) for t in p.weights]
        works += [work_of(book, load_pulls(book, load)) for load, _ in p.sources]
        found.append((book.virtual_work("f"), added(*works)))
    lost = [_dissipated(book, k) for k in range(len(p.dissipation))]
    lost += [work_of(book, load_pulls(book, load)) for load in p.drags]
    if lost:
        found.append((book.virtual_work("nc"), added(*lost)))
    if p.applied:
        found.append((book.virtual_work("a"), added(*(work_of(book, load_pulls(book, load)) for load in p.applied))))
    return found


def _pulled(book: Book, pull: Pull | None, value: Expr) -> Node:
    """F delta(u); of an energy that has no such stretch -dV/dq_k delta q_k."""
    if pull is not None:
        return work_of(book, [pull])
    value = exact_throughout(value)
    return by_displacements(book, [book.presentation.stated_slope(value, q, -1) for q in book.equations.scene.q])


def _dissipated(book: Book, k: int) -> Node:
    term = book.parts.dissipation[k]
    pull, _ = dissipative_pull(book, term)
    if pull is not None:
        return work_of(book, [pull])
    value = exact_throughout(term.value)
    return by_displacements(book, [book.presentation.stated_slope(value, v, -1) for v in book.equations.scene.v])


def _inertial(book: Book) -> Node:
    """- m x'' delta x of each body; where T is not made of such squares, by the derivatives of T."""
    e = book.equations
    values, speeds = in_speeds(book, book.parts.kinetic, points_of(book))
    items: Signed = []
    known = {s.symbol: s for s in speeds}
    for value in values:
        turns = any(known[x].is_spin for x in value.free_symbols & known.keys())
        terms = None if turns else _squares(value, {*known, *e.scene.v})
        if terms is None:
            whole = [negative(book.presentation.kept(e.ring.tidy(e.momentum_rates[k] - e.dT_dq[k]), sp.S.Zero, k).left)
                     for k in range(e.n)]
            return by_displacements(book, whole)
        items += [_inertia(book, m, x, known) for x, m in sorted(terms, key=lambda pair: book.presentation.stated_key(pair[1]))]
    return total(items)


def _squares(value: Expr, speeds: set[Expr]) -> list[tuple[Expr, Expr]] | None:
    """(x', m) of a sum of m x'^2/2 with constant m."""
    found = []
    here = [x for x in sorted(value.free_symbols, key=str) if x in speeds]
    for x in here:
        m = sp.diff(value, x, 2)
        if m.free_symbols & speeds:
            return None
        found.append((x, m))
    is_whole = sp.expand(value - sum((m * x**2 / 2 for x, m in found), sp.S.Zero)) == 0
    return found if is_whole and not any(m.has(sp.sin, sp.cos) for _, m in found) else None


def _inertia(book: Book, m: Expr, x: Expr, known: dict[Expr, Speed]) -> tuple[int, Node]:
    if x in known:
        name = known[x].name
        twice, virtual = Name(name.base, name.sub, 2), _virtual(name)
    else:
        k = book.equations.scene.v.index(x)
        twice, virtual = book.rate(k, 2), delta(book, k)
    mass = book.sum(m)
    factors = mass.items if isinstance(mass, Product) else (Bracket(mass),) if len(getattr(mass, "items", ())) > 1 else (mass,)
    return -1, product([*factors, twice, virtual])


def _in_coordinates(book: Book) -> list[Block]:
    """sum [f_k - d/dt dT/dv_k + dT/dq_k] delta q_k = 0, in general and with the scene's coordinates."""
    e = book.equations
    q, rate, dq = Name("q", "k"), Name("q", "k", 1), Name("q", prefix="δ")

    def bracket(f: Name, at: Name, its_rate: Name) -> Node:
        terms: Signed = [(1, f), (-1, time_derivative(book.partial("T", its_rate))), (1, book.partial("T", at))]
        return Bracket(total(terms))

    general = equal(product([Name("Sigma"), bracket(Name("f", "k"), q, rate), Name("q", "k", prefix="δ")]), total([]))
    here: Signed = [(1, product([bracket(force_of(book, "", k), book.q[k], book.rate(k)), delta(book, k)])) for k in range(e.n)]
    blocks: list[Block] = [paragraph(say("With {0} the inertial part is one of the coordinates,", book.own("T"))),
                           Display((general,))]
    blocks += [paragraph(say("here")), Display((equal(total(here), total([])),))] if e.n <= _MOST_WRITTEN else []
    if not e.rows:
        return [*blocks, paragraph(say("As the {0} are independent of each other, each bracket is 0.", dq) if e.n > 1 else
                                   say("As {0} is arbitrary, the bracket is 0.", dq))]
    return [*blocks, paragraph(say("The {0} are not independent: they keep the constraints. With a multiplier for each "
                                   "constraint, {1} joins each equation, whose bracket is then 0.", dq,
                                   total(multiplier_term(book))))]


def _both_sides(book: Book) -> list[Block]:
    """The inertial work by accelerations and by T: the same polynomial in delta q, a term a line."""
    e = book.equations
    lines: list[Node] = []
    for k in range(e.n):
        terms = [(1, time_derivative(book.partial("T", book.rate(k)))), (-1, book.partial("T", book.q[k]))]
        value = book.presentation.kept(e.ring.tidy(e.momentum_rates[k] - e.dT_dq[k]), sp.S.Zero, k).left
        lines.append(equal(total(terms), value))
    words = say("The inertial work of all bodies, sorted by the {0}, has the derivatives of {1} as factors, a coordinate a line:",
                Name("q", prefix="δ"), book.own("T"))
    return [paragraph(words), Display(tuple(lines))]


_MOST_WRITTEN = 4
_LONGEST_VECTOR = 94
