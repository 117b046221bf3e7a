"""What this scene needs of all that a general simulation does, and what it does not, with the reason for each."""

from dataclasses import dataclass

import casadi as ca

from lagrangia.energies import Energies
from lagrangia.initial import InitialConditions
from lagrangia.kinematics import Kinematics
from lagrangia.motion import Motion, count_nodes


@dataclass(frozen=True)
class Need:
    what: str
    is_needed: bool
    why: str


def find_needs(kinematics: Kinematics, energies: Energies, motion: Motion, initial: InitialConditions) -> tuple[Need, ...]:
    """The table of needs, read off the equations."""
    graph, modes = kinematics.graph, kinematics.algebra.modes
    is_timed, has_rates = ca.depends_on(motion.acceleration, motion.t), ca.depends_on(motion.h, motion.v)
    moving_supports = [edge for edge in graph.edges if edge.moves_with_time]
    floating = [root.frame for root in graph.roots if not root.is_ground]
    at_rest = ca.substitute(motion.h, motion.v, ca.SX.zeros(motion.v.numel()))
    coriolis = count_nodes([motion.h], [motion.v]) > 0 and not energies.dissipation and has_rates
    ways = ", ".join(f"{way} {count}" for way, count in motion.nodes.items())
    return (
        _listed("dissipation", [t.component for t in energies.dissipation], "no component states one"),
        _listed("sources", [w.statement.component for w in energies.loads], "no force or torque is applied"),
        _listed("moving supports", [str(e.span) for e in moving_supports], "no frame equation depends on time"),
        Need("explicit time", is_timed, "t stands in the equations" if is_timed else "t does not stand in the equations"),
        Need("velocity terms", has_rates,
             "gyroscopic or centrifugal" if coriolis else "dampers" if has_rates else "h does not depend on v"),
        Need("solving for M", motion.way == "dense", f"{motion.way}: {motion.nodes[motion.way]} operations; {ways}"),
        Need("time events", bool(modes), f"{len(modes)} switches at known times" if modes else "nothing switches"),
        Need("energy quadrature", not (motion.dissipated_power.is_zero() and motion.source_power.is_zero()),
             "power flows in or out" if energies.dissipation or energies.loads or moving_supports else "T + V is constant"),
        _listed("assembly", [str(s) for s in initial.residual_spans], "start values are given or zero"),
        _listed("floating coordinates", floating, "every body is joined to the ground"),
        Need("static forces", not at_rest.is_zero(), "h at rest is not zero" if not at_rest.is_zero() else "no force at rest"),
    )


def _listed(what: str, names: list[str], otherwise: str) -> Need:
    """A need for each of which there is a name, or none at all."""
    shown = list(dict.fromkeys(names))
    more = f" and {len(shown) - 4} more" if len(shown) > 4 else ""
    return Need(what, bool(shown), ", ".join(shown[:4]) + more if shown else otherwise)
