"""Attitudes where things rest or move a little: small turns about the turned axes, beside references in numbers.

A position q has s of each attitude (runtime/state/attitudes.c) against its reference; where s is 0 small turns dtheta are ds, and
rates are angular velocities w with ds/dt = N(s) w. About a state that turns with w it is dtheta/dt = dw - w x dtheta.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.attitude_values import quaternion_product
from lagrangia.base.records import dataclass
from lagrangia.dynamics.turned_positions import crossing, pacing
from lagrangia.run.scene import Scene

Vector = NDArray[np.float64]
_ROUNDING = 1e-12  # of a part of a unit quaternion
_NOT_TURNED = np.array([1.0, 0.0, 0.0, 0.0])


def product(a: Sequence[float] | Vector, b: Sequence[float] | Vector) -> Vector:
    """Of two quaternions, (4,)."""
    return np.array(quaternion_product(a, b))


def present(reference: Vector, s: Vector) -> Vector:
    """The unit quaternion (4,) of s against a reference."""
    square = float(s @ s) / 16
    return product(reference, [(1 - square) / (1 + square), *(s / (2 * (1 + square)))])


def between(reference: Vector, quaternion: Vector) -> Vector:
    """s of the turn from one unit quaternion to another, the shorter way."""
    real, *turn = product([reference[0], *(-reference[1:])], quaternion)
    return np.asarray(np.array(turn) * (4 if real >= 0 else -4) / (1 + abs(real)))


def unpacing(s: Vector) -> Vector:
    """N(s)^-1, (3, 3)."""
    return np.asarray(pacing(s).T / (1 + s @ s / 16) ** 2)


@dataclass(frozen=True)
class Turned:
    """The attitudes of a scene: `names`, and the place of the first of the three coordinates of each."""

    names: tuple[str, ...]
    firsts: tuple[int, ...]
    n: int

    @cached_property
    def places(self) -> list[list[int]]:
        """Of the coordinates of each."""
        return [[*range(first, first + 3)] for first in self.firsts]

    @cached_property
    def all(self) -> list[int]:
        """Of all of them."""
        return [k for places in self.places for k in places]

    def declared(self, modes: Vector, firsts: Sequence[int]) -> Vector:
        """References, (attitudes, 4), of the modes just after the start; `firsts`: where those of each begin."""
        found = np.array([modes[k : k + 4] for k in firsts]).reshape(-1, 4)
        lengths = np.linalg.norm(found, axis=1) * np.where(found[:, 0] < 0, -1.0, 1.0)
        return np.asarray(found / lengths[:, None])

    def from_no_turn(self, q: Vector, references: Vector) -> Vector:
        """Start values (n,) of attitudes that count from no turn, against references."""
        found = q.copy()
        for places, reference in zip(self.places, references, strict=True):
            if not np.isnan(q[places]).any():
                found[places] = between(reference, present(_NOT_TURNED, q[places]))
        return found

    def centred(self, q: Vector, references: Vector) -> tuple[Vector, Vector]:
        """The same position with references at which nothing is turned."""
        moved = [present(reference, q[places]) for places, reference in zip(self.places, references, strict=True)]
        found = q.copy()
        found[self.all] = 0.0
        return found, np.array(moved).reshape(-1, 4)

    def told(self, q: Vector, references: Vector) -> dict[str, float]:
        """Quaternions by their names, the first part that is not 0 positive."""
        found: dict[str, float] = {}
        for name, quaternion in zip(self.names, self.centred(q, references)[1], strict=True):
            side = np.sign(quaternion[np.flatnonzero(np.abs(quaternion) > _ROUNDING)[0]])
            found |= {f"{name}[{k}]": float(side * x) if abs(x) > _ROUNDING else 0.0 for k, x in enumerate(quaternion, 1)}
        return found

    def read(self, point: Mapping[str, float]) -> Vector:
        """References of told quaternions."""
        return np.array([[point[f"{name}[{k}]"] for k in range(1, 5)] for name in self.names]).reshape(-1, 4)

    def advanced(self, q: Vector, v: Vector, moment: float) -> Vector:
        """The position after so many seconds at these rates, from one where nothing is turned."""
        found = q + moment * v
        for places in self.places:
            speed = float(np.linalg.norm(v[places]))
            angle = np.remainder(speed * moment + np.pi, 2 * np.pi) - np.pi
            found[places] = 4 * np.tan(angle / 4) * v[places] / speed if speed else 0.0
        return found

    def dragging(self, v: Vector) -> Vector:
        """(n, n): what d(small turns)/dt has of small turns themselves."""
        found = np.zeros((self.n, self.n))
        for places in self.places:
            found[np.ix_(places, places)] = -crossing(v[places])
        return found

    def by_positions(self, rows: Vector, q: Vector) -> Vector:
        """Derivatives by rates, (., n), as those by rates of positions."""
        found = rows.copy()
        for places in self.places:
            found[:, places] = rows[:, places] @ unpacing(q[places])
        return found


def turned_of(scene: Scene) -> Turned:
    """Of a scene."""
    names = [c.name for c in scene.coordinates]
    return Turned(tuple(scene.attitudes), tuple(names.index(parts[0]) for parts in scene.attitudes.values()), scene.n)
