"""The states of an FMU: where they begin, how large they are, and what FMI calls their starts."""

import math
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import LagError, RunError, RunWarning, fail
from lagrangia.run.request import Request
from lagrangia.run.scene import Column, Scene

if TYPE_CHECKING:
    import casadi as ca
    import numpy as np

    from lagrangia.fmu.exportable import Exportable
    from lagrangia.frames.kinematics import Kinematics

_ROUNDING = 1e-10  # of positions, as starts are found: what moves no further in the experiment stands still
_NOTHING = 1e-14  # what has stuck all the time is rounding
_SMALLEST_NOMINAL = 1e-3  # of the largest of its kind


def state_columns(scene: Scene) -> tuple[Column, ...]:
    """Names and units of positions, where an attitude is a quaternion, and of rates."""
    return (*scene.told_positions, *scene.rates)


def find_states(model: "Exportable", parameters: Mapping[str, float] | None) -> tuple[int, list[float], tuple[float, ...]]:
    """How many evaluations a run takes, where the states begin, and the size of each in the experiment, to a power of ten."""
    import numpy as np

    scene = model.scene
    columns = state_columns(scene)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RunWarning)  # its size is all that is asked for
            run = model.run(Request(parameters=parameters))
    except RunError as error:
        run = error.trajectory
    if run is None or not len(run.rows):
        _refuse_infinite(model)
        return 0, _unmoved(scene), (1.0,) * len(columns)
    states = _of_rows(scene, columns, run.rows)
    largest = np.abs(states).max(axis=0) if columns else np.zeros(0)
    largest[largest < _NOTHING] = 0.0
    own = {column.name: kind for column, kind in zip(scene.coordinates, scene.coordinate_kind, strict=False)}
    positions = [own.get(column.name, 0) for column in scene.told_positions]
    kinds = np.array([*positions, *(-1 - kind for kind in own.values())])
    for kind in set(positions):  # rates of what stands still are rounding
        reach, rates = max(largest[kinds == kind].max(), 0.0 if kind else 1.0), kinds == -1 - kind
        if largest[rates].max() * (scene.stop - scene.start) <= _ROUNDING * reach:
            largest[rates] = 0.0
    nominal = []
    for size, kind in zip(largest, kinds, strict=True):
        least = max(_SMALLEST_NOMINAL * largest[kinds == kind].max(), 0.0)
        nominal.append(1.0 if kind == 0 else _power_of_ten(max(size, least)))
    evaluations = run.statistics.rhs_evaluations if run.statistics is not None else 0
    return evaluations, states[0].tolist(), tuple(nominal)


def _of_rows(scene: Scene, columns: tuple[Column, ...], rows: "np.ndarray") -> "np.ndarray":
    places = {column.name: k for k, column in enumerate((*scene.coordinates, *scene.rates, *scene.outputs), 1)}
    return rows[:, [places[column.name] for column in columns]]


def _unmoved(scene: Scene) -> list[float]:
    """All 0, but for quaternions that turn nothing."""
    first = {f"{name}[1]" for name in scene.notes.get("attitudes", {})}
    return [float(column.name in first) for column in state_columns(scene)]


def _refuse_infinite(model: "Exportable") -> None:
    """What cannot start for a constant that is no number. Raises LagError L0605."""
    import casadi as ca

    from lagrangia.constraints.parameters import scalars

    kinematics = model.compilation.kinematics
    for variable in kinematics.graph.model.variables.values():
        if variable.binding is None:
            continue
        try:
            values = [ca.SX(x) for _, x in scalars(variable.name, kinematics.evaluator.value(variable.binding))]
        except (LagError, NotImplementedError):  # frames, texts
            continue
        if any(x.is_constant() and not math.isfinite(float(x)) for x in values):
            fail("L0605", f"'{variable.name}' is not finite: no FMU can start with it", variable.binding.span,
                 "numbers go to some 1.8e308")


def _power_of_ten(size: float) -> float:
    """The largest one below, 1 for 0. Angles have a natural size, 1."""
    return float(f"1e{math.floor(math.log10(size) + 1e-6)}") if size > 0 and math.isfinite(size) else 1.0


def state_kinds(model: "Exportable") -> list[str]:
    """FMI's `initial` of each state: exact numbers; calculated from parameters; approx where equations decide."""
    import casadi as ca

    scene, made = model.scene, model.compilation
    initial, p = made.initial, made.motion.p
    if scene.sizes["n_initial"]:
        return ["approx"] * len(state_columns(scene))
    positions = dict(zip((c.name for c in scene.coordinates), ca.vertsplit(initial.q[: scene.n]) if scene.n else [], strict=True))
    references = {f"{name}[{k}]": x for name, of in _references(made.kinematics).items() for k, x in enumerate(of, 1)}
    starts = [positions[c.name] if c.name in positions else references[c.name] for c in scene.told_positions]
    starts += ca.vertsplit(initial.v[: scene.n]) if scene.n else []
    return ["calculated" if p.numel() and ca.depends_on(ca.SX(start), p) else "exact" for start in starts]


def _references(kinematics: "Kinematics") -> "Mapping[str, list[ca.SX]]":
    """Of attitudes, where they begin: all four depend on what one does, since the quaternion is a whole."""
    import casadi as ca

    found: dict[str, list[ca.SX]] = {}
    for mode in kinematics.algebra.modes:
        if mode.of_attitude:
            found.setdefault(mode.of_attitude, []).append(mode.value)
    return {name: [ca.sum1(ca.vertcat(*parts))] * 4 for name, parts in found.items()}
