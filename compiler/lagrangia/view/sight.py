"""What pictures of a run ask of its model, and columns that need none: what a run itself carries."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from lagrangia.base.records import dataclass
from lagrangia.run.request import Request, Values
from lagrangia.run.scene import ENERGY_NAMES, Column, Scene

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Sight:
    """What pictures ask of a run's model: the elements of any quantity with their units, and small motion from a run's first row,
    quantities by name, (rows,) each."""

    columns_of: Callable[[str], tuple[Column, ...]]
    small_motion: "Callable[[np.ndarray, Sequence[str]], dict[str, np.ndarray]]"


@dataclass(frozen=True)
class Shown:
    """What pictures of a run ask for: its model, the values and the request it ran with, and what makes an animation of it."""

    model: Any
    values: Values
    request: Request
    animate: Callable[..., str]


def known_column(scene: Scene, name: str) -> Column | None:
    """Of the time, a coordinate, a rate, an output, or another name of one, or an energy; None of what needs the model."""
    columns = (Column("time", "s", "", ""), *scene.coordinates, *scene.rates, *scene.outputs)
    found = next((column for column in columns if column.name == name), None)
    if found is None and (slot := scene.slot(name)) is not None:
        return replace((*scene.coordinates, *scene.rates)[slot], name=name)
    return Column(name, "J", "", "") if found is None and name in ENERGY_NAMES else found
