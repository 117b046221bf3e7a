"""First-order states where things rest: each is the rate of a coordinate on which nothing depends, and stands in its place.

Discrete variables are as they were at the start: no event comes while all rests.
"""

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class SignalStates:
    """`coordinates` are all of the scene; `states` by those whose rates they are; of which `kept` are discrete variables."""

    coordinates: tuple[str, ...]
    states: Mapping[str, str]
    kept: Collection[str] = ()

    @cached_property
    def places(self) -> list[int]:
        """Of them among the coordinates."""
        return [k for k, name in enumerate(self.coordinates) if name in self.states]

    @cached_property
    def kept_places(self) -> list[int]:
        """Of discrete variables among the coordinates."""
        return [k for k, name in enumerate(self.coordinates) if name in self.kept]

    def spread(self, q: Vector) -> Vector:
        """All coordinates, of those that are no discrete variables; 0 in the places of these."""
        found = np.zeros(len(self.coordinates))
        found[[k for k in range(found.size) if k not in self.kept_places]] = q
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """Of the coordinates, and of the states that stand in their places."""
        return tuple(self.states.get(name, name) for name in self.coordinates)

    def steady(self, q: Vector) -> Vector:
        """The rates where all but the states rest."""
        v = np.zeros(len(self.coordinates))
        v[self.places] = q[self.places]
        return v

    def in_places(self, q: Vector, v: Vector) -> Vector:
        """Positions, with the states in their places."""
        return np.where(np.isin(np.arange(len(self.coordinates)), self.places), v, q)

    def asked(self, names: Sequence[str]) -> Sequence[str]:
        """What `by_states` needs besides these derivatives."""
        return names if not self.places or "v" in names else (*names, "v")

    def by_states(self, found: dict[str, list[Vector]]) -> dict[str, list[Vector]]:
        """Derivatives by q and v with those by the states in their places."""
        for by_q, by_v in zip(found["q"], found["v"], strict=True) if self.places and "q" in found else ():
            by_q[:, self.places], by_v[:, self.places] = by_v[:, self.places], 0.0
        if "q" in found:
            found["q"][0][self.kept_places, self.kept_places] = 1.0
        return found

    def held(self, R: Vector, q: Vector, start: Vector) -> Vector:
        """What is to vanish at rest (n, 1), with discrete variables against what they are at the start (n,)."""
        R[self.kept_places, 0] = (q - start)[self.kept_places]
        return R
