"""Kinetic energies that users write: accelerations have no value where they are negative for some motion.

The components of the library have masses that cannot be negative. What else is called kinetic may be anything: where M is not
positive definite, energy is lost in one motion without end to another, and where it becomes so, a step may pass the place. So the
pivots of M = L D L^T stand in the accelerations, as what adds nothing as long as they are positive.
"""

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics.energies import evaluate_energies
from lagrangia.dynamics.motion import Motion, mass_matrix
from lagrangia.frames.kinematics import Kinematics

_MOST_COORDINATES = 60  # of scenes whose M is looked at as a whole
_ROUNDING = 1e-12  # of the diagonal of M: pivots
_NOTHING = 1e-300  # times a square root: next to no acceleration


def written_inertias(kinematics: Kinematics) -> tuple[Span, ...]:
    """Where kinetic energies are stated that are not of the library."""
    return tuple(e.span for e in kinematics.graph.model.energies if e.kind == "kinetic" and not e.is_of_library)


def tell_unlooked(kinematics: Kinematics) -> Report:
    """L0745 where a scene is too large for its M to be looked at as a whole."""
    report, places, n = Report(), written_inertias(kinematics), len(kinematics.symbols.positions)
    if places and n > _MOST_COORDINATES:
        report.warning("L0745", "whether this kinetic energy is negative for some motion is not looked at, as it is in scenes of "
                       f"up to {_MOST_COORDINATES} coordinates: this one has {n}", places[0], "try it in a smaller scene")
    return report


def without_negative_inertia(kinematics: Kinematics, motion: Motion) -> Motion:
    """The motion, with accelerations that are no numbers where M is not positive definite.

    Raises LagError L0506 where it is so whatever the motion and the parameters.
    """
    places, held = written_inertias(kinematics), motion.constrained
    if not places or not 0 < motion.v.numel() <= _MOST_COORDINATES or (
            held is not None and held.regular is None and motion.unsolved is None):
        return motion
    margins = _margins(mass_matrix(motion))
    _refuse_negative(margins, places[0])
    nothing = nothing_unless([x for x in margins if not x.is_constant()], ca.vertcat(motion.t, motion.q, motion.v, motion.u))
    if held is not None and held.regular is not None:
        regular = replace(held.regular, acceleration=held.regular.acceleration + nothing)
        motion = replace(motion, constrained=replace(held, regular=regular))
    unsolved = motion.unsolved and replace(motion.unsolved, acceleration=motion.unsolved.acceleration + nothing)
    return replace(motion, acceleration=motion.acceleration + nothing, unsolved=unsolved)


def refuse_negative_inertia(kinematics: Kinematics, parameters: Sequence[float] | None = None) -> None:
    """Raises LagError L0506 where M is not positive definite whatever the motion, with these values of all parameters, or those
    that are declared: of what no run is made of, which tells it."""
    places, rates = written_inertias(kinematics), ca.vertcat(*kinematics.symbols.rates.values())
    if places and 0 < rates.numel() <= _MOST_COORDINATES:
        energies, (p, declared) = evaluate_energies(kinematics), default_parameters(kinematics)
        M = ca.hessian(energies.total(energies.kinetic), rates)[0]
        known = ca.substitute(ca.vertcat(*_margins(M)), p, declared if parameters is None else ca.DM([*parameters]))
        _refuse_negative([known[k] for k in range(known.numel())], places[0])


def _refuse_negative(margins: list[ca.SX], place: Span) -> None:
    if any(x.is_constant() and not float(x) >= 0 for x in margins):
        fail("L0506", "the kinetic energy is negative for some motion: the mass matrix is not positive definite", place,
             "make every mass positive, and what couples two rates smaller")


def nothing_unless(margins: list[ca.SX], state: ca.SX) -> ca.SX:
    """0, or no number where one of these is negative. A root is what has Taylor series."""
    total = ca.SX(0)
    for x in margins:
        total += _NOTHING * ca.sqrt(x) if ca.depends_on(x, state) else ca.if_else(x >= 0, 0, ca.SX.nan())
    return total


def _margins(M: ca.SX) -> list[ca.SX]:
    """The pivots of M, by minimum degree, and what rounding may take of each; without those of what moves no mass."""
    diagonal, _, order = ca.ldl(M, True)
    found = [(diagonal[place], M[int(k), int(k)]) for place, k in enumerate(order)]
    return [pivot + _ROUNDING * ca.fabs(own) for pivot, own in found if not pivot.is_zero()]
