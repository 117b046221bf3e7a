"""The tree of rigid bodies that a scene is, in the plane (elimination.py) or in space (spatial_tree.py), whose modules are loaded
for scenes in space alone.
"""

from collections.abc import Sequence
from typing import Protocol

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.dynamics import elimination
from lagrangia.dynamics.bodies import Bodies
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.forces import Forces
from lagrangia.dynamics.loops_in_tree import Carrier, Granted, Wrenches
from lagrangia.frames.kinematics import Kinematics


class Tree(Protocol):
    """M, factored along the tree of bodies."""

    kinematics: Kinematics

    @property
    def size(self) -> int:
        """How many coordinates there are."""
    @property
    def masses(self) -> Sequence[Scalar]:
        """Of the bodies, kg."""
    @property
    def pivots(self) -> ca.SX:
        """D of each coordinate, (n,)."""
    @property
    def diagonal(self) -> ca.SX:
        """Of M, (n,)."""
    def solve(self, r: ca.SX) -> ca.SX:
        """The solution a (n,) of M a = r."""
    def yield_to(self, forces: Forces) -> ca.SX:
        """The solution a (n,) of M a = -h, where h is what the forces take from the motion."""
    def carriers(self) -> Sequence[Carrier]:
        """The bodies."""
    def on_carriers(self, forces: Forces) -> tuple[Wrenches, bool]:
        """Wrenches by carriers, and whether the world is held, too."""
    def granted(self, energies: Energies) -> Granted | None:
        """What acts where bodies are accelerated as the rates alone do; None where that is not known."""
    def accelerate(self, energies: Energies) -> ca.SX | None:
        """The accelerations, with every force on the body it acts on. None where that is not known."""


def articulate(kinematics: Kinematics, bodies: Bodies) -> Tree | None:
    """None when the scene is no tree of rigid bodies: a coordinate that moves several joints, none, or no mass of its own, or a
    kinetic term that couples several bodies or is no body's."""
    if not kinematics.geometry.by_rates:
        return elimination.articulate(kinematics, bodies)
    from lagrangia.dynamics.spatial_tree import articulate_in_space

    return articulate_in_space(kinematics, bodies)
