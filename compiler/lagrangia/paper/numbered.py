"""Lagrange's equations in the forms of a textbook's chapter on virtual work, each by its number and by a word.

Every form has its general formula, this scene's functions, and the equations with each part on the side where the form has it.
"""

from collections.abc import Mapping
from typing import TypeAlias

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.paper.book import Book, constraints_block, equal, multiplier_term, time_derivative, where
from lagrangia.paper.document import Block, Display, Document, paragraph, say
from lagrangia.paper.forms import page
from lagrangia.paper.layout import Name, Node, Relation, added, negative, total

Side: TypeAlias = tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Form:
    """One form: the function that is differentiated as T, and what stands beside it left and right, by sign and kind."""

    number: str
    function: str  # T, L or L_e
    left: Side
    right: Side


NUMBERED: Mapping[str, Form] = {
    "total": Form("5.16", "T", (), ((1, "f"),)),
    "potential": Form("5.20", "T", ((1, "V"),), ((1, "nc"),)),
    "lagrangian": Form("5.21", "L", (), ((1, "nc"),)),
    "conservative": Form("5.22", "L", (), ()),
    "balance": Form("5.23", "", ((1, "in"), (1, "c"), (1, "nc"), (1, "Phi")), ()),
    "sources": Form("5.26", "T", ((1, "V_e"), (-1, "nc")), ((1, "f_f"),)),
    "elastic": Form("5.27", "L_e", ((-1, "nc"),), ((1, "f_f"),)),
    "elastic-dissipation": Form("5.31", "L_e", ((1, "D"), (-1, "nc")), ((1, "f_f"),)),
    "dissipation": Form("5.32", "T", ((1, "V_e"), (1, "D"), (-1, "nc")), ((1, "f_f"),)),
}
WORDS: Mapping[str, str] = {form.number: word for word, form in NUMBERED.items()}


def numbered_form(book: Book, word: str) -> Document:
    """The page of one form. Raises LagError L0704 where a scene that is not conservative is asked for as one."""
    form, kinds = NUMBERED[word], _kinds(book, NUMBERED[word])
    if word == "conservative":
        _require_conservative(book)
    present = {kind for kind, values in kinds.items() if any(x != 0 for x in values)}
    words = say("Lagrange's equations, form {0} ({1}):", form.number, word)
    blocks: list[Block] = [paragraph(words), Display((_general(book, form, present),))]
    functions = _functions(book, form, present)
    if functions:
        blocks += [paragraph(say("with")), Display(tuple(functions))]
    lines = [_line(book, form, kinds, k) for k in range(book.equations.n)]
    return page(book, [*blocks, paragraph(say("gives")), Display(tuple(lines)), *constraints_block(book), *where(book)])


# -------------------------------------------------------------------- what stands in a form


def _kinds(book: Book, form: Form) -> Mapping[str, tuple[Expr, ...]]:
    """Each kind by coordinate."""
    e, p, tidy = book.equations, book.parts, book.equations.ring.tidy
    n = range(e.n)
    is_whole = not any(kind == "f_f" for _, kind in form.right)  # V stands whole, and the rest on the right
    conservative = tuple(tidy(-p.elastic_slopes[k] - p.field_slopes[k]) for k in n)
    has_D = any(kind == "D" for _, kind in form.left)
    nc = tuple(tidy((0 if has_D else -p.dissipated[k]) + p.drag_forces[k] + (p.applied_forces[k] if is_whole else 0)) for k in n)
    inertial = tuple(tidy(e.dT_dq[k] - e.momentum_rates[k]) for k in n)
    return {"V": tuple(tidy(-x) for x in conservative), "V_e": p.elastic_slopes, "D": p.dissipated, "nc": nc, "c": conservative,
            "Phi": tuple(-x for x in e.reactions),
            "f_f": tuple(tidy(p.applied_forces[k] - p.field_slopes[k]) for k in n), "in": inertial,
            "f": tuple(tidy(x + y) for x, y in zip(conservative, nc, strict=True))}


def _symbol(book: Book, kind: str, q: Name, rate: Name) -> Node:
    match kind:
        case "V":
            return book.partial("V", q)
        case "V_e":
            return book.partial("V", q, "e")
        case "D":
            return book.partial("D", rate)
        case "f":
            return _force("", q)
        case _:
            return _force(kind.removeprefix("f_"), q)


def _force(kind: str, q: Name) -> Name:
    return Name("f", " ".join(filter(None, (kind, q.base if q.base != "q" else "", q.sub))))


def force_of(book: Book, kind: str, k: int) -> Name:
    """f_nc,x: a generalised force of a kind on the k-th coordinate."""
    return _force(kind, book.q[k])


def _general(book: Book, form: Form, present: set[str]) -> Node:
    q, rate = Name("q", "k"), Name("q", "k", 1)
    letter, _, sub = form.function.partition("_")
    left: list[tuple[int, Node]] = []
    if letter:
        left = [(1, time_derivative(book.partial(letter, rate, sub))), (-1, book.partial(letter, q, sub))]
    left += [(sign, _symbol(book, kind, q, rate)) for sign, kind in form.left if kind in present]
    right = [(sign, _symbol(book, kind, q, rate)) for sign, kind in form.right if kind in present]
    return equal(total([*left, *(multiplier_term(book) if letter else [])]), total(right))


def _functions(book: Book, form: Form, present: set[str]) -> list[Node]:
    """T, V, D and the generalised forces that stand in the form."""
    e, p = book.equations, book.parts
    lines: list[Node] = []
    letter, _, sub = form.function.partition("_")
    V_e, V_f = book.presentation.stated(p.stated_elastic), book.presentation.stated(p.field)
    if letter == "L":
        V = V_e if sub else added(V_e, V_f)
        lines.append(equal(book.own("L", sub), _difference(book, sub, V)))
    if letter == "T":
        lines.append(equal(book.own("T"), book.sum(e.T)))
    if "V" in {kind for _, kind in form.left} & present:
        lines.append(equal(book.own("V"), added(V_e, V_f)))
    if "V_e" in {kind for _, kind in form.left} & present:
        lines.append(equal(book.own("V", "e"), V_e))
    if "D" in {kind for _, kind in form.left} & present:
        lines.append(equal(book.own("D"), book.presentation.stated(p.stated_dissipation)))
    kinds = _kinds(book, form)
    if "f" in present and form.number == "5.16":
        q = Name("q", "k")
        shares = [_force(kind, q) for kind in ("c", "nc") if any(x != 0 for x in kinds[kind])]
        lines.append(equal(_force("", q), added(*shares)))
        wanted = ["c", "nc"]
    else:
        wanted = [kind for _, kind in (*form.left, *form.right) if kind in ("in", "c", "nc", "Phi", "f_f")]
    for kind in (kind for kind in wanted if any(x != 0 for x in kinds[kind])):
        lines += [equal(force_of(book, kind.removeprefix("f_"), k), _laid(book, kind, kinds[kind][k], k)) for k in range(e.n)]
    return lines


def _laid(book: Book, kind: str, value: Expr, k: int) -> Node:
    return negative(book.presentation.kept(-value, sp.S.Zero, k).left) if kind == "in" else book.sum(value)


def _difference(book: Book, sub: str, V: Node) -> Node:
    """T - V = ..., V in its own terms."""
    T = book.sum(book.equations.T)
    is_there = total([]) != V
    symbols: list[tuple[int, Node]] = [(1, book.own("T")), *([(-1, book.own("V", sub))] if is_there else [])]
    return Relation(total(symbols), added(T, *([negative(V)] if is_there else [])))


def sides_of(book: Book, word: str) -> tuple[list[Expr], list[Expr]]:
    """Left and right sides of the equations of a form. Raises LagError L0704 where it does not hold."""
    form = NUMBERED[word]
    if word == "conservative":
        _require_conservative(book)
    kinds, tidy, n = _kinds(book, form), book.equations.ring.tidy, range(book.equations.n)
    if not form.function:
        return [tidy(-sp.Add(*(kinds[kind][k] for _, kind in form.left))) for k in n], [sp.S.Zero for _ in n]
    pairs = [_sides(book, form, kinds, k) for k in n]
    return [left for left, _ in pairs], [right for _, right in pairs]


def _sides(book: Book, form: Form, kinds: Mapping[str, tuple[Expr, ...]], k: int) -> tuple[Expr, Expr]:
    e, tidy = book.equations, book.equations.ring.tidy
    inside = kinds["V"][k] if form.function == "L" else kinds["V_e"][k] if form.function == "L_e" else sp.S.Zero
    beside = sum((sign * kinds[kind][k] for sign, kind in form.left), sp.S.Zero)
    left = tidy(e.momentum_rates[k] - e.dT_dq[k] + inside + beside + e.reactions[k])
    return left, tidy(sum((sign * kinds[kind][k] for sign, kind in form.right), sp.S.Zero))


def _line(book: Book, form: Form, kinds: Mapping[str, tuple[Expr, ...]], k: int) -> Node:
    tidy = book.equations.ring.tidy
    if not form.function:
        shares = [force_of(book, kind, k) for _, kind in form.left if kinds[kind][k] != 0]
        whole = tidy(-sp.Add(*(kinds[kind][k] for _, kind in form.left)))
        return equal(added(*shares), Relation(negative(book.presentation.kept(whole, sp.S.Zero, k).left), total([])))
    return book.presentation.equation(*_sides(book, form, kinds, k), k)


def _require_conservative(book: Book) -> None:
    p = book.parts
    wrong = [t.component for t in p.dissipation] + [x.statement.component for x in (*p.applied, *p.drags)]
    if wrong:
        names = ", ".join(dict.fromkeys(name or "the model itself" for name in wrong))
        fail("L0704", f"the form 'conservative' (5.22) does not hold: not conservative: {names}", None,
             "--form lagrangian (5.21) has their generalised forces on its right-hand side")


__all__ = ["NUMBERED", "WORDS", "force_of", "numbered_form", "sides_of"]
