"""Initial equations -> warnings where another start fits what is stated as well, as of der(x)^2 = 4 the rate of the other sign.

Which one a run takes is the nearest to where the search begins. That is what was asked for where a start is stated for one of
the values in question, and this is nearer to it; else the choice was nobody's.
"""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.diagnostics import Report
from lagrangia.constraints.assemblies import Search
from lagrangia.constraints.assembly import Assembly, begin
from lagrangia.constraints.initial import FIXED, GUESS, InitialConditions
from lagrangia.constraints.vanishing_sums import VanishingSums
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import rate_of

_MOST_VALUES = 60  # coordinates of scenes that are looked at
_NEARER, _CLOSED, _MOVED = 0.9, 1e-9, 1e-3


def find_several_starts(kinematics: Kinematics, initial: InitialConditions, table: Mapping[str, ca.Function]) -> Report:
    """L0609, with the parameters as declared, for starts as runs find them by the functions of `table`. Nothing is looked for
    where no exact start is left to be followed by others."""
    report, n, positions = Report(), len(initial.fixed) // 2, initial.n_positions
    _tell_touching(kinematics, initial, report)
    stated = _stated(kinematics, initial)
    is_held = positions > 0 and FIXED in initial.fixed[:n] and GUESS not in initial.fixed[:n]  # and nobody chose how loops close
    is_asked = [is_held or any(k < positions for k in stated), any(k >= positions for k in stated)]
    is_asked = [asked and _bends(kinematics, initial, of_rates) for of_rates, asked in enumerate(is_asked)]
    if not any(is_asked) or n > _MOST_VALUES:
        return report
    assembly = begin(kinematics, initial, table)
    if not stated and not np.abs(assembly.equations(assembly.guess)[0][:positions]).max() > _CLOSED:
        return report  # it stands as it is drawn
    x, failed = assembly.assemble()
    if failed >= 0 or not np.isfinite(x).all():
        return report
    if is_asked[1]:
        _tell_moved(kinematics, initial, assembly, x, report)
    with np.errstate(all="ignore"):
        for of_rates in (False, True):
            if is_asked[of_rates]:
                _tell(kinematics, Search(kinematics, initial, assembly, x, of_rates), stated, report)
    return report


def _stated(kinematics: Kinematics, initial: InitialConditions) -> set[int]:
    """The residuals that come from initial equations, or give a value to what loops give."""
    spans = {equation.span for equation in kinematics.graph.model.initial_equations}
    n, lost = len(initial.fixed) // 2, len(initial.lost)
    symbols = [*zip(initial.lost_q.elements(), initial.fixed[n - lost : n], strict=True),
               *zip(initial.lost_v.elements(), initial.fixed[2 * n - lost :], strict=True)]
    held = {x.__hash__() for x, kind in symbols if kind == FIXED}
    return {k for k, (residual, span) in enumerate(zip(initial.residuals.elements(), initial.residual_spans, strict=True))
            if span in spans or (held and not held.isdisjoint(symbols_in(residual)))}


def _bends(kinematics: Kinematics, initial: InitialConditions, of_rates: int) -> bool:
    """Whether an equation is not linear in the positions, or in the rates: else there is one solution."""
    n, symbols = initial.n_positions, kinematics.symbols
    names, lost = (symbols.rates, initial.lost_v) if of_rates else (symbols.positions, initial.lost_q)
    rows = initial.residuals[n:] if of_rates else initial.residuals[:n]
    return any(ca.which_depends(rows, ca.vertcat(*names.values(), lost), 2, True))


def _tell_touching(kinematics: Kinematics, initial: InitialConditions, report: Report) -> None:
    """Initial equations that hold where their slopes vanish, by the values of parameters."""
    stated = {equation.span for equation in kinematics.graph.model.initial_equations}
    sums = VanishingSums(kinematics)
    touching = {span for residual, span in zip(initial.residuals.elements(), initial.residual_spans, strict=True)
                if span in stated and sums.only_touches(residual)}
    for span in initial.residual_spans:
        if span in touching:
            touching.remove(span)
            report.warning("L0609", "with the parameters as declared this only just holds: a run begins within half of the "
                           "digits of it, if at all", span,
                           "state what vanishes there, as x - 1 = 0, or make the parameter a constant")


def _tell_moved(kinematics: Kinematics, initial: InitialConditions, assembly: Assembly, x: Vector, report: Report
                ) -> None:
    """Places that are stated, moved by equations of rates for want of a direction: their slopes vanish where rates do."""
    coordinates, n = (*kinematics.graph.coordinates, *initial.lost), assembly.n
    free = [k for k in range(n) if initial.fixed[n + k] not in (FIXED, GUESS)]
    moved = [k for k in range(n) if initial.fixed[k] == GUESS and not coordinates[k].attitude
             and abs(x[k] - assembly.guess[k]) > _MOVED * assembly.reach[k]]
    if initial.n_positions or not moved or not free:
        return
    told = ", ".join(f"{coordinates[k].name} at {x[k]:.4g} {coordinates[k].unit}" for k in moved[:4])
    names = " or ".join(f"der({coordinates[k].name})" for k in free[:3])
    report.warning("L0609", f"this moves starts that are stated: {told}; of the rates that could make it hold, none says which "
                   "way it goes", initial.residual_spans[0], f"state a start for {names}")


def _tell(kinematics: Kinematics, search: Search, stated: set[int], report: Report) -> None:
    first, is_fixed = search.rows.start or 0, search.fixed == FIXED
    for rows, columns in search.blocks()[: search.most_blocks]:
        own = [first + k for k in rows if first + k in stated]
        is_asked = own or search.pattern[rows][:, is_fixed].any()
        others = search.others(rows, columns) if is_asked else []
        shown = search.shown(columns, others) if others else []
        if not shown or all(_is_chosen(search, other) for other in others):
            continue
        report.warning("L0609", f"{len(others) + 1} starts fit this: taken {search.values(search.x, shown)}; there is "
                       f"{search.told(others, shown)}", search.initial.residual_spans[own[0] if own else first + rows[0]],
                       f"state a start near the one that is meant, as {_words(kinematics, search, shown[0], others[0])}")


def _is_chosen(search: Search, other: Vector) -> bool:
    """Whether a stated start is nearer to what was taken than to another one."""
    guessed = np.flatnonzero(search.fixed == GUESS)
    here, there = (np.abs(x - search.guess)[guessed] / search.reach[guessed] for x in (search.x, other))
    return bool((here < _NEARER * there).any())


def _words(kinematics: Kinematics, search: Search, k: int, other: Vector) -> str:
    """How another start is stated."""
    name, value = search.coordinates[k].name, f"{other[k]:.4g}"
    if not search.of_rates:
        turned = (np.degrees(other[k]) + 180) % 360 - 180
        return f"{name}(start = {turned:.4g}[deg])" if search.angles[k] else f"{name}(start = {value})"
    model = kinematics.graph.model
    alias = next((v.name for v in model.variables.values() if rate_of(v) == name), "")
    if alias:
        return f"{alias}(start = {value})"
    frame = name.rpartition(".")[0]
    if frame in model.frames:
        places = [c.name for c in search.coordinates if c.name.rpartition(".")[0] == frame and c.unit == "m"]
        rates = ", ".join(f"{other[j]:.4g}" for j, c in enumerate(search.coordinates) if c.name in places)
        is_angle = search.coordinates[k].unit == "rad"
        return f"{frame}.w(start = {value})" if is_angle else f"{frame}.v(start = {{{rates}}})"
    return f"Real v(start = {value}) = {search.names[k]}"
