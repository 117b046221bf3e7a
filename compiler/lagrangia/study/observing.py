"""Any quantity of a scene, computed from the rows of a run."""

from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import fail
from lagrangia.run.request import Values
from lagrangia.run.scene import Scene
from lagrangia.view.rows import moments

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.compile.pipeline import Compilation

_NEAR, _ROUNDINGS = 1e-9, 64  # of the way from one row to the next; of a time


def observe(scene: Scene, compilation: "Compilation", parameters: "np.ndarray", values: Values, name: str,
            rows: "np.ndarray", start: float) -> "np.ndarray":
    """(rows,) of a number, (rows, elements) of a vector, in SI units; `start` of the run, s. Raises LagError L0701, L0908."""
    import numpy as np

    from lagrangia.compile.functions import depends_on_forces, observer

    is_held = scene.sizes["switches_need_acceleration"]
    if is_held and depends_on_forces(compilation.kinematics, compilation.motion, name):
        fail("L0908", f"'{name}' depends on what friction and contacts hold: only the run knew", None,
             f"declare it as an output, or ask for it beforehand: lagrangia.Model(path, outputs=['{name}'])")
    labels, function = observer(compilation.kinematics, compilation.motion, compilation.constraints, (name,), has_sides=True)
    beside = rows.copy()
    beside[:, 0] = _sides(rows[:, 0], start)
    t_side, _, _, u_side, _ = moments(scene, parameters, values, beside)
    found = np.array(function(*moments(scene, parameters, values, rows), t_side, u_side))
    return found[0] if len(labels) == 1 else found.T


def _sides(t: "np.ndarray", start: float) -> "np.ndarray":
    """Times from which rows that may lie at events are seen, as the run sees them: its start from behind, others from before."""
    import numpy as np

    gaps = np.abs(np.diff(t, prepend=start))
    if t.size and t[0] == start:
        gaps[0] = -gaps[1] if t.size > 1 else -1.0
    least = _ROUNDINGS * np.finfo(float).eps * np.abs(t)
    return np.asarray(t - np.sign(gaps) * np.minimum(np.maximum(_NEAR * np.abs(gaps), least), np.abs(gaps) / 2))
