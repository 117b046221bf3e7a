"""Steps of the derivation: small motion, first as scalar equations, then as matrices."""

import sympy as sp

from lagrangia.paper.book import Book
from lagrangia.paper.document import Block, Display, Heading, paragraph, say
from lagrangia.paper.layout import Apply, Name, Node, Relation
from lagrangia.paper.linear_matrices import Linear
from lagrangia.paper.linear_page import about_point, deviations, linear_blocks


def small_motion(book: Book, linear: Linear | None) -> list[Block]:
    """What is assumed, the linear equations, their matrices; nothing where there is no position of rest."""
    if linear is None:
        return []
    blocks: list[Block] = [Heading(say("Small motion"), 2), *about_point(book, linear)]
    if _is_linear(book):
        blocks += [paragraph(say("The equations are linear as they stand."))]
    else:
        sines = _sines(deviations(book, linear))
        words = say("Products of small quantities are left out, as in {0}:", sines) if sines else \
            say("Products of small quantities are left out:")
        blocks += [paragraph(words), *(_scalars(book, linear) if book.equations.n > 1 or linear.J else [])]
    return [*blocks, *linear_blocks(book, linear, "matrix form", has_where=False)]


def _is_linear(book: Book) -> bool:
    e = book.equations
    state = [*e.scene.q, *e.scene.v]
    slopes = [e.ring.slope(x, y) for x in (*e.h, *e.rows) for y in state]
    return not any(x.free_symbols & set(state) for x in (*slopes, *(x for row in e.M for x in row)))


def _sines(book: Book) -> list[Node | str]:
    """sin theta = theta, cos theta = 1, of a coordinate that stands in a sine; else nothing."""
    e = book.equations
    waves = {w.args[0] for x in (*e.left, *e.rows) for w in x.atoms(sp.sin, sp.cos)}
    angles = [k for k, q in enumerate(e.scene.q) if q in waves]
    if not angles:
        return []
    q: Name = book.presentation.symbols.names[e.scene.q[angles[0]]]
    one = Relation(Apply("sin", q), q, "≈")
    return [one, ", ", Relation(Apply("cos", q), book.sum(sp.S.One), "≈")]


def _scalars(book: Book, linear: Linear) -> list[Block]:
    """M q'' + C q' + K q + J^T lambda = f, a line a coordinate."""
    e = book.equations
    small = deviations(book, linear)
    lines = []
    for k in range(e.n):
        left = sum((x * y for table, ys in ((linear.M, e.scene.a), (linear.C, e.scene.v), (linear.K, e.scene.q))
                    for x, y in zip(table[k], ys, strict=True)), sp.S.Zero)
        left += sum((row[k] * x for row, x in zip(linear.J, e.multipliers, strict=True)), sp.S.Zero)
        lines.append(small.presentation.equation(e.ring.tidy(left), linear.load[k], k))
    return [Display(tuple(lines), tuple(f"small {k}" for k in range(e.n)))]
