"""Equations -> what every form needs to lay them out: the names on paper, the layouts, the tables of symbols."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import count

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.base.cutting import stem
from lagrangia.paper.equations import ACCELERATION, Equations
from lagrangia.paper.grouping import Rank, Symbols
from lagrangia.paper.layout import Name
from lagrangia.paper.notation import LETTERS_OF_PAGES, Wanted, name_all, own_letters
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.symbolic import GRAVITY, SymbolicScene

_MOST_SEEN = 700  # terms of equations that are laid out to see how their brackets stand
_NUMBER, _LOAD, _MASS, _GRAVITY, _LENGTH, _OTHER = range(-2, 4)


def used_symbols(scene: SymbolicScene) -> set[Expr]:
    """All symbols of energies, loads, constraints and given functions."""
    e = scene.energies
    parts = [t.value for group in (e.kinetic, e.potential, e.dissipation) for t in group]
    parts += [x for load in e.loads for x in (*load.force, *load.position)]
    parts += [*scene.rows, *scene.dependents.values()]
    found = {s for x in parts for s in exact_throughout(x).free_symbols}
    for given in scene.given:
        if found & {given.symbol, given.rate, given.acceleration}:
            found |= {s for x in (given.symbol, given.rate, given.acceleration, given.value) for s in x.free_symbols}
    while more := {s for p in scene.parameters if p.symbol in found and p.formula is not None
                   for s in sp.sympify(p.formula).free_symbols} - found:
        found |= more
    return found | set(scene.q)


def name_symbols(scene: SymbolicScene, chosen: Mapping[str, str]) -> Mapping[Expr, Name]:
    """The name on paper of every symbol that is used; `chosen` may have letters of pages too. Raises LagError L0711."""
    used = used_symbols(scene)
    wanted = [Wanted(name) for name in (*scene.names, *(name for turning in scene.turnings for name in turning.quaternion))]
    wanted += [Wanted(p.name) for p in scene.parameters if p.symbol in used]
    shown = [g for g in scene.given if used & {g.symbol, g.rate, g.acceleration}]
    wanted += [Wanted(g.name, g.what == "load", g.what != "coordinate" and g.value.has(scene.t)) for g in shown]
    wanted += [Wanted(name) for name in scene.dependents]
    wanted += [Wanted(label, False, True) for label, x in scene.inputs.items() if x in used]
    sources = {item.source for item in wanted}
    chosen = {source: text for source, text in chosen.items() if source in sources or source not in LETTERS_OF_PAGES}
    time = Name("t")
    names = name_all(wanted, chosen, [time, *(multiplier_name(k, len(scene.rows)) for k in range(len(scene.rows)))])
    found: dict[Expr, Name] = {scene.t: time}
    found |= {p.symbol: names[p.name] for p in scene.parameters if p.symbol in used}
    found |= {x: names[label] for label, x in scene.inputs.items() if x in used}
    found |= {sp.Symbol(name, real=True): names[name] for name in scene.dependents}
    moving = [(name, symbols) for name, *symbols in zip(scene.names, scene.q, scene.v, scene.a, strict=True)]
    moving += [(g.name, list(g.moving)) for g in shown]
    found |= {x: replace(names[name], marks=marks) for name, symbols in moving for marks, x in enumerate(symbols)}
    for turning in scene.turnings:
        found |= {x: names[name] for x, name in zip(turning.parts, turning.quaternion, strict=True)}
        for k in turning.places:  # the rates have the name
            found |= {x: replace(found[scene.q[k]], marks=marks) for x, marks in ((scene.v[k], 0), (scene.a[k], 1))}
    return found


def letters_of(scene: SymbolicScene, names: Mapping[Expr, Name], chosen: Mapping[str, str]) -> Mapping[str, Name]:
    """The letters that were chosen for those of the pages: D=sigma. Raises LagError L0711."""
    named = [*(p.name for p in scene.parameters), *(g.name for g in scene.given)]
    return own_letters([*scene.names, *named, *scene.dependents, *scene.inputs], chosen, names.values())


def presentation_of(e: Equations, names: Mapping[Expr, Name], most_products: int, digits: int = 0) -> Presentation:
    """How expressions of a scene are shown, with these names; `digits` of numbers, 0 for the usual count."""
    scene = e.scene
    named = dict(names) | {x: multiplier_name(k, len(e.multipliers)) for k, x in enumerate(e.multipliers)}
    moving = {scene.t, *scene.inputs.values(), *(x for g in scene.given for x in g.moving if g.value.has(scene.t))}
    coordinates = scene.placed, scene.v, scene.a
    symbols = Symbols(named, ranks(scene), *coordinates, e.multipliers, frozenset(moving), digits,
                      _lengths(e, set(named.values())), loads_of(scene), weights_of(scene))
    presentation = Presentation(symbols, most_products, e.ring)
    for k in range(e.n if e.terms <= _MOST_SEEN else 0):
        presentation.equation(e.left[k] + e.reactions[k], e.f[k], k)  # as sums of parameters stand here, they stand everywhere
    return presentation


def ranks(scene: SymbolicScene) -> dict[Expr, Rank]:
    """The order in a product: numbers, loads, masses and stiffnesses, g, lengths; in each as the model declares them."""
    places = {name: k for k, name in enumerate(scene.kinematics.graph.model.variables)}
    found = {p.symbol: (_kind(p.name, p.unit), places.get(p.name.partition("[")[0], 0)) for p in scene.parameters}
    return found | {x: (_LOAD, k) for k, x in enumerate(sorted(loads_of(scene), key=str))}


def _kind(name: str, unit: str) -> int:
    if name.startswith(GRAVITY) or unit == ACCELERATION:
        return _GRAVITY
    if unit.startswith(("kg", "N", "J", "W")):
        return _MASS
    return _NUMBER if unit in ("", "1") else _LENGTH if unit == "m" else _OTHER


def loads_of(scene: SymbolicScene) -> frozenset[Expr]:
    """The symbols of given forces and torques, and of inputs that are."""
    variables = scene.kinematics.graph.model.variables
    inputs = {x for label, x in scene.inputs.items() if variables[stem(label)].unit in ("N", "N.m")}
    return frozenset(inputs | {x for g in scene.given if g.what == "load" for x in g.moving})


def weights_of(scene: SymbolicScene) -> frozenset[Expr]:
    """The symbols of gravity."""
    return frozenset(p.symbol for p in scene.parameters if p.name.startswith(GRAVITY) or p.unit == ACCELERATION)


def _lengths(e: Equations, taken: set[Name]) -> dict[Expr, Name]:
    """Roots of long sums get a name: l, or l_1, l_2, by what stands under the root."""
    found: dict[Expr, None] = {}
    for x in (e.T, e.V_elastic, e.D, *e.left, *e.f, *e.rows):
        roots = sorted((p for p in x.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2 and p.base.is_Add), key=str)
        found |= dict.fromkeys(p.base for p in roots if len(p.base.args) > 2)
    free = (name for k in count(int(len(found) > 1)) for name in [Name("ell", str(k or ""))] if name not in taken)
    return dict(zip(found, free, strict=False))


def multiplier_name(k: int, count: int) -> Name:
    """lambda, with an index where there are several."""
    return Name("lambda", str(k + 1) if count > 1 else "")
