"""Inertias that no rigid body has because of the parameters that runs are given: those that are declared so, the scene tells."""

import contextlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import prod
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import LagError
from lagrangia.base.inertias import are_beyond_others, are_of_a_body, told_beyond_others
from lagrangia.run.interpret import evaluate, evaluate_each
from lagrangia.run.request import check_values
from lagrangia.run.scene import Scene

Set = tuple[Sequence[Any], Sequence[float]]  # what is given and which are, numbers or arrays (sets,)
Inertia = tuple[str, int, Sequence[int]]  # its name, its first element's place among all parameters, (3,) or (3, 3)


def odd_inertia_remarks(scene: Scene, parameters: Mapping[str, Any]) -> list[str]:
    """A warning for each, as `lag` prints them; none where values are ranges, or refused by the run itself."""
    if all(isinstance(value, Real) for value in parameters.values()):
        with contextlib.suppress(LagError):
            values = check_values(scene, parameters)
            return told_odd_inertias(_undeclared(scene), evaluate(scene.tapes["parameters"], values.parameters, values.mask)[0])
    return []


def reached_inertias(scene: Scene, places: Collection[int]) -> list[Inertia]:
    """Those that values of the parameters at these places enter, but those that were declared so."""
    if not (inertias := _undeclared(scene)):
        return []
    reached = {k for _, k in scene.tapes["parameters"].reached({(0, k) for k in places})}
    return [one for one in inertias if not reached.isdisjoint(range(one[1], one[1] + prod(one[2])))]


def told_odd_inertias(inertias: Iterable[Inertia], everything: Sequence[float]) -> list[str]:
    """The warnings of these, of all parameters."""
    found = (told_beyond_others(name, own.reshape(shape)) for name, own, shape in _values(inertias, everything))
    return [f"warning[L0746]: {told}" for told in found if told]


def odd_inertias_of_sets(scene: Scene, sets: Iterable[Set]) -> tuple[int, list[str]]:
    """In how many of many sets of parameters there are some, and the warnings of the first of these."""
    count, told = 0, list[str]()
    for given, mask in sets:
        everything = evaluate_each(scene.tapes["parameters"], given, mask)[0]
        is_odd: Any = False
        for _, own, shape in _values(_undeclared(scene), everything):
            moments: Any = own if len(shape) == 1 else np.linalg.eigvalsh(own.reshape(*own.shape[:-1], 3, 3))
            is_odd = is_odd | are_beyond_others(moments)
        if not told and np.any(is_odd):
            first = int(np.argmax(is_odd))
            told = told_odd_inertias(_undeclared(scene), [float(np.ravel(x)[first if np.ndim(x) else 0]) for x in everything])
        count += int(np.sum(is_odd))
    return count, told


def _undeclared(scene: Scene) -> Sequence[Inertia]:
    """All but those that were declared so."""
    inertias: Sequence[Inertia] = scene.notes.get("inertias", ())
    return inertias


def _values(inertias: Iterable[Inertia], everything: Sequence[Any]) -> Iterator[tuple[str, NDArray[np.float64], Sequence[int]]]:
    """By name, but those that surely are of a body, of all parameters, numbers or arrays (...): (..., 3) or (..., 9), 0 where one
    is no number, and their shape."""
    for name, first, shape in inertias:
        parts = everything[first : first + prod(shape)]
        if any(map(np.ndim, parts)) or not are_of_a_body(parts):
            own = np.stack(np.broadcast_arrays(*parts), axis=-1)
            yield name, np.where(np.isfinite(own).all(-1, keepdims=True), own, 0.0), shape
