"""What this scene needs of all that a general simulation does, and what it does not: the reason, the place, the cost.

Costs are operations of the accelerations, counted by building them without the thing in question.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import casadi as ca

from lagrangia.constraints import Constraints
from lagrangia.diagnostics import Span
from lagrangia.energies import Energies
from lagrangia.evaluation import scalars_of
from lagrangia.initial import InitialConditions
from lagrangia.islands import find_islands
from lagrangia.kinematics import Kinematics
from lagrangia.motion import Motion, build_motion, count_nodes, mass_matrix
from lagrangia.scene import Scene
from lagrangia.spectrum import Spectrum, find_spectrum

_MOST_COUNTED = 60  # coordinates: in larger scenes nothing is built a second time only to be counted
_MOST_NAMES = 4


@dataclass(frozen=True)
class Need:
    """`place` is the source line that decides; `cost` is of what is needed, `saving` of what is not."""

    what: str
    is_needed: bool
    why: str
    place: str = ""
    cost: str = ""
    saving: str = ""


@dataclass(frozen=True)
class _Parts:
    kinematics: Kinematics
    constraints: Constraints
    energies: Energies
    motion: Motion
    initial: InitialConditions
    scene: Scene

    def operations(self, energies: Energies) -> int | None:
        """Operations of the accelerations of the same scene with other energies; None where counting would take too long."""
        if self.scene.n > _MOST_COUNTED:
            return None
        return self.count(build_motion(self.kinematics, energies, self.constraints).acceleration)

    def count(self, acceleration: ca.SX) -> int:
        return count_nodes([ca.SX(acceleration)], [self.kinematics.algebra.state, self.motion.t])


def find_needs(
    kinematics: Kinematics, constraints: Constraints, energies: Energies, motion: Motion, initial: InitialConditions, scene: Scene
) -> tuple[Need, ...]:
    """The table of needs, read off the equations."""
    parts = _Parts(kinematics, constraints, energies, motion, initial, scene)
    return (*_forces(parts), *_mass(parts), *_constraints(parts), *_time(parts), *_numerics(parts), *_products(parts))


# -------------------------------------------------------------------- forces


def _forces(parts: _Parts) -> Iterable[Need]:
    energies, motion = parts.energies, parts.motion
    whole = parts.count(motion.acceleration)
    without = parts.operations(replace(energies, dissipation=()))
    yield _listed("dissipation", [(t.component, t.statement.span) for t in energies.dissipation], "no component states one",
                  _share(whole, without), "dD/dv, its power and its quadrature")
    gravity = ca.vertcat(*scalars_of(parts.kinematics.symbols.values["world.gravity"]))
    heavy = [t for t in energies.potential if ca.depends_on(ca.SX(t.value), gravity)]
    light = tuple(replace(t, value=ca.substitute([ca.SX(t.value)], [gravity], [ca.SX.zeros(2)])[0]) for t in energies.potential)
    yield _listed("gravity", [(t.component, t.statement.span) for t in heavy], "nothing has weight",
                  _share(whole, parts.operations(replace(energies, potential=light)) if heavy else whole), "the weights")
    yield _listed("sources", [(w.statement.component, w.statement.span) for w in energies.loads], "no force or torque is applied",
                  _share(whole, parts.operations(replace(energies, loads=()))), "the virtual work of applied forces")
    yield _coriolis(parts)


def _coriolis(parts: _Parts) -> Need:
    """Terms of T that are quadratic in the rates, looked for where no damper hides them."""
    motion, what = parts.motion, "Coriolis terms"
    if parts.scene.n > _MOST_COUNTED:
        moves = ca.depends_on(motion.h, motion.v)
        return Need(what, moves, "h depends on the rates" if moves else "h does not depend on the rates")
    calm = build_motion(parts.kinematics, replace(parts.energies, dissipation=(), loads=()), parts.constraints)
    at_rest = ca.substitute(calm.acceleration, motion.v, ca.SX.zeros(motion.v.numel()))
    cost = parts.count(calm.acceleration) - parts.count(at_rest)
    if not ca.depends_on(calm.h, motion.v):
        return Need(what, False, "the coefficients of T do not depend on position", saving="dM/dt v - dT/dq")
    return Need(what, True, "M changes with position: centrifugal and Coriolis forces",
                cost=_share(parts.count(motion.acceleration), parts.count(motion.acceleration) - cost))


# -------------------------------------------------------------------- inertia


def _mass(parts: _Parts) -> Iterable[Need]:
    motion, names = parts.motion, [c.name for c in parts.kinematics.graph.coordinates]
    ways = ", ".join(f"{way} {count}" for way, count in motion.nodes.items())
    if len(names) <= _MOST_COUNTED:
        M = mass_matrix(motion)
        moving = [name for name, q in zip(names, ca.vertsplit(motion.q), strict=True) if ca.depends_on(M, q)]
        timed = ca.depends_on(M, motion.t)
        why = f"M depends on {_few(moving)}" if moving else "M depends on time" if timed else "M is constant"
        yield Need("refactorising M", bool(moving) or timed, why, saving="its factors are worked out once")
    yield Need("M as a matrix", motion.way in ("dense", "collected"), f"operations by each way: {ways}")
    floating = [(root.frame, parts.kinematics.graph.model.frames[root.frame].span)
                for root in parts.kinematics.graph.roots if not root.is_ground]
    yield _listed("floating coordinates", floating, "every body is joined to the ground", "", "three coordinates a body")


# -------------------------------------------------------------------- constraints


def _constraints(parts: _Parts) -> Iterable[Need]:
    held, rows = parts.motion.constrained, parts.constraints.rows
    spans = [(row.loop.around if row.loop else row.span.text, row.span) for row in rows]
    usual = held.regular if held and held.regular and held.regular.place.numel() else held
    nodes = count_nodes([usual.place, usual.steer], [parts.kinematics.algebra.state, parts.motion.t]) if usual else 0
    yield _listed("constraints", spans, "the graph is a tree", f"{len(rows)} rows", "multipliers in every evaluation")
    yield _listed("projection", spans[:1], "nothing can drift off", f"{nodes} operations a correction", "two corrections a step")
    yield _dependence(parts)
    asked = parts.scene.sizes["outputs_need_acceleration"]
    yield Need("multipliers as results", bool(held) and bool(asked), "outputs ask for them or for accelerations" if held and asked
               else "no output asks for them" if held else "there are none")
    absorbed = [(row.loop.around if row.loop else row.span.text, row.span) for row in parts.constraints.absorbed]
    dependent = [c.name for c in parts.kinematics.graph.dependent_coordinates]
    driven = [name for name in dependent if not parts.kinematics.dependents[name].terms]
    tied = [name for name in dependent if name not in driven]
    place = str(absorbed[0][1]) if absorbed else ""
    yield Need("linear loops", False, f"substituted: {_few(tied)}" if tied else "there are none", place if tied else "",
               saving=f"{len(tied)} coordinates and as many multipliers" if tied else "")
    yield Need("prescribed coordinates", False, f"given functions of time: {_few(driven)}" if driven else "there are none",
               place if driven else "", saving=f"{len(driven)} coordinates" if driven else "")
    repeated = [(row.loop.around if row.loop else row.span.text, row.span) for row in parts.constraints.repeated]
    yield _listed("repeated equations", [], f"left out: {_few([r[0] for r in repeated])}" if repeated else "none repeats another")


def _dependence(parts: _Parts) -> Need:
    """What only constraints that nearly repeat each other ask of the solution of the equations."""
    held, what = parts.motion.constrained, "dependent constraints"
    if held is None:
        return Need(what, False, "there are no constraints")
    if held.regular is None:
        return Need(what, True, "the mass matrix is singular or uneven: the equations are solved with a regularised matrix")
    whole, less = parts.count(parts.motion.acceleration), parts.count(held.regular.acceleration)
    return Need(what, False, "looked for in every evaluation: only near singular positions are the equations regularised",
                saving=f"{whole - less} of {whole} operations")


# -------------------------------------------------------------------- time


def _time(parts: _Parts) -> Iterable[Need]:
    motion, graph = parts.motion, parts.kinematics.graph
    supports = [(edge.child, edge.span) for edge in graph.edges if edge.moves_with_time]
    yield _listed("moving supports", supports, "no frame equation depends on time", "", "dr/dt of every frame, and their power")
    timed = ca.depends_on(motion.acceleration, motion.t)
    yield Need("explicit time", timed, "t stands in the equations" if timed else "t does not stand in the equations")
    modes = parts.kinematics.algebra.modes
    yield Need("time events", bool(modes), f"{len(modes)} switches at known times" if modes else "nothing switches",
               saving="restarts, and the search for switching times")
    yield _islands(parts)


def _islands(parts: _Parts) -> Need:
    count = len(find_islands(parts.motion))
    why = f"{count} groups of coordinates do not interact" if count > 1 else "all coordinates interact"
    return Need("islands", count > 1, why)


# -------------------------------------------------------------------- numerics


def _numerics(parts: _Parts) -> Iterable[Need]:
    motion = parts.motion
    slopes = ca.jacobian(motion.acceleration, ca.vertcat(motion.q, motion.v)) if parts.scene.n <= _MOST_COUNTED else None
    is_linear = slopes is not None and not ca.depends_on(slopes, ca.vertcat(motion.q, motion.v))
    yield Need("integrator", not is_linear, "the accelerations are linear in q and v" if is_linear else
               "the accelerations are not linear in q and v", saving="every step: the matrix exponential is exact")
    spectrum = find_spectrum(parts.kinematics, motion, parts.initial) if slopes is not None else None
    yield _stiffness(spectrum, parts.scene)


def _stiffness(spectrum: Spectrum | None, scene: Scene) -> Need:
    if spectrum is None:
        return Need("implicit steps", False, "not looked at before the run: the run time watches for stiffness")
    rates = f"at the start rates from {spectrum.slowest:.3g} to {spectrum.fastest:.3g} 1/s"
    if not spectrum.is_stiff(scene.stop - scene.start):
        return Need("implicit steps", False, rates, saving="Jacobians and their factorisation")
    return Need("implicit steps", True, f"{rates}, the fastest die away", cost="Jacobians and their factorisation")


# -------------------------------------------------------------------- what is reported


def _products(parts: _Parts) -> Iterable[Need]:
    scene, energies = parts.scene, parts.energies
    names = [column.name for column in scene.outputs]
    yield Need("outputs", bool(names), _few(names) if names else "none is asked for", cost="a call in each row, none in steps")
    flows = scene.sizes["n_power"] > 0
    yield Need("energy quadrature", flows, "power flows in or out" if flows else "T + V is constant",
               saving="two integrals in every step")
    spans = [(loop or span.text, span) for loop, span in
             zip(parts.initial.residual_loops, parts.initial.residual_spans, strict=True)]
    yield _listed("assembly", spans, "start values are given or zero", f"{len(spans)} equations", "Newton steps at the start")
    depends = energies.loads and any(ca.depends_on(ca.SX(ca.vertcat(*load.force)), parts.motion.u) for load in energies.loads)
    yield Need("inputs", bool(depends), "forces from outside" if depends else "nothing comes from outside")
    yield Need("compilation", True, f"{scene.notes['rhs_operations']} operations in the right-hand side; kept in the cache, "
               "parameters change without it")


# -------------------------------------------------------------------- words


def _few(names: list[str]) -> str:
    shown = list(dict.fromkeys(names))
    return ", ".join(shown[:_MOST_NAMES]) + (f" and {len(shown) - _MOST_NAMES} more" if len(shown) > _MOST_NAMES else "")


def _share(whole: int, without: int | None) -> str:
    return "" if without is None else f"{max(0, whole - without)} of {whole} operations"


def _listed(what: str, found: list[tuple[str, Span]], otherwise: str, cost: str = "", saved: str = "") -> Need:
    """A need for each of which there is a name and a place, or none at all."""
    if not found:
        return Need(what, False, otherwise, saving=saved)
    return Need(what, True, _few([name for name, _ in found]), str(found[0][1]), cost)
