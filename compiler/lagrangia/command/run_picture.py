"""`lag simulate --plot`: what the picture shows, the runs and tables beside the run -> the file."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.records import dataclass
from lagrangia.command.arguments import assignments, names_once, split_names, values_with_units
from lagrangia.language.values import read_value
from lagrangia.model import Model
from lagrangia.run.request import Request, check_values
from lagrangia.view.curves import draw_panels
from lagrangia.view.plots import Series, Wanted, read_pair
from lagrangia.view.run_pictures import choose, picture_of, table_series
from lagrangia.view.sight import Sight
from lagrangia.view.trajectory import Trajectory


@dataclass(frozen=True)
class Planned:
    """A picture before the run: what it shows, tables beside it, and further runs by their labels."""

    wanted: Wanted
    tables: tuple[Series, ...]
    runs: tuple[tuple[str, Request], ...]


def plan_picture(options: Namespace, model: Model, request: Request) -> Planned:
    """Raises LagError for what cannot be shown."""
    sight = model.sight(check_values(model.scene, request.parameters, request.initial, request.inputs))
    names, spectra = names_once(options.plot_quantities, "--plot-quantities"), names_once(options.spectrum, "--spectrum")
    wanted = choose(model.scene, sight, names, spectra, _section(options.section, sight))
    refuse_twice("--overlay", options.overlay)
    refuse_twice("--beside", options.beside)
    tables = tuple(table_series(Path(name), sight, wanted) for name in options.overlay)
    runs = tuple((text, beside_request(model, request, text)) for text in options.beside)
    return Planned(wanted, tables, runs)


def refuse_twice(option: str, given: Sequence[str]) -> None:
    """Raises LagError L0712 for a value that an option is given twice."""
    if (twice := next((text for text in given if given.count(text) > 1), None)) is not None:
        fail("L0712", f"{option} {twice} is given twice")


def _section(text: str | None, sight: Sight) -> tuple[str, float] | None:
    """`theta`, where it rises through 0, or `theta=30[deg]`."""
    if text is None:
        return None
    name, _, value = text.partition("=")
    name = read_pair(name).y
    if not value and "=" in text:
        fail("L0706", f"--section {text}: a value is missing", None, "--section theta=30[deg]")
    try:
        level = read_value(value or "0", sight.columns_of(name)[0].unit)
    except ValueError as error:
        fail("L0706", f"--section {text}: {error}")
    if isinstance(level, list):
        fail("L0706", f"--section {text}: one number is needed")
    return name, level


def beside_request(model: Model, request: Request, text: str) -> Request:
    """The same run but for these values, of parameters and start values: k=2[kN/m],phi=5[deg]. Raises LagError."""
    scene, given = model.scene, assignments(split_names(text), "--beside")
    if not given:
        fail("L0706", "--beside names nothing", None, "values with commas between them: --beside k1=2[kN/m],tilt.phi=5[deg]")
    for name, _ in given:
        if name in scene.structural:
            fail("L0918", f"not supported yet: the structural parameter '{name}' beside another run", None, "make two pictures")
    starts = values_with_units([(n, v) for n, v in given if n in scene.start_units], scene.start_units)
    others = [(n, v) for n, v in given if n not in scene.start_units]
    parameters = values_with_units(others, {p.name: p.unit for p in scene.parameters})
    changed = Request(request.start, request.stop, request.tolerance, request.interval, request.at, request.solver,
                      request.max_step, request.max_steps, {**(request.parameters or {}), **parameters},
                      {**(request.initial or {}), **starts}, request.inputs)
    check_values(scene, changed.parameters, changed.initial, changed.inputs)
    return changed


def draw_picture(options: Namespace, planned: Planned, model: Model, run: Trajectory) -> RunError | None:
    """Writes the file, and says what could not be shown.

    Returns the error of a run beside that failed, which is shown as far as it went, or of small motion about nothing.
    Raises LagError."""
    assert run.sight is not None
    failures = []
    beside = []
    for label, request in planned.runs:
        try:
            other = model.run(request)
        except RunError as error:
            if error.trajectory is None or not len(error.trajectory.rows):
                raise
            other = error.trajectory
            failures.append(f"--beside {label}: {error}")
        beside.append(other.series(label))
    try:
        picture = picture_of(run.series(), run.rows, run.sight, planned.wanted, [*beside, *planned.tables], options.linear)
    except RunError as error:  # small motion about nothing
        return RunError(f"--linear: {error}\nno picture was drawn")
    draw_panels(run.scene.description or run.scene.name, picture.panels, options.plot)
    for note in picture.notes:
        print(f"note: {note}", file=sys.stderr)
    return RunError("\n".join([*failures, "what was computed before is shown in the picture"])) if failures else None
