"""Inertias that no rigid body has because of the parameters that runs are given: those that are declared so, the scene tells."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import LagError
from lagrangia.base.inertias import are_beyond_others, told_beyond_others
from lagrangia.run.interpret import evaluate, evaluate_each
from lagrangia.run.request import check_values
from lagrangia.run.scene import Scene

Set = tuple[Sequence[Any], Sequence[float]]  # what is given and which are, numbers or arrays (sets,)


def odd_inertia_remarks(scene: Scene, parameters: Mapping[str, Any]) -> list[str]:
    """A warning for each, as `lag` prints them; none where values are ranges, or refused by the run itself."""
    if all(isinstance(value, Real) for value in parameters.values()):
        with contextlib.suppress(LagError):
            values = check_values(scene, parameters)
            return told_odd_inertias(scene, evaluate(scene.tapes["parameters"], values.parameters, values.mask)[0])
    return []


def told_odd_inertias(scene: Scene, everything: Sequence[float]) -> list[str]:
    """The same of all parameters."""
    found = (told_beyond_others(name, own.reshape(shape)) for name, own, shape in _inertias(scene, everything))
    return [f"warning[L0746]: {told}" for told in found if told]


def odd_inertias_of_sets(scene: Scene, sets: Iterable[Set]) -> tuple[int, list[str]]:
    """In how many of many sets of parameters there are some, and the warnings of the first of these."""
    count, told = 0, list[str]()
    for given, mask in sets:
        everything = evaluate_each(scene.tapes["parameters"], given, mask)[0]
        is_odd: Any = False
        for _, own, shape in _inertias(scene, everything):
            moments: Any = own if shape == [3] else np.linalg.eigvalsh(own.reshape(*own.shape[:-1], 3, 3))
            is_odd = is_odd | are_beyond_others(moments)
        if not told and np.any(is_odd):
            first = int(np.argmax(is_odd))
            told = told_odd_inertias(scene, [float(np.ravel(x)[first if np.ndim(x) else 0]) for x in everything])
        count += int(np.sum(is_odd))
    return count, told


def _inertias(scene: Scene, everything: Sequence[Any]) -> Iterator[tuple[str, NDArray[np.float64], list[int]]]:
    """By name, those that were not declared so, of all parameters, numbers or arrays (...): (..., 3) or (..., 9), 0 where one is
    no number, and their shape, (3,) or (3, 3)."""
    for name, first, shape in scene.notes.get("inertias", ()):
        own = np.stack(np.broadcast_arrays(*everything[first : first + int(np.prod(shape))]), axis=-1)
        yield name, np.where(np.isfinite(own).all(-1, keepdims=True), own, 0.0), [*shape]
