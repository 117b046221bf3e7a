"""Rows of results: what their columns are, and the moments that they are of."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from lagrangia.run.input_pieces import InputTable
from lagrangia.run.request import Values
from lagrangia.run.scene import ENERGY_NAMES, Column, Scene

if TYPE_CHECKING:
    import numpy as np

ENERGIES = len(ENERGY_NAMES)


def columns(scene: Scene) -> tuple[Column, ...]:
    """Names and units of the first columns of a row; five energies follow them."""
    return (Column("time", "s", "", ""), *scene.coordinates, *scene.rates, *scene.outputs)


def shown(scene: Scene) -> tuple[Scene, Callable[[Sequence[float]], Sequence[float]]]:
    """The scene of what files have, and what makes rows of it of rows: of first-order states without the coordinates whose rates
    they are, on which nothing depends."""
    if not scene.signals:
        return scene, lambda values: values
    hidden = {*scene.signals, *(f"der({name})" for name in scene.signals)}
    whole = columns(scene)
    width, places = len(whole) + ENERGIES, [k for k, column in enumerate(whole) if column.name not in hidden]
    places += range(len(whole), width)
    told = replace(scene, coordinates=scene.moving, rates=tuple(c for c in scene.rates if c.name not in hidden))
    return told, lambda values: [values[k + place] for k in range(0, len(values), width) for place in places]


def moments(scene: Scene, parameters: "np.ndarray", values: Values, rows: "np.ndarray") -> "tuple[np.ndarray, ...]":
    """t, q, v and u, (., T) each, and p, (n_p, 1), of rows of results; behind u what is held between instants."""
    import numpy as np

    n = scene.n
    t, q, v = rows[:, :1].T, rows[:, 1 : 1 + n].T, rows[:, 1 + n : 1 + 2 * n].T
    u = InputTable(scene, values, float(t[0, 0]) if t.size else scene.start).at(t[0])
    if held := scene.notes.get("held"):
        places = [1 + 2 * n + [column.name for column in scene.outputs].index(name) for name in held]
        u = np.vstack([u, rows[:, places].T])
    return t, q, v, u, parameters.reshape(-1, 1)


def collect(scene: Scene, portions: Iterable[Sequence[float]]) -> "np.ndarray":
    """All rows as one array of shape (rows, width)."""
    import numpy as np

    width = len(columns(scene)) + ENERGIES
    parts = [np.asarray(portion, dtype=np.float64).reshape(-1, width) for portion in portions]
    return np.concatenate(parts) if parts else np.empty((0, width))
