"""Virtual displacements and virtual work: delta r = sum dr/dq_k delta q_k, forces on the stretches that they act along."""

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout, slope
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Load, Term
from lagrangia.paper.book import Book
from lagrangia.paper.equations import load_force
from lagrangia.paper.layout import Apply, Bracket, Name, Node, Product, Total, negative, product, total
from lagrangia.paper.stated import opened
from lagrangia.paper.terms import Signed


@dataclass(frozen=True)
class Pull:
    """A force and what it acts along: a stretch of the coordinates. The force is that of the sign of its virtual work."""

    force: Expr
    along: Expr


def delta(book: Book, k: int) -> Name:
    """The virtual displacement of a coordinate."""
    return replace(book.q[k], prefix="δ")


def delta_of(book: Book, expression: Expr) -> Node:
    """The virtual change of an expression of the coordinates, not carried out."""
    inside = book.sum(expression)
    if isinstance(inside, Name):
        return replace(inside, prefix="δ")
    return Apply("δ", Bracket(inside))


def by_displacements(book: Book, coefficients: Sequence[Node]) -> Node:
    """sum of a coefficient times delta q_k, zeros left out."""
    items: Signed = []
    for k, node in enumerate(coefficients):
        if not opened(node):
            continue
        is_negative = isinstance(node, Total) and all(s < 0 for s, _ in node.items)
        items.append((-1 if is_negative else 1, times(negative(node) if is_negative else node, delta(book, k))))
    return total(items)


def times(node: Node, last: Node) -> Node:
    """node last, without a factor 1."""
    if node == total([(1, product([]))]):
        return last
    return Product((*node.items, last)) if isinstance(node, Product) else product([node, last])


def displacement(book: Book, expression: Expr) -> Node:
    """delta of an expression, carried out."""
    ring = book.equations.ring
    return by_displacements(book, [book.sum(ring.slope(expression, q)) for q in book.equations.scene.q])


# -------------------------------------------------------------------- forces and their stretches


def elastic_pull(book: Book, term: Term) -> Pull | None:
    """-dV/du du of an energy that depends on the coordinates by one stretch u alone."""
    value = neat(book, term.value)
    u = _inner(value, set(book.equations.scene.q))
    if u is None or not u.free_symbols & set(book.equations.scene.q):
        return None
    dummy = sp.Dummy(real=True)
    return Pull(-sp.factor_terms(slope(value.xreplace({u: dummy}), dummy)).xreplace({dummy: u}), u)


def dissipative_pull(book: Book, term: Term) -> tuple[Pull | None, Expr | None]:
    """The force of a damper on what its rate is the rate of, and the rate; None where no formula gives that."""
    scene = book.equations.scene
    value = neat(book, term.value)
    u = _inner(value, set(scene.v))
    if u is None:
        return None, None
    stretch = _integrated(book, u)
    if stretch is None:
        return None, u
    dummy = sp.Dummy(real=True)
    return Pull(-sp.factor_terms(slope(value.xreplace({u: dummy}), dummy)).xreplace({dummy: u}), stretch), u


def load_pulls(book: Book, load: Load) -> list[Pull]:
    """Each component of a load and what it moves along; a torque on an attitude, which is along nothing, by coordinates."""
    scene, tidy = book.equations.scene, book.equations.ring.tidy
    if load.moving[1]:
        shares = [(tidy(load_force(load, scene, k)), q) for k, q in enumerate(scene.q)]
        return [Pull(force, q) for force, q in shares if force != 0]
    found = []
    for force, place in zip(load.force, load.position, strict=True):
        r = tidy(exact_throughout(place))
        along = sp.Add(*(x for x in sp.Add.make_args(r) if x.free_symbols & set(book.equations.scene.q)))
        if exact_throughout(force) != 0 and along != 0:
            found.append(Pull(exact_throughout(force), along))
    return found


def work_of(book: Book, pulls: Sequence[Pull]) -> Node:
    """sum of F delta(u)."""
    items: Signed = []
    for x in pulls:
        for sign, node in _one(book.presentation.stated(x.force)):
            items.append((sign, times(node, delta_of(book, x.along))))
    return total(items)


def _one(node: Node) -> Signed:
    items = opened(node)
    if len(items) <= 1:
        return items
    return [(-1, Bracket(total([(1, x) for _, x in items])))] if all(s < 0 for s, _ in items) else [(1, Bracket(node))]


def _inner(value: Expr, symbols: set[Expr]) -> Expr | None:
    """The smallest part by which alone the value depends on the symbols."""
    found, parts = None, sp.preorder_traversal(value)
    for part in parts:
        if isinstance(part, sp.Expr) and part.free_symbols & symbols and part != value and \
                not value.xreplace({part: sp.Dummy()}).free_symbols & symbols:
            found = part
        if _is_root(part):
            parts.skip()
    return found


def _is_root(x: Expr) -> bool:
    return bool(x.is_Pow and x.exp.is_Rational and x.exp.q == 2)


def neat(book: Book, value: Expr) -> Expr:
    """Exact, with the roots in it as their normal form has them: a length along a line as its coordinate."""
    value = exact_throughout(value)
    return value.xreplace({x: book.equations.ring.tidy(x) for x in value.atoms(sp.Pow) if _is_root(x)})


def _integrated(book: Book, u: Expr) -> Expr | None:
    """What u is the rate of."""
    e = book.equations
    found = sp.S.Zero
    for q, v in zip(e.scene.q, e.scene.v, strict=True):
        part = _antiderivative(book, e.ring.tidy(e.ring.slope(u, v) - e.ring.slope(found, q)), q)
        if part is None:
            return None
        found = e.ring.tidy(found + part)
    return found if e.ring.is_zero(e.scene.time_rate(found) - u) else None


def _antiderivative(book: Book, expression: Expr, q: Expr) -> Expr | None:
    total_ = sp.S.Zero
    for term in book.equations.ring.terms(expression):
        x = term.expression()
        waves = [w for w, _ in term.trigonometric if w.has(q)]
        powers = [(atom, k) for atom, k in term.powers if atom.has(q)]
        if not waves and all(atom == q and k != -1 for atom, k in powers):
            k = powers[0][1] if powers else 0
            total_ += x * q / (sp.Rational(k) + 1)
        elif len(waves) == 1 and dict(term.trigonometric)[waves[0]] == 1 and not powers:
            other = -sp.cos(waves[0].args[0]) if isinstance(waves[0], sp.sin) else sp.sin(waves[0].args[0])
            total_ += x / waves[0] * other / waves[0].args[0].diff(q)
        else:
            return None
    return total_
