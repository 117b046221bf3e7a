"""`lag play`: a model -> one HTML file that computes its motion: run time, scene, drawing and controls."""

import base64
import gzip
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from lagrangia.base.attitude_values import quaternion_of
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.result_files import write_text
from lagrangia.draw.animation import speed_of, written
from lagrangia.draw.drawing import Drawable, figures_of, states_of
from lagrangia.draw.film import MOST_CURVES, require_traces, thinned
from lagrangia.fmu.exportable import Exportable
from lagrangia.fmu.stored import write_played
from lagrangia.fmu.tables import sizes_of
from lagrangia.fmu.variable import Variable
from lagrangia.fmu.variables import FmuModel, build_fmu_model
from lagrangia.language.flat import Figure
from lagrangia.play.space_stage import build_space_stage
from lagrangia.play.stage import build_stage
from lagrangia.play.wasm import build_wasm
from lagrangia.run.request import Request, Values, check_values, plan
from lagrangia.run.runtime import Solver
from lagrangia.run.scene import Scene
from lagrangia.solids.orbit import SEEN_BY_HAND, VECTORS
from lagrangia.solids.showing import is_in_space
from lagrangia.view.trajectory import Trajectory

_LOOKS = 60  # moments of the motion from which the picture's sizes are taken
_MOST_SHOWN = 40  # quantities whose values are listed
_DEGREE = 180.0 / math.pi
_TURN, _RATE = math.pi, 10.0  # sliders of angles, and of rates of what is at rest, go so far
_FIXED = 1  # LAG_START_FIXED of model.h
_OWN = [Path(__file__).with_name(name) for name in ("player.css", "player.html", "machine.js")]
_FLAT, _SPATIAL, _PLAYER, _DRAG, _PLANE, _SPACE = (Path(__file__).with_name(f"{name}.js")
                                                   for name in ("figures", "solids", "player", "drag", "plane", "space"))


class Playable(Drawable, Exportable, Protocol):
    """What a page needs of a Model."""

    def opened(self, parameters: Mapping[str, float] | None, where: str) -> "Playable":
        """In formulas that hold whatever is set."""


def play_scene(model: Playable, path: str | os.PathLike[str], request: Request, names: Mapping[str, str],
               traces: Sequence[str] = ()) -> RunError | None:
    """Writes the page; returns what stops the scene's run, which the page shows, too. Raises LagError (L0706 without zig), or
    RunError for what cannot start."""
    model = model.opened(request.parameters, "a page")
    figures = figures_of(model)
    program = build_wasm()
    values = check_values(model.scene, request.parameters, request.initial, request.inputs)
    if any(not math.isnan(x) for x in values.lost):
        fail("L0918", "not supported yet: start values of what follows from other coordinates, in a page", None,
             "give those of the others")
    require_traces(model, traces)
    failure: RunError | None = None
    try:
        run = model.run(request)
    except RunError as error:
        if error.trajectory is None or not len(error.trajectory.rows):
            raise
        run, failure = error.trajectory, error
    write_text(Path(path), _page(model, request, values, run, figures, names, traces, program))
    return failure


def _page(model: Playable, request: Request, values: Values, run: Trajectory, figures: Sequence[Figure], names: Mapping[str, str],
          traces: Sequence[str], program: bytes) -> str:
    scene = model.scene
    states = states_of(model, thinned(run, _LOOKS), values)
    in_space = is_in_space(model)
    stage = (build_space_stage if in_space else build_stage)(model.compilation, figures, states, names, traces)
    described = build_fmu_model(model, request.parameters)
    image = write_played(described, _solver(described), stage.drawing)
    experiment = plan(scene, request)
    length = experiment.stop - experiment.start
    size = float(np.max(np.subtract(stage.data["high"], stage.data["low"])))
    data = {**stage.data, **_shown(described), "controls": [*_given_inputs(described, values), *_controls(described, size)],
            "given": [*_given(described, values)],
            "inputs": _inputs(values), "n": scene.n, "movable": [*_movable(described, size)],
            "is_looped": _is_looped(described), "tolerance": experiment.tolerance, "start": scene.start,
            "stop": experiment.stop, "window": length, "speed": speed_of(length),
            "program": _packed(program), "image": _packed(image),
            "sizes": {"n": scene.n, "values": 1 + max(v.reference for v in described.of(*_NUMBERS)),
                      "drawing": sum(stage.drawing.out_sizes)}}
    own = [_SPATIAL, *VECTORS, _PLAYER, *SEEN_BY_HAND, _DRAG, _SPACE] if in_space else [_FLAT, _PLAYER, _DRAG, _PLANE]
    return written([*_OWN, *own], scene.description or scene.name, data)


_NUMBERS = ("time", "state", "slope", "output", "energy", "input", "parameter")  # groups of which the run time tells all


def _solver(described: FmuModel) -> int:
    """That of a run, but for islands, each of which has a model of its own there."""
    own = int(described.scene.sizes.get("solver", Solver.AUTO))
    return int(sizes_of(described)["solver"]) if own == Solver.ISLANDS else own


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def _unit(variable: Variable) -> tuple[str, float]:
    """What it is shown in, and how many of it one SI unit is."""
    unit = variable.display_unit or variable.unit
    return ("" if unit == "1" else unit), (_DEGREE if unit.startswith("deg") else 1.0)


def _shown(described: FmuModel) -> dict[str, Any]:
    """Curves, energies and quantities that are listed."""
    def told(variable: Variable, name: str = "") -> dict[str, Any]:
        unit, scale = _unit(variable)
        return {"name": name or variable.name, "ref": variable.reference, "unit": unit, "scale": scale}

    scene = described.scene
    signals, turned = scene.signals, scene.turned
    positions, rates = _states(described)
    outputs, energies = described.of("output"), described.of("energy")
    moving = [told(v, v.name if name in turned else f"{name}'") for name, v in rates if name not in signals]
    held = [told(v, signals[name]) for name, v in rates if name in signals]
    places, others = [told(v) for v in positions if v.name not in signals], [told(v) for v in outputs]
    return {"curves": [*places, *held, *others][:MOST_CURVES],
            "energies": [told(energies[k], name) for k, name in ((0, "T"), (1, "V"), (3, "dissipated"))],
            "shown": [*places, *moving, *held, *others][:_MOST_SHOWN] + [told(v) for v in energies]}


def _states(described: FmuModel) -> tuple[tuple[Variable, ...], list[tuple[str, Variable]]]:
    """Positions, with a quaternion for each attitude, and rates with the coordinates that they are of."""
    states, scene = described.of("state"), described.scene
    count = len(states) - scene.n
    return states[:count], list(zip((c.name for c in scene.coordinates), states[count:], strict=True))


def _controls(described: FmuModel, size: float) -> Iterator[dict[str, Any]]:
    """Sliders: parameters that are no consequence of others, start values."""
    given = dict(zip((v.reference for v in described.of("parameter")), described.given, strict=True))
    for v in described.of("parameter"):
        if v.causality == "parameter":
            yield _control("parameter", v, given[v.reference], 1.0)
    positions, _ = _states(described)
    parts = {name for parts in _quaternions(described.scene).values() for name in parts}
    for k, v in enumerate(described.of("state")):
        if v.initial != "calculated" and v.name not in described.scene.signals and v.name not in parts:
            reach = _RATE if k >= len(positions) else _TURN if _unit(v)[1] != 1.0 else size
            yield _control("start", v, described.state_start[k], reach)
    for name, own in _quaternions(described.scene).items():
        found = [described.named(part) for part in own]
        if all(v.initial != "calculated" for v in found):
            yield from _turns(name, found, [described.state_start[positions.index(v)] for v in found])


def _quaternions(scene: Scene) -> dict[str, list[str]]:
    """The four parts of each attitude, by its name."""
    return {name: [f"{name}[{k}]" for k in range(1, 5)] for name in scene.attitudes}


def _turns(name: str, parts: Sequence[Variable], quaternion: Sequence[float]) -> Iterator[dict[str, Any]]:
    """Sliders by which an attitude is turned from where it starts, rad about the axes of what it is counted against."""
    for axis in "xyz":
        yield {"kind": "start", "name": f"{name} about {axis}", "about": f"{parts[0].description}: turned from where it starts",
               "refs": [v.reference for v in parts], "quaternion": list(quaternion), "unit": "deg", "scale": _DEGREE,
               "value": 0.0, "low": -_TURN, "high": _TURN}


def _inputs(values: Values) -> dict[str, Any] | None:
    """Over time: their table, times first; None where they are constants."""
    if len(values.input_times) < 2:
        return None
    return {"rows": len(values.input_times),
            "table": base64.b64encode(np.array([*values.input_times, *values.input_values]).tobytes()).decode()}


def _given_inputs(described: FmuModel, values: Values) -> Iterator[dict[str, Any]]:
    """Sliders of inputs that do not move places; those that a table gives over time begin with its first row, and are held where
    they are moved."""
    columns = np.reshape(values.input_values, (len(values.input_times), -1)).T
    has_table = len(values.input_times) > 1
    moving = {place for piece in described.scene.pieces if piece[1] >= 0 for place in piece[:3]}  # what may not jump
    for k, (v, x) in enumerate(zip(described.of("input"), columns, strict=True)):
        if k in moving:
            continue
        first, most = (float(x[0]), float(np.abs(x).max())) if has_table else (float(v.start or 0.0), 1.0)
        yield _control("input", v, first, most or 1.0) | {"varies": bool(np.ptp(x) > 0)}


def _control(kind: str, variable: Variable, value: float, reach: float) -> dict[str, Any]:
    """From its lower limit, or 0 for what is positive, to its upper one, or three times what it is."""
    unit, scale = _unit(variable)
    least = 0.0 if kind == "parameter" and value > 0 else -max(reach, 3 * abs(value))
    low = least if variable.minimum is None else max(variable.minimum, least)
    most = 3 * value if kind == "parameter" and value > 0 else max(reach, 3 * abs(value))
    high = most if variable.maximum is None else min(variable.maximum, most)
    return {"kind": kind, "ref": variable.reference, "name": variable.name, "about": variable.description, "unit": unit,
            "scale": scale, "value": value, "low": min(low, value), "high": max(high, value)}


def _given(described: FmuModel, values: Values) -> Iterator[tuple[int, float]]:
    """Start values and inputs that were asked for; parameters are the scene's own already."""
    scene = described.scene
    asked = dict(zip((c.name for c in scene.coordinates), values.q, strict=True))
    positions, rates = _states(described)
    starts = [(v, asked[v.name]) for v in positions if v.name in asked]
    for name, parts in _quaternions(scene).items():
        turned = quaternion_of([asked[part] for part in scene.attitudes[name]])
        starts += zip((described.named(part) for part in parts), turned, strict=True)
    for v, x in (*starts, *zip((v for _, v in rates), values.v, strict=True)):
        if not math.isnan(x):
            yield v.reference, x
    if len(values.input_times) == 1:
        for v, x in zip(described.of("input"), values.input_values, strict=True):
            if x != v.start:
                yield v.reference, x


def _movable(described: FmuModel, size: float) -> Iterator[dict[str, Any]]:
    """Coordinates and attitudes that follow a part that is dragged, and by how much they move it about as far as the scene is
    large. Of loops those with fixed starts, or as many as are free, and one at least: the others follow from them."""
    scene = described.scene
    given = [(k, own) for k, own in _starts(described) if all(v.initial != "calculated" for v in own)]
    if _is_looped(described):
        free = max(1, scene.n - scene.sizes["n_holonomic"])
        given = [(k, own) for k, own in given if scene.fixed[k] == _FIXED] or _first(given, free)
    for _, own in given:
        is_angle = len(own) > 1 or _unit(own[0])[1] != 1.0
        yield {"refs": [v.reference for v in own], "size": 1.0 if is_angle else size}


def _starts(described: FmuModel) -> Iterator[tuple[int, list[Variable]]]:
    """What a start gives: the first coordinate of each, and the variables that tell it, one, or four of an attitude."""
    quaternions, k = {parts[0]: parts for parts in _quaternions(described.scene).values()}, 0
    rest = {part for parts in quaternions.values() for part in parts[1:]}
    for v in _states(described)[0]:
        if v.name in rest or v.name in described.scene.signals:
            k += v.name in described.scene.signals
            continue
        own = [described.named(part) for part in quaternions.get(v.name, [v.name])]
        yield k, own
        k += min(len(own), 3)


def _first(given: Sequence[tuple[int, list[Variable]]], free: int) -> list[tuple[int, list[Variable]]]:
    """Those that together are no more numbers than are free, an attitude three."""
    found = []
    for k, own in given:
        if (free := free - min(len(own), 3)) >= 0:
            found.append((k, own))
        else:
            break
    return found


def _is_looped(described: FmuModel) -> bool:
    return described.scene.sizes["n_holonomic"] > 0
