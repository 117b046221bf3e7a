"""Positions of rest, as they are told."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any

from lagrangia.base.records import dataclass


@dataclass(frozen=True)
class Equilibrium:
    """`position`: all coordinates, those that constraints give too, m and rad. `stability` after the linearised motion:
    asymptotically stable, stable (it oscillates without damping), neutral (some motion costs nothing), unstable; fixed, where
    nothing can move; singular, where constraints are less independent than elsewhere and the linearised motion says nothing.
    Where ways of moving meet it is that of the least stable one."""

    position: Mapping[str, float]
    potential: float
    stability: str
    growth: float  # the largest real part of an eigenvalue, 1/s
    eigenvalues: tuple[complex, ...]
    n_neutral: int
    reactions: Mapping[str, float]
    residual: float  # the largest force left, N or N.m
    ways: tuple[str, ...] = ()  # of moving, by the coordinates that move, where several meet; the eigenvalues are of all of them
    contacts: Mapping[str, float] = field(default_factory=dict)  # that are closed, and the forces with which they push
    friction: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # that holds: how much, of how much it can
    holding: tuple[str, ...] = ()  # both in words

    @property
    def is_stable(self) -> bool:
        """Whether motion from nearby stays nearby, for all that the linearised motion can tell."""
        return self.stability in ("stable", "asymptotically stable", "fixed")


@dataclass(frozen=True)
class Equilibria(Sequence[Equilibrium]):
    """The first one is what is reached from the start, where anything is; the others by potential energy."""

    name: str
    time: float
    found: tuple[Equilibrium, ...]
    is_reached: bool  # whether the first was found from the start itself
    units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    ports: Mapping[str, str] = field(default_factory=dict)  # of joints and ties, the port that the reaction acts on

    def __getitem__(self, k: Any) -> Any:
        return self.found[k]

    def __len__(self) -> int:
        return len(self.found)

    def _repr_html_(self) -> str:
        """In a notebook: a table of them, and their reactions."""
        from lagrangia.study.notebook import equilibria_html

        return equilibria_html(self)

    def __iter__(self) -> Iterator[Equilibrium]:
        return iter(self.found)
