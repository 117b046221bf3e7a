"""Small motion about a point: M q'' + C q' + K q = f(t), the matrices from the exact derivatives of the equations."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product as combinations

import sympy as sp

from lagrangia.book import Book, bold, column, equal, matrix, where
from lagrangia.diagnostics import fail
from lagrangia.document import Block, Display, Document, paragraph
from lagrangia.equations import Equations
from lagrangia.forms import page
from lagrangia.layout import Name, Node, product, total
from lagrangia.sympy_algebra import Expr, exact

_MOST_ANGLES = 5
_TRIED = (sp.S.Zero, -sp.pi / 2, sp.pi / 2, sp.pi)


@dataclass(frozen=True)
class Linear:
    """At the point q0: M, C, K (n x n) and the load (n,), with the constant part that is left where q0 is no equilibrium."""

    point: tuple[Expr, ...]
    is_numeric: bool  # found with the parameters' values, which are put in
    is_equilibrium: bool
    M: tuple[tuple[Expr, ...], ...]
    C: tuple[tuple[Expr, ...], ...]
    K: tuple[tuple[Expr, ...], ...]
    load: tuple[Expr, ...]


def linearize(e: Equations, numbers: Mapping[Expr, float], starts: Mapping[str, float],
              given: Mapping[str, float] | None = None) -> Linear:
    """About `given` (coordinates by name, the others 0), or else about an equilibrium.

    `numbers` are the parameters' values: of several equilibria a stable one is taken, and one that no formula gives is found by
    Newton's method from `starts`. Raises LagError L0912 for constraints and prescribed coordinates, L0713 without equilibrium.
    """
    scene, span = e.scene, e.scene.kinematics.graph.model.span
    if e.rows:
        fail("L0912", "not supported yet: the linear form of a scene with constraints", span)
    if any(g.what == "coordinate" for g in scene.given):
        fail("L0912", "not supported yet: the linear form of a scene with prescribed coordinates", span)
    force = [e.ring.tidy(h - f) for h, f in zip(e.h, e.f, strict=True)]
    quiet = dict.fromkeys((*scene.v, *_sources(e)), sp.S.Zero)
    static = [e.ring.tidy(_put(x, quiet)) for x in force]
    if any(x.has(scene.t) for x in (*static, *(entry for row in e.M for entry in row))):
        fail("L0912", "not supported yet: the linear form of a scene whose frames move with time", span)
    if given is not None:
        point, is_numeric = tuple(exact(given.get(name, 0.0)) for name in scene.names), False
    else:
        point, is_numeric = equilibrium(e, static, numbers, starts)
    here = dict(zip(scene.q, point, strict=True)) | ({x: exact(v) for x, v in numbers.items()} if is_numeric else {})
    still = dict.fromkeys(scene.v, sp.S.Zero)

    def at(x: Expr) -> Expr:
        return e.ring.tidy(_evaluated(_put(e.ring.tidy(x), here | still), is_numeric))

    M = tuple(tuple(at(x) for x in row) for row in e.M)
    C = tuple(tuple(at(x.diff(v)) for v in scene.v) for x in force)
    K = tuple(tuple(at(x.diff(q)) for q in scene.q) for x in static)
    if any(x.has(sp.nan, sp.zoo, sp.oo) for row in (*M, *C, *K) for x in row):
        fail("L0713", "the forces have no slope at the point to linearise about", span, "give another: --about NAME=VALUE,...")
    is_still = all(e.ring.is_zero(_put(x, here)) or _is_small(_put(x, here), numbers) for x in static)
    rest = [at(x) for x in static]
    load = tuple(e.ring.tidy(-at(x) + (r if is_still else 0)) for x, r in zip(force, rest, strict=True))
    return Linear(point, is_numeric, is_still, M, C, K, load)


def _sources(e: Equations) -> list[Expr]:
    """What drives the scene: inputs and given functions of time. An equilibrium is sought without them."""
    scene = e.scene
    return [*scene.inputs.values(), *(x for g in scene.given for x in g.moving if g.value.has(scene.t))]


def _put(x: Expr, values: Mapping[Expr, Expr]) -> Expr:
    return x.subs(list(values.items())) if values else x


def _evaluated(x: Expr, wholly: bool) -> Expr:
    """Sines and cosines of numbers as numbers, but for fractions of pi, which are exact already; `wholly` all else, too."""
    kinds = (sp.Function, sp.Pow) if wholly else (sp.sin, sp.cos)
    return x.xreplace({f: exact(float(f)) for f in x.atoms(*kinds) if f.is_number and f.is_real and f.is_finite})


def _is_small(x: Expr, numbers: Mapping[Expr, float]) -> bool:
    value = sp.N(x.subs(list(numbers.items())))
    return bool(value.is_number and abs(complex(value)) < 1e-9)


# -------------------------------------------------------------------- equilibrium


def equilibrium(e: Equations, static: list[Expr], numbers: Mapping[Expr, float], starts: Mapping[str, float]
                ) -> tuple[tuple[Expr, ...], bool]:
    """A point where the static forces vanish: coordinates in sines and cosines at quarter turns, others from linear equations;
    or numbers by Newton's method (then True)."""
    q = e.scene.q
    turning = [x for x in q if any(f.has(x) and any(w.has(x) for w in f.atoms(sp.sin, sp.cos)) for f in static)]
    found: list[tuple[Expr, ...]] = []
    if len(turning) <= _MOST_ANGLES:
        for angles in combinations(_TRIED, repeat=len(turning)):
            point = _completed(e, static, dict(zip(turning, angles, strict=True)))
            if point is not None:
                found.append(point)
                if _is_stable(e, static, point, numbers):
                    return point, False
    return (found[0], False) if found else (_newton(e, static, numbers, starts), True)


def _completed(e: Equations, static: list[Expr], angles: Mapping[Expr, Expr]) -> tuple[Expr, ...] | None:
    others = [x for x in e.scene.q if x not in angles]
    left = [e.ring.tidy(_put(f, angles)) for f in static]
    values: dict[Expr, Expr] = {}
    if others:
        A = sp.Matrix([[f.diff(x) for x in others] for f in left])
        if any(entry.free_symbols & set(e.scene.q) for entry in A):
            return None
        free = [x for k, x in enumerate(others) if any(A[:, k])]
        values = dict.fromkeys((x for x in others if x not in free), sp.S.Zero)
        solved = sp.solve([f for f in left if f.free_symbols & set(free)], free, dict=True) if free else [{}]
        if not solved or not isinstance(solved[0], dict):
            return None
        values |= {x: solved[0].get(x, sp.S.Zero).subs(dict.fromkeys(free, 0)) for x in free}
    whole = {**angles, **values}
    if not all(e.ring.is_zero(sp.together(_put(f, whole))) or sp.simplify(_put(f, whole)) == 0 for f in left):
        return None
    return tuple(whole[x] for x in e.scene.q)


def _is_stable(e: Equations, static: list[Expr], point: tuple[Expr, ...], numbers: Mapping[Expr, float]) -> bool:
    here = list(zip(e.scene.q, point, strict=True))
    K = sp.Matrix([[f.diff(x).subs(here).subs(list(numbers.items())) for x in e.scene.q] for f in static])
    if any(not entry.is_number for entry in K):
        return False
    return all(float(sp.re(x)) >= -1e-9 for x in sp.Matrix((K + K.T) / 2).evalf().eigenvals(multiple=True))


def _newton(e: Equations, static: list[Expr], numbers: Mapping[Expr, float], starts: Mapping[str, float]) -> tuple[Expr, ...]:
    import numpy as np

    q = list(e.scene.q)
    values = [f.subs(list(numbers.items())) for f in static]
    force = sp.lambdify([q], values, "numpy")
    slope = sp.lambdify([q], [[e.ring.tidy(f.diff(x)) for x in q] for f in values], "numpy")
    x = np.array([starts.get(name, 0.0) for name in e.scene.names], dtype=float)
    for _ in range(100):
        with np.errstate(all="ignore"):
            K, f = np.array(slope(x), dtype=float), np.array(force(x), dtype=float)
        if not (np.isfinite(K).all() and np.isfinite(f).all()):
            break
        step = np.linalg.lstsq(K, -f, rcond=None)[0]
        x = x + step * min(1.0, 1.0 / max(1e-12, float(np.abs(step).max())))
        if float(np.abs(step).max()) < 1e-13 * max(1.0, float(np.abs(x).max())):
            return tuple(exact(v) if abs(v) > 1e-12 else sp.S.Zero for v in map(float, x))
    fail("L0713", "no equilibrium was found to linearise about", e.scene.kinematics.graph.model.span,
         "give a point: --about NAME=VALUE,...")


# -------------------------------------------------------------------- the page


def linear_form(book: Book, linear: Linear) -> Document:
    """M, C, K and the load about the point; of one coordinate the equation itself."""
    if linear.is_numeric:
        book = replace(book, presentation=replace(book.presentation, symbols=replace(book.presentation.symbols, digits=6)))
    p, prefix = book.presentation, "Δ" if any(x != 0 for x in linear.point) else ""
    has_C, has_K = (any(x != 0 for row in A for x in row) for A in (linear.C, linear.K))
    has_load = any(x != 0 for x in linear.load)
    about: list[Block] = [_about(book, linear, bool(prefix))]
    if book.equations.n == 1:
        return page(book, [*about, Display((_single(book, linear, prefix),)), *where(book)])
    q = replace(bold("q"), prefix=prefix)
    left = [(1, product([bold("M"), replace(q, marks=2)]))]
    left += [(1, product([bold("C"), replace(q, marks=1)]))] if has_C else []
    left += [(1, product([bold("K"), q]))] if has_K else []
    lines: list[Node] = [equal(q, column([replace(x, prefix=prefix) for x in book.q]))]
    for name, A, wanted in (("M", linear.M, True), ("C", linear.C, has_C), ("K", linear.K, has_K)):
        lines += matrix(bold(name), [[p.coefficient(x) for x in row] for row in A], name) if wanted else []
    lines += matrix(bold("f"), [[p.sum(x)] for x in linear.load], "f") if has_load else []
    whole = equal(total(left), bold("f") if has_load else p.sum(sp.S.Zero))
    return page(book, [*about, Display((whole,)), paragraph("with"), Display(tuple(lines)), *where(book)])


def _single(book: Book, linear: Linear, prefix: str) -> Node:
    """m x'' + c x' + k x = f."""
    p, (q,) = book.presentation, book.q
    pairs = [(A[0][0], replace(q, marks=marks, prefix=prefix)) for A, marks in ((linear.M, 2), (linear.C, 1), (linear.K, 0))]
    terms = [(1, product([*([p.coefficient(x)] if x != 1 else []), name])) for x, name in pairs if x != 0]
    return equal(total(terms), p.sum(linear.load[0]))


def _about(book: Book, linear: Linear, is_moved: bool) -> Block:
    what = "the equilibrium" if linear.is_equilibrium else "a point that is no equilibrium,"
    if not is_moved:
        parts: list[str | Node] = [f"Small motion about {what} "]
        names: list[str | Node] = []
        for q in book.q:
            names += [" = " if names else "", q]
        return paragraph(*parts, *names, " = 0:")
    pairs: list[str | Node] = []
    for q, x in zip(book.q, linear.point, strict=True):
        pairs += [", " if pairs else "", equal(_resting(q), book.presentation.sum(x))]
    how = ", found with the parameters' values" if linear.is_numeric else ""
    return paragraph(f"Small motion about {what} ", *pairs, f"{how}:")


def _resting(q: Name) -> Name:
    return Name(q.base, f"{q.sub} 0".strip())


def values_of(book: Book) -> dict[Expr, float]:
    """Numbers for every parameter, and for constant loads."""
    scene = book.equations.scene
    found = {p.symbol: book.values[p.name] for p in scene.parameters if math.isfinite(book.values.get(p.name, math.nan))}
    found |= {g.symbol: float(g.value.subs(list(found.items()))) for g in scene.given if not g.value.has(scene.t)
              and g.value.subs(list(found.items())).is_number}
    return found
