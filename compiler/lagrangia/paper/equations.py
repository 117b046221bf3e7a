"""SymbolicScene -> Lagrange's equations by SymPy's differentiation, every step kept for the reader.

    d/dt(dT/dv) - dT/dq + dV/dq + dD/dv + J^T lambda = f        M(q) dv/dt + h(q, v, t) + J^T lambda = f

Every expression is brought to its normal form (normal_form.py) as soon as it is made, so that the next step works on few terms.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cached_property

import sympy as sp

from lagrangia.algebra.normal_form import Ring, TooLarge
from lagrangia.algebra.with_sympy import Expr, exact, exact_throughout
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Energies, Load, Term
from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import leaves
from lagrangia.paper.symbolic import GRAVITY, SymbolicScene, mapped

ACCELERATION = "m/s2"  # the unit of gravity, also of one that a model brings along


_PRODUCTS_OF_MOMENTA = 50_000


@dataclass(frozen=True)
class Constant:
    """A quantity that the motion does not change, and why."""

    name: str  # "momentum", "angular momentum" or "energy"
    coordinate: int | None  # of angular momenta the place of the part of the attitude that stands for the axis
    value: Expr
    why: str  # of angular momenta: about axes "outside", that are turned against, or its "own"


@dataclass(frozen=True)
class Equations:
    """All in normal form. Vectors have n entries, M n x n, J m x n; the loads f stand on the right."""

    scene: SymbolicScene
    ring: Ring
    T: Expr
    V_elastic: Expr
    V_field: Expr
    D: Expr
    momenta: tuple[Expr, ...]  # dT/dv
    momentum_rates: tuple[Expr, ...]  # d/dt dT/dv
    dT_dq: tuple[Expr, ...]
    dV_dq: tuple[Expr, ...]
    dVe_dq: tuple[Expr, ...]
    dD_dv: tuple[Expr, ...]
    f: tuple[Expr, ...]
    M: tuple[tuple[Expr, ...], ...]
    h: tuple[Expr, ...]
    rows: tuple[Expr, ...]
    J: tuple[tuple[Expr, ...], ...]
    multipliers: tuple[Expr, ...]
    reactions: tuple[Expr, ...]  # J^T lambda
    carried: tuple[Expr, ...]  # w x dT/dw of attitudes, which are told in axes that turn

    @property
    def n(self) -> int:
        """The number of coordinates."""
        return len(self.scene.q)

    @cached_property
    def left(self) -> tuple[Expr, ...]:
        """M dv/dt + h, sums of what the steps gave."""
        tidy, n = self.ring.tidy, range(self.n)
        return tuple(tidy(self.momentum_rates[k] + self.carried[k] - self.dT_dq[k] + self.dV_dq[k] + self.dD_dv[k]) for k in n)

    @property
    def terms(self) -> int:
        """How many terms there are to read."""
        return sum(len(sp.Add.make_args(x)) for x in (*self.left, *self.f, *self.rows, *self.reactions))


def derive(scene: SymbolicScene, most_products: int, most_terms: int | None = None) -> Equations:
    """Raises TooLarge when more than `most_products` products are needed, or T alone has more than `most_terms` terms."""
    ring = ring_of(scene, most_products)
    tidy, energies, model = ring.tidy, scene.energies, scene.kinematics.graph.model
    T, D = (tidy(sum_of(terms)) for terms in (energies.kinetic, energies.dissipation))
    if most_terms is not None and len(T.args) > most_terms:
        raise TooLarge(len(T.args), T)
    field, elastic = (tidy(sum_of(terms)) for terms in split_potential(energies, model))
    V = tidy(elastic + field)

    def slopes(expression: Expr, of: tuple[Expr, ...]) -> tuple[Expr, ...]:
        return tuple(ring.slope(expression, x) for x in of)

    def by_places(expression: Expr) -> tuple[Expr, ...]:
        return tuple(ring.along(expression, scene.directions(k)) if k in scene.turned else ring.slope(expression, q)
                     for k, q in enumerate(scene.q))

    momenta = slopes(T, scene.v)
    rates = tuple(ring.along(p, scene.rates) for p in momenta)
    dT_dq, dV_dq, dVe_dq, dD_dv = by_places(T), by_places(V), by_places(elastic), slopes(D, scene.v)
    carried = [sp.S.Zero] * len(scene.q)
    for turning in scene.turnings:
        carried[turning.first : turning.first + 3] = map(tidy, turning.crossed(scene.v, momenta))
    M = tuple(slopes(p, scene.v) for p in momenta)
    at_rest = dict.fromkeys(scene.a, sp.S.Zero)
    h = tuple(tidy(rates[k].xreplace(at_rest) + carried[k] - dT_dq[k] + dV_dq[k] + dD_dv[k]) for k in range(len(scene.q)))
    rows = tuple(tidy(row) for row in scene.rows)
    J = tuple(by_places(row) if k < scene.holonomic else slopes(row, scene.v) for k, row in enumerate(rows))
    multipliers = tuple(sp.Symbol(f"multiplier {k + 1}", real=True) for k in range(len(rows)))  # no name of a quantity
    reactions = tuple(tidy(sum((x * row[k] for x, row in zip(multipliers, J, strict=True)), sp.S.Zero))
                      for k in range(len(scene.q)))
    f = generalised_force(scene, ring)
    slopes_of = dT_dq, dV_dq, dVe_dq, dD_dv
    return Equations(scene, ring, T, elastic, field, D, momenta, rates, *slopes_of, f, M, h, rows, J, multipliers, reactions,
                     tuple(carried))


def ring_of(scene: SymbolicScene, most_products: int) -> Ring:
    """For a scene's expressions; it knows that quaternions of attitudes have the norm 1."""
    ring = Ring(most_products)
    for turning in scene.turnings:
        first, *others = turning.parts
        ring.know_square(first, 1 - sp.Add(*(x**2 for x in others)))
    return ring


def without_rows(e: Equations, places: Collection[int]) -> Equations:
    """Without constraints that repeat others, and without their multipliers."""
    kept = [k for k in range(len(e.rows)) if k not in places]
    rows, J, multipliers = (tuple(x[k] for k in kept) for x in (e.rows, e.J, e.multipliers))
    none = dict.fromkeys(set(e.multipliers) - set(multipliers), sp.S.Zero)
    scene = replace(e.scene, rows=tuple(e.scene.rows[k] for k in kept), holonomic=sum(k < e.scene.holonomic for k in kept))
    reactions = tuple(x.xreplace(none) for x in e.reactions)
    return replace(e, scene=scene, rows=rows, J=J, multipliers=multipliers, reactions=reactions)


def sum_of(terms: tuple[Term, ...]) -> Expr:
    """The sum of energy terms, with exact numbers."""
    return sp.Add(*(exact_throughout(term.value) for term in terms))


def split_potential(energies: Energies, model: FlatModel) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Terms of V_f, which speak of gravity (that of the world, or a parameter that is an acceleration), and those of V_e."""
    named = {name for name, v in model.variables.items() if v.kind == "parameter" and v.unit == ACCELERATION} | {GRAVITY}
    bindings = {name: v.binding for name, v in model.variables.items() if v.kind == "variable"}

    def is_field(term: Term) -> bool:
        return any(getattr(leaf, "name", "") in named for leaf in leaves([term.statement.value], bindings))

    return (tuple(t for t in energies.potential if is_field(t)), tuple(t for t in energies.potential if not is_field(t)))


def generalised_force(scene: SymbolicScene, ring: Ring) -> tuple[Expr, ...]:
    """f_k = sum_i F_i . dr_i/dq_k."""
    return tuple(ring.tidy(sp.Add(*(load_force(load, scene, k) for load in scene.energies.loads))) for k in range(len(scene.q)))


def load_force(load: Load, scene: SymbolicScene, k: int) -> Expr:
    """The generalised force of a load on the k-th coordinate: F . dr/dq; of a torque on an attitude M . dw/dv."""
    moving, is_rate = load.moving
    along = [(scene.v[k], sp.S.One)] if is_rate else scene.directions(k)

    def moved(place: Expr) -> Expr:
        return sp.Add(*(exact_throughout(place).diff(x) * dx for x, dx in along))

    return sp.Add(*(exact_throughout(force) * moved(r) for force, r in zip(load.force, moving, strict=True)))


def constants_of_motion(e: Equations) -> tuple[Constant, ...]:
    """Momenta of cyclic coordinates, and the energy where nothing depends on time and nothing is lost.

    H = sum v dT/dv - T + V is constant when neither T, V nor Phi depends on t, D = 0 and f = 0; it is T + V when T is quadratic
    in the rates. Constant generalised forces count as potentials -f q.
    """
    scene, tidy = e.scene, e.ring.tidy
    found = []
    L = tidy(e.T - e.V_elastic - e.V_field)
    for k, q in enumerate(scene.q):
        is_free = e.f[k] == 0 and e.dD_dv[k] == 0 and e.reactions[k] == 0 and k not in scene.turned
        if is_free and e.ring.slope(L, q) == 0 and e.momenta[k] != 0:
            found.append(Constant("momentum", k, e.momenta[k], "cyclic"))
    found += _angular_momenta(e)
    driven = (x for g in scene.given for x in g.moving if g.value.has(scene.t))
    moving = {*scene.placed, *scene.v, scene.t, *scene.inputs.values(), *driven}
    is_lossless = e.D == 0 and not any(x.free_symbols & moving for x in e.f) and all(e.f[k] == 0 for k in scene.turned)
    holds = all(e.ring.along(row, scene.given_rates) == 0 for row in e.rows[: scene.holonomic])
    homogeneous = all(row.xreplace(dict.fromkeys(scene.v, sp.S.Zero)) == 0 for row in e.rows[scene.holonomic :])
    if is_lossless and holds and homogeneous and e.ring.along(L, scene.given_rates) == 0:
        work = sum((f * q for f, q in zip(e.f, scene.q, strict=True)), sp.S.Zero)
        H = sum((v * p for v, p in zip(scene.v, e.momenta, strict=True)), sp.S.Zero) - L - work
        is_energy = tidy(H - e.T - e.V_elastic - e.V_field + work) == 0
        found.append(Constant("energy" if is_energy else "Jacobi", None, tidy(H), "work" if work != 0 else "conservative"))
    return tuple(found)


def _angular_momenta(e: Equations) -> list[Constant]:
    """d(R p)/dt = R torque about axes that do not turn, and dp/dt = torque - w x p about those that do."""
    ring, found = ring_of(e.scene, _PRODUCTS_OF_MOMENTA), list[Constant]()
    try:
        for turning in e.scene.turnings:
            places = [*turning.places]
            torque = [e.dT_dq[k] - e.dV_dq[k] - e.dD_dv[k] + e.f[k] - e.reactions[k] for k in places]
            momenta = [e.momenta[k] for k in places]
            outside = zip(places, turning.outward(torque), turning.outward(momenta), strict=True)
            own = zip(places, (x - e.carried[k] for x, k in zip(torque, places, strict=True)), momenta, strict=True)
            for why, axes in (("outside", outside), ("own", own)):
                found += [Constant("angular momentum", k, ring.tidy(p), why) for k, x, p in axes if ring.is_zero(x)]
    except TooLarge:
        pass  # of such equations nobody reads these
    return [c for c in found if c.value != 0]


def with_values(scene: SymbolicScene, values: Mapping[Expr, float]) -> SymbolicScene:
    """The scene with numbers in place of parameters."""
    numbers = {symbol: exact(value) for symbol, value in values.items()}

    def put(x: Expr) -> Expr:
        return exact_throughout(x).xreplace(numbers)

    given = tuple(replace(g, rate=put(g.rate), acceleration=put(g.acceleration), value=put(g.value)) for g in scene.given)
    return replace(scene, energies=mapped(scene.energies, put), given=given,
                   rows=tuple(map(put, scene.rows)), dependents={n: put(x) for n, x in scene.dependents.items()}, parameters=())
