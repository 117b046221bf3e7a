"""`lag simulate --plot`: what the picture shows, the runs and tables beside the run -> the file."""

import sys
from argparse import Namespace
from pathlib import Path

from lagrangia.base.cutting import cut_pair
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.records import dataclass
from lagrangia.command.arguments import names_once
from lagrangia.command.beside import refuse_twice, requests_beside
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
    tables = tuple(table_series(Path(name), sight, wanted) for name in options.overlay)
    runs = tuple(requests_beside(model, request, options.beside))
    return Planned(wanted, tables, runs)


def _section(text: str | None, sight: Sight) -> tuple[str, float] | None:
    """`theta`, where it rises through 0, or `theta=30[deg]`."""
    if text is None:
        return None
    name, sign, value = cut_pair(text)
    name = read_pair(name).y
    if not value and sign:
        fail("L0706", f"--section {text}: a value is missing", None, "--section theta=30[deg]")
    try:
        level = read_value(value or "0", sight.columns_of(name)[0].unit)
    except ValueError as error:
        fail("L0706", f"--section {text}: {error}")
    if isinstance(level, list):
        fail("L0706", f"--section {text}: one number is needed")
    return name, level


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
