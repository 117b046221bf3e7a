"""The derivation's checks: units of every term, the mass matrix symmetric and positive, the energy theorem.

Each is computed, and said where it holds: a term of another unit, or a matrix that is not positive, is not passed over.
"""

import math
import random
from collections.abc import Mapping
from fractions import Fraction

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.cutting import stem
from lagrangia.language.frame_attributes import component_named
from lagrangia.language.units import ONE, Dimension, divide, multiply, parse_unit, power, spell
from lagrangia.paper.book import Book, bold, equal, time_derivative
from lagrangia.paper.document import Block, Display, Heading, Inline, paragraph, say
from lagrangia.paper.layout import Name, Node, Product, Relation, Words, added, total

_ENERGY, _TIME = parse_unit("J").dimension, parse_unit("s").dimension
_FORCES = {parse_unit("N").dimension: "N", parse_unit("N.m").dimension: "N.m"}
_POSITIONS, _NEAR = 20, 0.3
_LARGEST_MINORS = 2


class _Unlike(Exception):
    """Terms of different dimensions meet, or one of a dimension that is not known."""


def checks(book: Book) -> list[Block]:
    """What a reader checks at the end."""
    blocks = [*_units(book), *_mass_matrix(book), *_energy_theorem(book)]
    return [Heading(say("Checks"), 2), *blocks] if blocks else []


# -------------------------------------------------------------------- units


def _units(book: Book) -> list[Block]:
    """N or N.m for each equation, where all of its terms have it; numbers with units of their own leave nothing to check."""
    e, p = book.equations, book.parts
    known = dimensions_of(book)
    told: list[Inline] = []
    for k, q in enumerate(e.scene.q):
        left = e.momentum_rates[k] - e.dT_dq[k] + p.elastic_slopes[k] + p.field_slopes[k] + p.dissipated[k]
        wanted = divide(_ENERGY, known[q])
        try:
            found = {dimension_of(x, known) for side in (left, p.applied_forces[k] + p.drag_forces[k])
                     for x in sp.Add.make_args(sp.expand(side)) if x != 0}
        except _Unlike:
            return []
        if found - {wanted}:
            return []
        told += ["; " if told else "", say("{0}: {1}", book.q[k], _FORCES.get(wanted, spell(wanted)))]
    return [paragraph(say("Each term of the equations has one unit, {0}.", told))]


def dimensions_of(book: Book) -> dict[Expr, Dimension]:
    """Of every symbol whose unit is known."""
    scene = book.equations.scene
    model = scene.kinematics.graph.model
    found: dict[Expr, Dimension] = {scene.t: _TIME}

    def keep(symbols: tuple[Expr, ...], unit: str) -> None:
        here = parse_unit(unit or "1").dimension
        for x in symbols:
            found[x] = here
            here = divide(here, _TIME)

    for name, *symbols in zip(scene.names, scene.q, scene.v, scene.a, strict=True):
        variable = model.variables.get(name)
        keep(tuple(symbols), variable.unit if variable else component_named(name).unit)
    for p in scene.parameters:
        keep((p.symbol,), p.unit)
    for g in scene.given:
        variable = model.variables.get(stem(g.name))
        if variable is not None:
            keep(g.moving, variable.unit)
    for label, x in scene.inputs.items():
        keep((x,), model.variables[stem(label)].unit)
    return found


def dimension_of(x: Expr, known: Mapping[Expr, Dimension]) -> Dimension:
    """Of an expression. Raises _Unlike for a sum of unlike terms, and where a symbol's is not known."""
    if x.is_number:
        return ONE
    if x in known:
        return known[x]
    if x.is_Mul:
        whole = ONE
        for factor in x.args:
            whole = multiply(whole, dimension_of(factor, known))
        return whole
    if x.is_Add or isinstance(x, sp.Max | sp.Min):
        kinds = {dimension_of(y, known) for y in x.args if y != 0}
        if len(kinds) != 1:
            raise _Unlike
        return kinds.pop()
    if x.is_Pow and x.exp.is_Rational:
        return power(dimension_of(x.base, known), Fraction(int(x.exp.p), int(x.exp.q)))
    if isinstance(x, sp.Abs):
        return dimension_of(x.args[0], known)
    if isinstance(x, sp.sign):
        return ONE
    if x.is_Function and all(dimension_of(y, known) == ONE for y in x.args):
        return ONE
    raise _Unlike


# -------------------------------------------------------------------- the mass matrix


def _mass_matrix(book: Book) -> list[Block]:
    """Its determinant where it is short, and whether it is positive at positions taken at random, with the parameters' values."""
    e, M = book.equations, bold("M")
    minors = _minors(book)
    if minors is None or e.n == 1:
        return []
    if min(minors) <= 0:
        return [paragraph(say("{0} is symmetric but not positive: not every motion has kinetic energy.", M))]
    if e.n != _LARGEST_MINORS:
        return [paragraph(say("{0} is symmetric, and positive at {1} positions taken at random.", M, str(_POSITIONS)))]
    (a, b), (_, d) = e.M
    names = [Name("M", label) for label in ("11", "22", "12")]
    squares = total([(1, Product((names[0], names[1]))), (-1, book.presentation.square(names[2]))])
    squares = squares if b != 0 else Product((names[0], names[1]))
    value = book.presentation.coefficient(e.ring.tidy(a * d - b * b))
    determinant = Product((Words("det"), M))
    lines: list[Node] = [equal(names[0], Relation(book.presentation.coefficient(a), total([]), ">")),
                         equal(determinant, equal(squares, Relation(value, total([]), ">")))]
    return [paragraph(say("{0} is symmetric and positive:", M)), Display(tuple(lines))]


def _minors(book: Book) -> list[float] | None:
    """The leading minors at random positions; None where there are no numbers."""
    e = book.equations
    values = {p.symbol: book.values.get(p.name, math.nan) for p in e.scene.parameters}
    free = sorted({x for row in e.M for y in row for x in y.free_symbols}, key=str)
    if any(x not in e.scene.q and not math.isfinite(values.get(x, math.nan)) for x in free):
        return None
    function = sp.lambdify(free, [x for row in e.M for x in row], "math")
    chance = random.Random(5)
    found: list[float] = []
    for _ in range(_POSITIONS):
        at = [values[x] if x in values else chance.uniform(_NEAR, 2) for x in free]
        M = sp.Matrix(e.n, e.n, function(*at))
        size = max(abs(float(x)) for x in M) or 1.0
        found += [float((M[:k, :k] / size).det()) for k in range(1, e.n + 1)]
    return found


# -------------------------------------------------------------------- the energy theorem


def _energy_theorem(book: Book) -> list[Block]:
    """d/dt (T + V), without potentials of sources, is the power of all other forces, where T and V know no time."""
    e, p = book.equations, book.parts
    tidy = e.ring.tidy
    V_source = sp.Add(*(x for _, x in p.sources))
    V = tidy(p.V_elastic + p.V_field - V_source)
    rates = dict.fromkeys(e.scene.v, sp.S.Zero)
    timed = {e.scene.t, *(x for g in e.scene.given for x in g.moving), *e.scene.inputs.values()}
    is_fixed = not (e.T + V).free_symbols & timed and tidy(e.T.xreplace(rates)) == 0
    has_linear = any(tidy(x.xreplace(rates)) != 0 for x in e.momenta)
    holds = all(e.ring.along(row, e.scene.given_rates) == 0 for row in e.rows[: e.scene.holonomic])
    homogeneous = all(row.xreplace(rates) == 0 for row in e.rows[e.scene.holonomic :])
    powers = [-d - e.ring.slope(V_source, q) + a + r
              for q, d, a, r in zip(e.scene.q, p.dissipated, p.applied_forces, p.drag_forces, strict=True)]
    whole = tidy(sp.Add(*(x * v for x, v in zip(powers, e.scene.v, strict=True))))
    if whole == 0 or not is_fixed or has_linear or not holds or not homogeneous:
        return []
    energies = [book.own("T"), *([book.own("V", "e")] if p.elastic else []), *([book.own("V", "w")] if p.weights else [])] \
        if p.sources else [book.own("T"), *([book.own("V")] if V != 0 else [])]
    words = say("The energy theorem, with {0} of weights: what has no potential, and sources, change the energy by their power:",
                book.own("V", "w")) if p.sources and p.weights else \
        say("The energy theorem: what has no potential, and sources, change the energy by their power:")
    return [paragraph(words), Display((equal(time_derivative(added(*energies)), book.sum(whole)),))]
