"""`--beside`: values of other runs in one picture, written one by one, as ranges, or in a table such as `lag sweep` writes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangia.base.cutting import cut_list
from lagrangia.base.diagnostics import fail
from lagrangia.command.arguments import assignment, values_with_units
from lagrangia.model import Model
from lagrangia.run.request import Request, check_values
from lagrangia.study.sweep.measures import read_measure
from lagrangia.study.sweep.values import Distribution, is_single, read_cell, read_runs, read_variation

if TYPE_CHECKING:
    import numpy as np

_MOST = 100  # runs in one picture
_OF_SWEEPS = ("run", "failure")  # columns of a sweep's table beside what is varied and measured
Labelled = tuple[str, Request]


def refuse_twice(option: str, given: Sequence[str]) -> None:
    """Raises LagError L0712 for a value that an option is given twice."""
    if (twice := next((text for text in given if given.count(text) > 1), None)) is not None:
        fail("L0712", f"{option} {twice} is given twice")


def requests_beside(model: Model, request: Request, given: Sequence[str]) -> list[Labelled]:
    """The same run but for these values, each with its label: k=2[kN/m],phi=5[deg], k=1:5:1, or a table. Raises LagError."""
    refuse_twice("--beside", given)
    found: list[Labelled] = []
    for text in given:
        found += _of_table(model, request, Path(text)) if is_table(text) else _of_values(model, request, text)
    if len(found) > _MOST:
        fail("L0706", f"--beside: {len(found)} runs in one picture are more than {_MOST}", None, "take fewer values")
    return found


def is_table(text: str) -> bool:
    """Whether `--beside TEXT` names a file."""
    return "=" not in text and text.lower().endswith(".csv")


def _of_values(model: Model, request: Request, text: str) -> Iterator[Labelled]:
    given = [assignment(item, "--beside") for item in cut_list(text) if item]
    if not given:
        fail("L0706", "--beside names nothing", None, "values with commas between them: --beside k1=2[kN/m],tilt.phi=5[deg]")
    names = [name for name, _ in given]
    if (twice := next((name for name in names if names.count(name) > 1), None)) is not None:
        fail("L0712", f"'{twice}' is given twice", None, "--beside takes each name once; a range is k=1:5:1")
    _refuse_structural(model, names)
    if all(is_single(value) for _, value in given):
        yield text, _changed(model, request, _single(model, given))
        return
    units = _units(model)
    for name in names:
        if name not in units:
            check_values(model.scene, {name: 0.0})  # which says what there is
    ways = [[(name, float(x)) for x in _range(name, value, units.get(name, ""))] if not is_single(value)
            else [*_single(model, [(name, value)]).items()] for name, value in given]
    for chosen in product(*ways):
        yield _label(chosen, units), _changed(model, request, dict(chosen))


def _single(model: Model, given: Sequence[tuple[str, str]]) -> dict[str, float]:
    return values_with_units(list(given), _units(model))


def _range(name: str, text: str, unit: str) -> "np.ndarray":
    found = read_variation(name, text, unit)
    if isinstance(found, Distribution):
        fail("L0706", f"--beside {name}={text}: random values belong to `lag sweep`", None,
             "its table can be shown: --beside NAME_sweep.csv")
    return found


def _of_table(model: Model, request: Request, path: Path) -> Iterator[Labelled]:
    """Of columns that name parameters or start values; what a sweep has measured is passed over."""
    names, rows = read_runs(path)
    units = _units(model)
    if (twice := next((name for name in names if names.count(name) > 1), None)) is not None:
        fail("L0713", f"the table '{path}' has two columns '{twice}'")
    _refuse_structural(model, names)
    known = [(k, name) for k, name in enumerate(names) if name in units]
    others = [name for name in names if name not in units and name not in _OF_SWEEPS and not _is_measured(name)]
    if others or not known:
        what = f"'{others[0]}' is" if others else "its columns are"
        fail("L0713", f"the table '{path}': {what} no parameter and no start value of the scene")
    for line, cells in rows:
        chosen = [(name, read_cell(path, line, name, cells[k], units[name])) for k, name in known]
        yield _label(chosen, units), _changed(model, request, dict(chosen))


def _is_measured(name: str) -> bool:
    return "(" in name and not name.startswith("der(") and bool(read_measure(name))


def _refuse_structural(model: Model, names: Sequence[str]) -> None:
    for name in names:
        if name in model.scene.structural:
            fail("L0918", f"not supported yet: the structural parameter '{name}' beside another run", None, "make two pictures")


def _units(model: Model) -> dict[str, str]:
    return {p.name: p.unit for p in model.scene.parameters} | dict(model.scene.start_units)


def _label(chosen: Sequence[tuple[str, float]], units: dict[str, str]) -> str:
    return ", ".join(f"{name} = {x:.6g} {units[name] if units[name] != '1' else ''}".rstrip() for name, x in chosen)


def _changed(model: Model, request: Request, values: dict[str, float]) -> Request:
    scene = model.scene
    starts = {name: x for name, x in values.items() if name in scene.start_units}
    others = {name: x for name, x in values.items() if name not in scene.start_units}
    changed = replace(request, parameters={**(request.parameters or {}), **others}, initial={**(request.initial or {}), **starts})
    check_values(scene, changed.parameters, changed.initial, changed.inputs)
    return changed
