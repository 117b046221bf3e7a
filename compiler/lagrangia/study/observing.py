"""Any quantity of a scene, computed from the rows of a run."""

from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import fail
from lagrangia.run.request import Values
from lagrangia.run.scene import Scene
from lagrangia.view.rows import moments

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.compile.pipeline import Compilation


def observe(scene: Scene, compilation: "Compilation", parameters: "np.ndarray", values: Values, name: str,
            rows: "np.ndarray") -> "np.ndarray":
    """(rows,) of a number, (rows, elements) of a vector, in SI units. Raises LagError L0701, L0908."""
    import numpy as np

    from lagrangia.compile.functions import depends_on_forces, observer

    is_held = scene.sizes["switches_need_acceleration"]
    if is_held and depends_on_forces(compilation.kinematics, compilation.motion, name):
        fail("L0908", f"'{name}' depends on what friction and contacts hold: only the run knew", None,
             f"declare it as an output, or ask for it beforehand: lagrangia.Model(path, outputs=['{name}'])")
    labels, function = observer(compilation.kinematics, compilation.motion, compilation.constraints, (name,))
    found = np.array(function(*moments(scene, parameters, values, rows)))
    return found[0] if len(labels) == 1 else found.T
