"""Steps of the derivation: generalised forces both ways, and Lagrange's equation of each coordinate, derivative by derivative."""

from collections.abc import Sequence

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.paper.book import Book, equal, multiplier_term, time_derivative
from lagrangia.paper.document import Block, Display, Heading, Inline, display, paragraph, say
from lagrangia.paper.layout import Letter, Name, Node, Phrase, Relation, added, negative, total
from lagrangia.paper.numbered import force_of
from lagrangia.paper.terms import Signed
from lagrangia.paper.virtual import Pull, by_displacements, dissipative_pull, load_pulls, work_of


def forces(book: Book) -> list[Block]:
    """Conservative forces by V; the others by D and, beside it, by their virtual work."""
    p, tidy = book.parts, book.equations.ring.tidy
    conservative = [tidy(-x - y) for x, y in zip(p.elastic_slopes, p.field_slopes, strict=True)]
    blocks: list[Block] = []
    if any(x != 0 for x in conservative):
        lines: list[Node] = []
        for k, x in enumerate(conservative):
            slope = negative(book.partial("V", book.q[k]))
            lines.append(equal(force_of(book, "c", k), Relation(slope, book.sum(x))))
        blocks += [paragraph(say("Conservative, by {0} {1}:", book.own("V"), Letter("V"))), Display(tuple(lines))]
    blocks += _dissipative(book)
    for loads, kind, words in (([x for x, _ in p.sources], "f", say("Of the sources, by their virtual work:")),
                               (p.applied, "a", say("Applied, by their virtual work:")),
                               (p.drags, "d", say("Of rates, by their virtual work:"))):
        pulls = [pull for load in loads for pull in load_pulls(book, load)]
        if pulls:
            blocks += _by_work(book, pulls, kind, words)
    if p.sources:
        blocks += [paragraph(say("which is again their part of {0}: a source with a potential may stand on either side.",
                                 negative(book.partial("V", Name("q")))))]
    return [Heading(say("Generalised forces"), 2), *blocks] if blocks else []


def _dissipative(book: Book) -> list[Block]:
    e, p, tidy = book.equations, book.parts, book.equations.ring.tidy
    if not p.dissipation:
        return []
    lines = [equal(force_of(book, "nc", k), Relation(negative(book.partial("D", book.rate(k))), book.sum(tidy(-x))))
             for k, x in enumerate(p.dissipated)]
    blocks: list[Block] = [paragraph(say("Non-conservative, by {0} {1}:", book.own("D"), Letter("D"))),
                           Display(tuple(lines), tuple(f"nc {k}" for k in range(e.n)))]
    pulls = [pull for t in p.dissipation for pull in [dissipative_pull(book, t)[0]] if pull is not None]
    if len(pulls) < len(p.dissipation):
        return blocks
    work = [tidy(sp.Add(*(exact_throughout(x.force) * e.ring.slope(x.along, q) for x in pulls))) for q in e.scene.q]
    agrees = all(e.ring.is_zero(x + y) for x, y in zip(work, p.dissipated, strict=True))
    stated = [book.presentation.stated_slope(p.stated_dissipation, v, -1) for v in e.scene.v]
    name = book.virtual_work("nc")
    lines = [equal(name, Relation(work_of(book, pulls), by_displacements(book, stated)))] if agrees else []
    if not lines:
        return blocks
    again: list[Inline] = []
    for k in range(e.n):
        again += [", " if k else "", Letter(f"nc {k}")]
    return [*blocks, paragraph(say("By their virtual work, force by stretch,")), Display(tuple(lines)),
            paragraph(say("and the factors of the {0} are again {1}: both ways agree.", Name("q", prefix="δ"), again))]


def _by_work(book: Book, pulls: Sequence[Pull], kind: str, words: Phrase) -> list[Block]:
    e = book.equations
    values = [e.ring.tidy(sp.Add(*(x.force * e.ring.slope(x.along, q) for x in pulls))) for q in e.scene.q]
    name = book.virtual_work(kind)
    carried = by_displacements(book, [book.sum(x) for x in values])
    whole = work_of(book, pulls)
    line = equal(name, whole if whole == carried else Relation(whole, carried))
    lines = [equal(force_of(book, kind, k), book.sum(x)) for k, x in enumerate(values)]
    return [paragraph(words), Display((line,)), Display(tuple(lines), tuple(f"{kind} {k}" for k in range(e.n)))]


# -------------------------------------------------------------------- each coordinate


def equations_of_motion(book: Book) -> list[Block]:
    """The general equation, and for each coordinate its derivatives, the equation put together and in order."""
    e = book.equations
    blocks: list[Block] = [Heading(say("Lagrange's equations"), 2), Display((_general(book),))]
    if book.level == "short":
        return [*blocks, Display(tuple(_equation(book, k) for k in range(e.n)), _labels(book))]
    for k in range(e.n):
        blocks += _coordinate(book, k)
    return blocks


def _labels(book: Book) -> tuple[str, ...]:
    return tuple(f"equation {k}" for k in range(book.equations.n))


def _rest(book: Book, k: int) -> Expr:
    p = book.parts
    return book.equations.ring.tidy(p.applied_forces[k] + p.drag_forces[k])


def _has_rest(book: Book) -> bool:
    return any(_rest(book, k) != 0 for k in range(book.equations.n))


def _general(book: Book) -> Node:
    p = book.parts
    q, rate = Name("q", "k"), Name("q", "k", 1)
    items: Signed = [(1, time_derivative(book.partial("T", rate))), (-1, book.partial("T", q))]
    items += [(1, book.partial("V", q))] if p.elastic or p.weights or p.sources else []
    items += [(1, book.partial("D", rate))] if p.dissipation else []
    items += multiplier_term(book)
    return equal(total(items), Name("f", "k") if _has_rest(book) else total([]))


def _coordinate(book: Book, k: int) -> list[Block]:
    e, p, q, rate = book.equations, book.parts, book.q[k], book.rate(k)
    of_T, step = book.partial("T", rate), time_derivative(book.partial("T", rate))
    momentum = book.presentation.momentum(e.momenta[k], k)
    changing = book.presentation.kept(e.momentum_rates[k], sp.S.Zero, k).left
    lines: list[Node] = [equal(of_T, momentum), equal(step, changing), equal(book.partial("T", q), book.sum(e.dT_dq[k]))]
    pieces: list[Node] = [changing, negative(book.sum(e.dT_dq[k]))]
    if p.elastic or p.weights or p.sources:
        V = book.presentation.stated_slope(p.stated_elastic + p.field, e.scene.q[k])
        lines.append(equal(book.partial("V", q), V))
        pieces.append(V)
    if p.dissipation:
        D = book.presentation.stated_slope(p.stated_dissipation, e.scene.v[k])
        lines.append(equal(book.partial("D", rate), D))
        pieces.append(D)
    right = book.sum(_rest(book, k))
    lines += [equal(force_of(book, "", k), right)] if _has_rest(book) else []
    pieces.append(book.sum(e.reactions[k]))
    put = equal(added(*pieces), right)
    whole = _equation(book, k)
    blocks: list[Block] = [paragraph(say("For {0}:", q)), Display(tuple(lines))]
    blocks += [paragraph(say("put together:")), *display([put])] if put != whole else []
    return [*blocks, paragraph(say("in order:") if put != whole else say("so that")), Display((whole,), (f"equation {k}",))]


def _equation(book: Book, k: int) -> Node:
    e, p, tidy = book.equations, book.parts, book.equations.ring.tidy
    left = tidy(e.momentum_rates[k] - e.dT_dq[k] + p.elastic_slopes[k] + p.field_slopes[k] + p.dissipated[k] + e.reactions[k])
    return book.presentation.equation(left, _rest(book, k), k)


