"""Euler's equations on a page: what stands for attitudes in general, and how their quaternions change."""

from collections.abc import Iterator
from dataclasses import replace

from lagrangia.algebra.with_sympy import Expr
from lagrangia.paper.book import Book, equal, time_derivative
from lagrangia.paper.document import Block, Display, paragraph, say
from lagrangia.paper.layout import Name, Node, Slope, product, total

_OF_TURNS = ("theta", "chi", "zeta")  # letters of small turns, of which one is free


def eulers_equations(book: Book) -> list[Block]:
    """d/dt dT/dw1 + w2 dT/dw3 - w3 dT/dw2 - dT/dtheta1 + ... = f1 and its like, without what is not there."""
    if not book.equations.scene.turnings:
        return []
    turns = _turns(book)
    lines = [_line(book, turns, k) for k in range(3)]
    words = say("Euler's equations of angular velocities, with small turns {0}, {1}, {2} about the axes that turn along,", *turns)
    return [paragraph(words), Display(tuple(lines))]


def _line(book: Book, turns: list[Name], axis: int) -> Node:
    """The letters are those of the first attitude."""
    e = book.equations
    places = e.scene.turnings[0].places
    w = [book.rate(k) for k in places]
    i, j = (axis + 1) % 3, (axis + 2) % 3

    def slope(letter: str, by: Node) -> Node:
        return book.partial(letter, by)

    def some(values: tuple[Expr, ...]) -> bool:
        return any(values[k] != 0 for k in e.scene.turned)

    items: list[tuple[int, Node]] = [(1, time_derivative(slope("T", w[axis]))), (1, product([w[i], slope("T", w[j])])),
                                     (-1, product([w[j], slope("T", w[i])]))]
    items += [(-1, slope("T", turns[axis]))] if some(e.dT_dq) else []
    items += [(1, slope("V", turns[axis]))] if some(e.dV_dq) else []
    items += [(1, slope("D", w[axis]))] if some(e.dD_dv) else []
    if some(e.reactions):
        several = len(e.rows) > 1
        of = Name("Phi", "i" if several else "")
        by = turns[axis] if e.scene.holonomic else w[axis]
        sum_of: list[Node] = [Name("Sigma"), Name("lambda", "i")] if several else [Name("lambda")]
        items.append((1, product([*sum_of, Slope(of, by)])))
    right: Node = total([])
    if some(e.f):
        right = Name("f", " ".join(filter(None, (book.q[places[axis]].base, book.q[places[axis]].sub))))
    return equal(total(items), right)


def _turns(book: Book) -> list[Name]:
    taken = {name.base for name in book.names.values()}
    letter = next((x for x in _OF_TURNS if x not in taken), _OF_TURNS[-1])
    return [Name(letter, str(k)) for k in (1, 2, 3)]


def kinematic_lines(book: Book) -> Iterator[Node]:
    """Q' = Q (0, w)/2, part by part."""
    for part, rate in book.equations.scene.turns:
        yield equal(replace(book.names[part], marks=1), book.sum(rate))


def kinematic_block(book: Book) -> list[Block]:
    """How attitudes follow from angular velocities."""
    lines = tuple(kinematic_lines(book))
    return [paragraph(say("Attitudes follow by")), Display(lines)] if lines else []
