"""Positions of rest, as they are told."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any

from lagrangia.base.html_table import MOST_COLUMNS, headed, html_notes, html_table, missing, unrounded
from lagrangia.base.records import dataclass
from lagrangia.language.frame_attributes import REACTIONS, WRENCH_HEADINGS


@dataclass(frozen=True)
class Equilibrium:
    """`position`: all coordinates, those that constraints give too, m and rad. `stability` after the linearised motion:
    asymptotically stable, stable (it oscillates without damping), one-sided (what is near stays near, but what just touches lets
    nothing swing through), neutral (some motion costs nothing), unstable; fixed, where
    nothing can move; singular, where constraints are less independent than elsewhere and the linearised motion says nothing;
    unknown, where there is no linearised motion, as where motion moves no mass: `holding` says why.
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
        return self.stability in ("one-sided", "stable", "asymptotically stable", "fixed")


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

    def reactions_on(self, item: Equilibrium) -> dict[str, list[float]]:
        """The components by joints, with the port that the reaction acts on; 0 for what is rounding."""
        joints: dict[str, list[float]] = {}
        for name, value in self._rounded(item).items():
            if self._is_of_joint(name):
                path = name.rpartition(".")[0]
                joints.setdefault(f"{path}.{self.ports[path]}", []).append(value)
        return joints

    def forces_along(self, item: Equilibrium) -> dict[str, float]:
        """Those of single equations, as of a Motion along what it drives, by name; 0 for what is rounding."""
        return {name: value for name, value in self._rounded(item).items() if not self._is_of_joint(name)}

    def _is_of_joint(self, name: str) -> bool:
        path, _, what = name.rpartition(".")
        return path in self.ports and what.partition("[")[0] in REACTIONS

    def _rounded(self, item: Equilibrium) -> dict[str, float]:
        rounding = max(1e-12 * max(map(abs, item.reactions.values()), default=0.0), 10 * item.residual)
        return {name: 0.0 if abs(value) <= rounding else value for name, value in item.reactions.items()}

    def _repr_html_(self) -> str:
        """In a notebook: a row for each, and its reactions."""
        if not self.found:
            return html_notes([f"{self.name}: no equilibrium was found", *self.notes])
        names = [*self.found[0].position]
        shown = names[:MOST_COLUMNS]
        heads = ["", "stability", *(headed(name, self.units.get(name, "")) for name in shown), "V [J]"]
        rows = [(k, item.stability, *(unrounded(item.position[name]) for name in shown), unrounded(item.potential))
                for k, item in enumerate(self.found, 1)]
        parts = [html_table(heads, rows, f"{self.name}: {len(rows)} at rest, t = {self.time:g} s")]
        for k, item in enumerate(self.found, 1):
            if held := self.reactions_on(item):
                told = [(joint, *values) for joint, values in held.items()]
                parts.append(html_table(["", *WRENCH_HEADINGS[len(told[0]) - 1]], told, f"reactions of {k} on"))
            if along := self.forces_along(item):
                heads = [headed(name, self.units.get(name, "")) for name in along]
                parts.append(html_table(heads, [[*along.values()]], f"forces of {k}"))
        return "".join([*parts, html_notes([*missing(len(names), "coordinates"), *self.notes])])

    def __iter__(self) -> Iterator[Equilibrium]:
        return iter(self.found)
