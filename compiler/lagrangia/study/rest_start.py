"""A run that begins at rest: at the position of rest that is reached from the start values."""

from collections.abc import Mapping
from typing import Any, Protocol

from lagrangia.base.diagnostics import RunError, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.run.scene import Scene
from lagrangia.study.equilibria import Equilibria

STARTS = ("equilibrium", "steady")


class Resting(Protocol):
    """A model."""

    scene: Scene

    def equilibrium(self, *, parameters: Any, initial: Any, inputs: Any, time: float | None, starts: int | None) -> Equilibria:
        """Positions of rest."""


@dataclass(frozen=True)
class RestStart:
    """`values` of coordinates, rates and first-order states, by their names, and what is said of them."""

    values: Mapping[str, float]
    told: str


def start_at_rest(model: Resting, name: str, parameters: Any, guesses: Any, inputs: Any, time: float) -> RestStart:
    """Where nothing moves under the loads of that time, s: the position reached from the guesses. Raises LagError L0706, L0901,
    RunError where there is none."""
    if name not in STARTS:
        fail("L0706", f"a run cannot start from '{name}'", None, *filter(None, [suggest(name, STARTS)]))
    found = model.equilibrium(parameters=parameters, initial=guesses, inputs=inputs, time=time, starts=1)
    if not len(found) or not found.is_reached:
        raise RunError("no position of rest was found from the start values: it runs away, or forces stay unbalanced\n"
                       "try other values with --initial, or `lag equilibrium`, which looks from other places, too")
    scene, rest = model.scene, found[0]
    values = {c.name: rest.position[c.name] for c in scene.told_positions if c.name not in scene.signals}
    values |= {name: rest.position[name] for name in scene.signals.values() if name not in scene.inner}
    still = {rate.name: 0.0 for c, rate in zip(scene.coordinates, scene.rates, strict=True) if c.name not in scene.signals}
    shown = [f"{name} = {value:.6g}" for name, value in values.items()]
    more = f", ... ({len(shown)})" if len(shown) > 6 else ""
    return RestStart(values | still, f"starts at rest, {rest.stability}: {', '.join(shown[:6])}{more}")
