"""Attitudes by three angles, for people: turn(a, S) as three turns about axes of coordinates that move along (L. Euler)."""

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from lagrangia.algebra.duals import Dual
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.frames.attitudes import Attitudes
from lagrangia.frames.evaluation import Value
from lagrangia.frames.spatial import NOWHERE, UNIT, Pose, attribute_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.tree import Ref

_LETTERS = ("phi", "theta", "psi")


@dataclass(frozen=True)
class Angles:
    """The names of three angles, and the axes, 0 to 2, that they are about."""

    names: tuple[str, ...]
    axes: tuple[int, ...]


def angles_of(attitudes: Iterable[str], sequence: str, taken: Collection[str]) -> dict[str, Angles]:
    """Of each attitude, by a sequence such as "zxz": tip.phi, tip.theta, tip.psi of tip.S, if no quantity is called so."""
    found, axes = {}, tuple("xyz".index(letter) for letter in sequence)
    for name in attitudes:
        owner = name.rpartition(".")[0]
        names = tuple(f"{owner}.{letter}" if owner else letter for letter in _LETTERS)
        found[name] = Angles(tuple(f"{name}.{letter}" for letter in _LETTERS) if set(names) & set(taken) else names, axes)
    return found


class ByAngles(Attitudes):
    """Of kinematics: turns by attitudes that are three angles, and their angular velocities."""

    angles: Mapping[str, Angles]
    evaluator: Any

    def attitude_of(self, step: Step) -> str | None:
        """The attitude that a turn is by, if it is one of angles."""
        amount = step.amount
        return amount.name if isinstance(amount, Ref) and amount.name in self.angles else super().attitude_of(step)

    def turned_by_angles(self, pose: Pose, attitude: str, is_inverse: bool, level: int) -> Pose:
        """The pose after a turn by an attitude."""
        found, algebra = self.angles[attitude], self.evaluator.algebras[level]
        turns = list(zip(found.names, found.axes, strict=True))
        for name, axis in reversed(turns) if is_inverse else turns:
            angle = self.coordinate(name, level)
            pose = pose.turned(-angle if is_inverse else angle, UNIT[axis], algebra)
        return pose

    def rates_of_angles(self, attitude: str, level: int) -> Value:
        """For der(S), which is all that can be asked of it. Raises LagError L0302 for the attitude itself."""
        if level == 0:
            return super().rates_of_attitude(attitude, 0)
        turned = self.turned_by_angles(Pose(NOWHERE, UNIT, NOWHERE, level), attitude, False, level)
        omega = attribute_of(turned, "omega")
        assert isinstance(omega, tuple)
        return tuple(Dual(0.0, x) for x in omega)

    def attitude_by_angles(self, name: str) -> Value:
        """Raises LagError L0901: no quaternion is written."""
        fail("L0901", "not supported yet: quaternions in equations by Euler's angles", self.graph.model.frames[name].span,
             "the elements of its matrix R are known there")
