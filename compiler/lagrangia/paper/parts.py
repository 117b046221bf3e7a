"""What acts in a scene, told apart as textbooks do: elastic, weights, sources, dissipation, and forces that are none of these.

A load that depends on time and inputs alone is a source: its potential is -F . r, without what does not move. A force of
positions has no potential, one of rates (drag) is non-conservative.
"""

from collections.abc import Sequence

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Load, Term
from lagrangia.paper.equations import Equations, load_force, split_potential


@dataclass(frozen=True)
class Parts:
    """Terms as they are stated, but for those that are 0; sums in normal form, vectors by coordinate."""

    kinetic: tuple[Term, ...]
    elastic: tuple[Term, ...]
    weights: tuple[Term, ...]  # and other potentials of what is given
    sources: tuple[tuple[Load, Expr], ...]  # loads with their potentials, where these are asked for
    dissipation: tuple[Term, ...]
    applied: tuple[Load, ...]  # without a potential, or not asked by it
    drags: tuple[Load, ...]  # of rates
    V_elastic: Expr
    V_field: Expr
    elastic_slopes: tuple[Expr, ...]  # dV_e/dq
    field_slopes: tuple[Expr, ...]  # dV_f/dq
    dissipated: tuple[Expr, ...]  # dD/dv
    applied_forces: tuple[Expr, ...]
    drag_forces: tuple[Expr, ...]

    @property
    def field(self) -> Expr:
        """V_f as it is stated."""
        return sp.Add(*(exact_throughout(t.value) for t in self.weights), *(x for _, x in self.sources))

    @property
    def stated_elastic(self) -> Expr:
        """V_e as it is stated."""
        return sp.Add(*(exact_throughout(t.value) for t in self.elastic))

    @property
    def stated_dissipation(self) -> Expr:
        """D as it is stated."""
        return sp.Add(*(exact_throughout(t.value) for t in self.dissipation))


def parts_of(e: Equations, has_source_potentials: bool) -> Parts:
    """What acts, told apart."""
    scene, tidy = e.scene, e.ring.tidy
    energies, model = scene.energies, scene.kinematics.graph.model
    loads = {x for g in scene.given if g.what == "load" for x in g.moving}
    field, elastic = split_potential(energies, model)
    driven = tuple(t for t in elastic if exact_throughout(t.value).free_symbols & loads)
    elastic = tuple(t for t in elastic if t not in driven)
    sources = [x for x in energies.loads if has_source_potentials and _is_source(e, x)]
    drags = [x for x in energies.loads if _symbols(x.force) & set(scene.v)]
    applied = [x for x in energies.loads if x not in sources and x not in drags]
    potentials = [(x, _potential(e, x)) for x in sources]
    V_source = tidy(sp.Add(*(x for _, x in potentials)))
    V_driven = tidy(sp.Add(*(exact_throughout(t.value) for t in driven)))
    slopes = tuple(tidy(e.ring.slope(V_source + V_driven, q)) for q in scene.q)
    return Parts(_shown(e, energies.kinetic), _shown(e, elastic), _shown(e, (*field, *driven)), tuple(potentials),
                 _shown(e, energies.dissipation), tuple(applied), tuple(drags), tidy(e.V_elastic - V_driven),
                 tidy(e.V_field + V_source + V_driven),
                 tuple(tidy(x - e.ring.slope(V_driven, q)) for x, q in zip(e.dVe_dq, scene.q, strict=True)),
                 tuple(tidy(x - y + z) for x, y, z in zip(e.dV_dq, e.dVe_dq, slopes, strict=True)), e.dD_dv,
                 _forces(e, applied), _forces(e, drags))


def _shown(e: Equations, terms: tuple[Term, ...]) -> tuple[Term, ...]:
    return tuple(t for t in terms if e.ring.tidy(exact_throughout(t.value)) != 0)


def _symbols(values: Sequence[Expr]) -> set[Expr]:
    return {y for x in values for y in exact_throughout(x).free_symbols}


def _is_source(e: Equations, load: Load) -> bool:
    return not load.moving[1] and not _symbols(load.force) & {*e.scene.q, *e.scene.v, *e.scene.a}


def _potential(e: Equations, load: Load) -> Expr:
    """-F . r, without what does not depend on the coordinates."""
    found = []
    for force, place in zip(load.force, load.position, strict=True):
        r = e.ring.tidy(exact_throughout(place))
        moved = sp.Add(*(x for x in sp.Add.make_args(r) if x.free_symbols & set(e.scene.q)))
        found.append(-exact_throughout(force) * moved)
    return sp.Add(*found)


def _forces(e: Equations, loads: Sequence[Load]) -> tuple[Expr, ...]:
    return tuple(e.ring.tidy(sp.Add(*(load_force(x, e.scene, k) for x in loads))) for k in range(e.n))
