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
    """The scene of what files have, and what makes rows of it of rows: without what is hidden."""
    hidden = scene.hidden
    if not hidden:
        return scene, lambda values: values
    whole = columns(scene)
    width, places = len(whole) + ENERGIES, [k for k, column in enumerate(whole) if column.name not in hidden]
    places += range(len(whole), width)
    coordinates, rates = (tuple(c for c in of if c.name not in hidden) for of in (scene.coordinates, scene.rates))
    told = replace(scene, coordinates=coordinates, rates=rates)
    return told, lambda values: [values[k + place] for k in range(0, len(values), width) for place in places]


def moments(scene: Scene, parameters: "np.ndarray", values: Values, rows: "np.ndarray") -> "tuple[np.ndarray, ...]":
    """t, q, v and u, (., T) each, and p, (n_p, 1), of rows of results; behind u what is held between instants."""
    import numpy as np

    n = scene.n
    t, q, v = rows[:, :1].T, rows[:, 1 : 1 + n].T, rows[:, 1 + n : 1 + 2 * n].T
    u = InputTable(scene, values, float(t[0, 0]) if t.size else scene.start).at(t[0])
    attitudes = scene.notes.get("attitudes", {})
    if kept := [*(f"{name}[{k}]" for name in attitudes for k in range(1, 5)), *scene.notes.get("held", ())]:
        outputs = {column.name: 1 + 2 * n + k for k, column in enumerate(scene.outputs)}
        u = np.vstack([u, rows[:, [outputs[name] for name in kept]].T])
    if attitudes:  # against themselves they are not turned
        q = q.copy()
        q[[k for k, c in enumerate(scene.coordinates) if c.name in scene.turned]] = 0
    return t, q, v, u, parameters.reshape(-1, 1)


def collect(scene: Scene, portions: Iterable[Sequence[float]]) -> "np.ndarray":
    """All rows as one array of shape (rows, width)."""
    import numpy as np

    width = len(columns(scene)) + ENERGIES
    parts = [np.asarray(portion, dtype=np.float64).reshape(-1, width) for portion in portions]
    return np.concatenate(parts) if parts else np.empty((0, width))
