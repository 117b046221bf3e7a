"""What is asked of a scene about which small motion is told while it moves, and what is found there."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.study.linearization import Linearization, TangentParts
from lagrangia.study.small_motion import SmallMotion

Matrix = NDArray[np.float64]
State = tuple[Matrix, Matrix, Matrix]  # positions, rates, multipliers


class Study(Protocol):
    """What is asked of analysis.py."""

    c: Any
    scene: Any
    names: tuple[str, ...]
    turned: Any

    def advanced(self, q: Matrix, v: Matrix, moment: float) -> "tuple[Study, Matrix]":
        """The same after so many seconds at these rates, where attitudes are told against those there, and the position."""

    def centred(self, q: Matrix) -> "tuple[Study, Matrix]":
        """The same where attitudes are told against those of a position, and the position."""

    def resting(self, e: SmallMotion, pace: float) -> Any:
        """The equations at rest in numbers."""

    def point(self, q: Matrix, v: Matrix) -> dict[str, float]:
        """Positions by their names."""

    @property
    def signals(self) -> Any:
        """The first-order states."""

    @property
    def reach(self) -> Matrix:
        """Natural sizes of the coordinates."""

    @property
    def is_preferred(self) -> Sequence[bool]:
        """Which coordinates the model starts itself."""

    @property
    def is_angle(self) -> NDArray[np.bool_]:
        """Which coordinates are angles."""

    def call(self, function: Any, q: Matrix, lam: Matrix, pace: float, v: Matrix | None = None, a: Matrix | None = None
             ) -> list[Matrix]:
        """Values of a function of the state."""

    def slopes(self, e: SmallMotion, function: Any, names: Sequence[str], q: Matrix, lam: Matrix, pace: float,
               v: Matrix | None = None, a: Matrix | None = None) -> Mapping[str, list[Matrix]]:
        """Derivatives of a function's values."""

    def tangent(self, e: SmallMotion, q: Matrix, lam: Matrix, pace: float, v: Matrix | None = None, a: Matrix | None = None
                ) -> tuple[TangentParts, list[int]]:
        """What holds at a state."""

    def observed(self, e: SmallMotion, q: Matrix, lam: Matrix, pace: float, v: Matrix | None = None, a: Matrix | None = None
                 ) -> list[Matrix]:
        """Outputs and their derivatives."""


@dataclass(frozen=True)
class Held:
    """What rows let small changes be: `coordinates` and `rates` are the places of x and z."""

    coordinates: tuple[int, ...]
    rates: tuple[int, ...]
    N: Matrix  # (n, f)
    P: Matrix  # (n, w)
    S: Matrix  # (n, f)
    Tz: Matrix  # (n, w)
    Tx: Matrix  # (n, f)


@dataclass(frozen=True)
class Moment:
    """At a state: the matrices, what small changes may be, and accelerations (n,)."""

    linear: Linearization
    held: Held
    a: Matrix

    @property
    def E(self) -> Matrix:
        """(2 n, f + w): (dq, dv) of what is free."""
        h = self.held
        return np.block([[h.N, np.zeros((h.N.shape[0], h.P.shape[1]))], [h.S, h.P]])

    @property
    def places(self) -> list[int]:
        """Of what is free in (dq, dv)."""
        return [*self.held.coordinates, *(self.held.N.shape[0] + k for k in self.held.rates)]
