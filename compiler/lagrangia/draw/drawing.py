"""`Model.draw` and `lag draw`: a run to the moment that is asked for, its page, files."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.result_files import Target, write_text
from lagrangia.compile.pipeline import Compilation, flatten_file
from lagrangia.draw.drive_train import names_elsewhere, with_train
from lagrangia.draw.page import Page
from lagrangia.draw.picture import draw_page
from lagrangia.draw.svg import write_svg
from lagrangia.draw.tikz import write_tikz
from lagrangia.draw.values import States
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.flat import Figure
from lagrangia.run.origin import Origin
from lagrangia.run.request import Request, check_values
from lagrangia.run.scene import Scene
from lagrangia.view.curves import own_style
from lagrangia.view.rows import moments
from lagrangia.view.trajectory import Trajectory

if TYPE_CHECKING:
    from lagrangia.run.request import Values

FORMATS = (".svg", ".pdf", ".png", ".tex")
_MOMENTS = 300  # at which a motion that ends early is looked at


class Located(Protocol):
    """Which model it is, and of which file."""

    origin: Origin
    model: str | None
    structural: dict[str, Any]


class Drawable(Located, Protocol):
    """What a picture needs of a Model."""

    scene: Scene

    @property
    def compilation(self) -> Compilation:
        """What each phase of the compiler made."""
    def fitting(self, parameters: Mapping[str, float] | None) -> "Drawable":
        """It, or the same in the formulas that these parameters need."""
    def run(self, request: Request) -> Trajectory:
        """The motion. Raises LagError, RunError."""


def draw_scene(model: Drawable, path: str | os.PathLike[str] | None, request: Request, names: Mapping[str, str],
               tell: Callable[[str], None] | None = None) -> str:
    """The text of an SVG, at the request's last time; the file as well where a path is given. `tell` hears of what is empty.

    Raises LagError; RunError where the motion ends before, of which the last moment is drawn."""
    if path is not None:
        require_picture(path)
    page, failure = page_of(model, request, names)
    if not page.paths and not page.labels and tell is not None:
        tell("nothing in this scene has a drawing: `lag help drawing` says how to give it one")
    return finished(page, path, failure)


def finished(page: Page, path: str | os.PathLike[str] | None, failure: RunError | None) -> str:
    """The text of a page as SVG, and its file where a path is given. Raises LagError; RunError for the failure."""
    text = write_svg(page)
    if path is not None:
        save_page(page, text, Path(path))
    if failure is not None:
        where = "" if path is None else f"\nwhat was computed before is drawn in {path}"
        raise RunError(f"{failure}{where}")
    return text


def page_of(model: Drawable, request: Request, names: Mapping[str, str]) -> tuple[Page, RunError | None]:
    """The page of a scene where the request's last time is, or at its start; or where the motion ends before, and why.

    Raises LagError; RunError where nothing was computed."""
    model, states, failure = moment_of(model, request)
    flat = model.compilation.flat
    page = draw_page(model.compilation, figures_of(model), states, names_elsewhere(flat, names))
    return with_train(page, flat, names), failure


def moment_of(model: Drawable, request: Request) -> tuple[Drawable, States, RunError | None]:
    """The model in the formulas that the request needs, and its state at the request's last time, or at its start; or where the
    motion ends before, and why. Raises LagError; RunError where nothing was computed."""
    begin = model.scene.start if request.at is None else request.at[-1]
    asked = Request(at=[begin], parameters=request.parameters, initial=request.initial, inputs=request.inputs)
    model = model.fitting(request.parameters)
    run, failure = _run_until(model, asked, begin)
    values = check_values(model.scene, request.parameters, request.initial, request.inputs)
    return model, states_of(model, run, values), failure


def _run_until(model: Drawable, asked: Request, end: float) -> tuple[Trajectory, RunError | None]:
    try:
        return model.run(asked), None
    except RunError:
        if end <= model.scene.start:
            raise
    failure = None
    try:  # again, with moments before
        run = model.run(replace(asked, at=np.linspace(model.scene.start, end, _MOMENTS).tolist()))
    except RunError as error:
        if error.trajectory is None or not len(error.trajectory.rows):
            raise
        run, failure = error.trajectory, error
    return replace(run, rows=run.rows[-1:]), failure


def figures_of(model: Located) -> tuple[Figure, ...]:
    """All figures of a scene, those of the library as well. Raises LagError."""
    return check_dimensions(flatten_file(model.origin.unchanged(), model.model, model.structural, is_drawn=True)[1]).figures


def states_of(model: Drawable, run: Trajectory, values: "Values") -> States:
    """The moments of a run."""
    return States(*moments(model.scene, np.array(run.progress.parameters), values, run.rows))


def require_picture(path: str | os.PathLike[str]) -> None:
    """Raises LagError L0004 for a file whose name ends in no format of drawings."""
    if Path(path).suffix.lower() not in FORMATS:
        fail("L0004", f"'{path}' is no drawing that can be written", None, f"its name should end in {', '.join(FORMATS)}")


def save_page(page: Page, text: str, path: Path) -> None:
    """Writes the file, as its name ends. Raises LagError L0004 where it cannot be written."""
    if path.suffix.lower() in (".svg", ".tex"):
        write_text(path, text if path.suffix.lower() == ".svg" else write_tikz(page))
        return
    from lagrangia.draw.paint import paint_page

    with own_style(), Target(path, binary=True) as target:
        paint_page(page).savefig(target.stream, dpi=300, format=path.suffix[1:].lower())
