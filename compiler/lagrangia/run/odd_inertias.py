"""Inertias that no rigid body has because of the parameters that a run is given: those that are declared so, the scene tells."""

import contextlib
from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from lagrangia.base.diagnostics import LagError
from lagrangia.base.inertias import told_beyond_others
from lagrangia.run.interpret import evaluate
from lagrangia.run.request import check_values
from lagrangia.run.scene import Scene


def odd_inertia_remarks(scene: Scene, parameters: Mapping[str, Any]) -> list[str]:
    """A warning for each, as `lag` prints them; none where values are ranges, or refused by the run itself."""
    inertias: list[tuple[str, int, list[int]]] = scene.notes["inertias"]
    found: list[str] = []
    if all(isinstance(value, Real) for value in parameters.values()):
        with contextlib.suppress(LagError):
            values = check_values(scene, parameters)
            (everything,) = evaluate(scene.tapes["parameters"], values.parameters, values.mask)
            for name, first, shape in inertias:
                own = np.array(everything[first : first + int(np.prod(shape))]).reshape(shape)
                if np.isfinite(own).all() and (told := told_beyond_others(name, own)):
                    found.append(f"warning[L0746]: {told}")
    return found
